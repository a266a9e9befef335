#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Sensors of every filter pattern through `dermap capture` and `dermap calibrate`: a gray patch of 50 % comes out as 0.5, and
# the record says what each step did.
# Usage: calibrate_mosaics_test.sh DERMAP MAKE_INPUTS ROOT
set -uo pipefail
# shellcheck source=harness.sh
. "$(dirname "$0")/harness.sh" "$@"

printf 'black_frames = 1\nspectralon_frames = 1\nskin_frames = 1\n[[exposure]]\nslot = 4\nexposure_ms = 10\niso = 100\n' >plan.toml
for filters in rggb xtrans none; do
  { cat "$root/config/scenes/gray_50.toml" && printf '[bench]\nfilters = "%s"\n' $filters; } >$filters.toml
  accepts 0 -- capture plan.toml --rig "$root/config/rigs/simulated_8band.toml" --out $filters --scene $filters.toml
  accepts 0 -- calibrate $filters -o $filters.exr --check
  # 0.5 within 0.003: 0.002 is what was asked of patches, the rest is the flash's drift in one frame.
  grep -qE '^ *540\.0 nm  reflectance 0\.(49[789]|50[0123])' .stdout || complain "$filters: $(head -1 .stdout)"
  for step in black hot-photosites linearity stray-light flash-drift certificate polarization leak gel \
    effective-wavelength alignment; do
    grep -q "\"step\": \"$step\"" $filters.calibration.json || complain "$filters: the record lacks $step"
  done
  [ -s $filters.check.png ] || complain "$filters: no picture of the check"
done
# The same raw files without the manifest.
for filters in xtrans none; do
  { printf 'rig = "%s"\n' "$root/config/rigs/simulated_8band.toml"
    for frame in $filters/frames/*.dng; do
      case $frame in *black*) role=black ;; *spectralon*) role=spectralon ;; *) role=skin ;; esac
      printf '[[frame]]\nfile = "%s"\nrole = "%s"\n' "$frame" $role
      [ $role = black ] || echo 'wavelength_nm = 540'
    done; } >files.toml
  accepts 0 -- calibrate --from-folder files.toml -o foreign.exr
  grep -qE '^ *540\.0 nm  reflectance 0\.(49[789]|50[0123])' .stdout || complain "$filters by --from-folder: $(head -1 .stdout)"
done
finish
