#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# `dermap calibrate --stray-light`: two sessions of a white and a black target to the keys of a rig, which a session of skin is
# then calibrated by. The bench's own numbers are the truth; what does not tell them is refused.
# Usage: calibrate_stray_light_test.sh DERMAP MAKE_INPUTS ROOT
set -uo pipefail
# shellcheck source=harness.sh
. "$(dirname "$0")/harness.sh" "$@"

rig=$root/config/rigs/simulated_8band.toml
printf 'black_frames = 1\nspectralon_frames = 1\nskin_frames = 1\nadapt_exposure = false\n' >plan.toml
for slot in 1 5; do printf '[[exposure]]\nslot = %s\nexposure_ms = 10\niso = 125\n' $slot >>plan.toml; done
capture() { # capture FOLDER REFLECTANCE [BENCH_KEYS]
  printf 'seed = 4\nflat_reflectance = %s\n[bench]\nstray_light = 0.015\npolarizer_leak = 0.01\n%b' "$2" "${3:-}" >"$1.toml"
  run capture plan.toml --rig "${4:-$rig}" --out "$1" --scene "$1.toml"
  [ "$code" -eq 0 ] || { complain "capture of $1: $(cat .stderr)"; finish; }
}
still='motion_shift_mm = 0.05\nmotion_rotation_deg = 0.1\n'
capture white 0.8 "$still"
capture black 0.0001 "$still"
capture gray 0.5

# near VALUE EXPECTED WITHIN WHAT
near() {
  awk -v v="$1" -v e="$2" -v w="$3" 'BEGIN { exit !(v != "" && v - e < w && e - v < w) }' ||
    complain "$4 is '$1', expected $2 within $3"
}
key() { sed -n "s/^$1 = //p" "$2"; }

accepts 0 -- calibrate white --stray-light --dark-target black --dark-reflectance 0.0001 --dark-reflectance-sigma 0.0001 -o s.toml
near "$(key stray_light s.toml)" 0.015 0.001 stray_light
near "$(key stray_light_sigma s.toml)" 0.0003 0.0003 stray_light_sigma
near "$(key leak s.toml)" 0.01 0.001 leak
accepts 0 -- calibrate white --stray-light --dark-target black -o t.toml --json
grep -q '"stray_light_sigma"' .stdout || complain "no sigma in the JSON: $(cat .stdout)"
grep -q leak t.toml && complain "a leak that nobody asked for"

# The keys as they stand, in a rig; the same frames through it.
grep '^stray_light' s.toml >share
{ cat "$rig" && sed -n '/^\[polarization\]/,$p' s.toml && echo 'sign = 0'; } | sed '/^\[calibration\]/r share' >rig.toml
reflectance() { sed -n 's/.*450.0 nm  reflectance \([0-9.]*\).*/\1/p' .stdout; }
accepts 0 -- calibrate gray -o plain.exr
awk -v r="$(reflectance)" 'BEGIN { exit !(r > 0.505 || r < 0.495) }' || complain "stray light and leak do nothing: $(reflectance)"
capture own 0.5 '' rig.toml
accepts 0 -- calibrate own -o own.exr
near "$(reflectance)" 0.5 0.002 'reflectance with the measured keys'

# --- what does not tell it
refuses 2 x.toml 'equally bright|--dark-target' -- calibrate white --stray-light -o x.toml
refuses 2 x.toml 'darkest target|--dark-reflectance' -- calibrate white --dark-target gray --stray-light --dark-reflectance 0 -o x.toml
refuses 2 x.toml 'nowhere' -- calibrate white --dark-target nowhere --stray-light -o x.toml
refuses 2 x.toml 'dark-reflectance' -- calibrate white --stray-light --dark-target black --dark-reflectance nan -o x.toml
refuses 2 x.toml 'dark-reflectance' -- calibrate white --stray-light --dark-target black --dark-reflectance -1 -o x.toml
refuses 2 x.toml 'stray-light' -- calibrate white --dark-target black -o x.toml
refuses 2 x.toml 'two measurements' -- calibrate white --stray-light --polarization -o x.toml
refuses 2 x.toml 'no window|x.failure.png' -- calibrate black --stray-light -o x.toml
rm "$(echo black/frames/*skin_450nm.dng)"
refuses 2 x.toml 'skin_450nm.dng|x.failure.png' -- calibrate white --stray-light --dark-target black -o x.toml

finish
