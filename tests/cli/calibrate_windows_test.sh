#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Windows that are not the one expected, through `dermap calibrate`: none, two, a round one, one of another size, one behind
# which the skin lies elsewhere; and a faint band. What no band can mend is an error that names frame and finding; a single
# band that does not fit the others is dropped by name, with exit code 1.
# Usage: calibrate_windows_test.sh DERMAP MAKE_INPUTS ROOT
set -uo pipefail
# shellcheck source=harness.sh
. "$(dirname "$0")/harness.sh" "$@"

rig=$root/config/rigs/simulated_8band.toml
printf 'black_frames = 1\nspectralon_frames = 1\nskin_frames = 1\nadapt_exposure = false\n' >plan.toml
for slot in 1 4 6; do printf '[[exposure]]\nslot = %s\nexposure_ms = 10\niso = 125\n' $slot >>plan.toml; done
# capture FOLDER SCENE BENCH_KEYS [RIG]
capture() {
  { cat "$root/config/scenes/$2" && printf '[bench]\n%b\n' "$3"; } >"$1.toml"
  run capture plan.toml --rig "${4:-$rig}" --out "$1" --scene "$1.toml"
  [ "$code" -eq 0 ] || { complain "capture of $1: $(cat .stderr)"; finish; }
}
# shows SESSION WORDS: refused with those words, and a picture is left.
shows() {
  refuses 2 out.exr "$2|out.failure.png" -- calibrate "$1" -o out.exr --no-verify
  [ "$(head -c 8 out.failure.png 2>/dev/null | od -An -tx1 | tr -d ' ')" = 89504e470d0a1a0a ] || complain "$1: no picture"
  rm -rf out.*
}
# drops SESSION WAVELENGTH WORDS: that band is named and left out of the stack, the others are there.
drops() {
  local word IFS='|'
  accepts 1 -- calibrate "$1" -o out.exr --no-verify
  grep -qE "^ *$2\.0 nm .*DROPPED" .stdout || complain "$1: $2 nm is not named as dropped: $(cat .stdout)"
  for word in $3; do grep -qF -- "$word" .stdout || complain "$1: '$word' is not in: $(cat .stdout)"; done
  [ "$(grep -c DROPPED .stdout)" -eq 1 ] || complain "$1: other bands were dropped too: $(cat .stdout)"
  grep -qa "T\.$2,000000nm" out.exr && complain "$1: $2 nm is in the stack"
  [ "$(grep -ao 'T\.[0-9]*,000000nm' out.exr | sort -u | wc -l)" -eq 2 ] || complain "$1: not two bands in the stack"
  rm -rf out.*
}
frame() { echo "$1"/frames/*_"$2".dng; } # frame SESSION ROLE_WAVELENGTH
# Puts a band's two frames of another session into the place of the good one's own.
mix() { # mix OTHER WAVELENGTH
  rm -rf mixed && cp -r good mixed
  cp "$(frame "$1" "skin_$2nm")" "$(frame mixed "skin_$2nm")"
  cp "$(frame "$1" "spectralon_$2nm")" "$(frame mixed "spectralon_$2nm")"
}

scale='scale_px_per_mm = 20.0\nwindow_center_px = [150.0, 179.5]'
capture good light_freckles.toml "$scale"
accepts 0 -- calibrate good -o good.exr

# --- for the whole session
capture two light_freckles.toml "$scale\nsecond_window_mm = 4.0"
shows two '_skin_|2 windows in the tape were found, expected one'
capture round light_freckles.toml "$scale\ncorner_radius_mm = 3.75"
shows round 'no window in the tape was found|none of them a square'
capture cut_off light_freckles.toml 'scale_px_per_mm = 20.0\nwindow_center_px = [70.0, 179.5]'
shows cut_off 'no window in the tape was found|whole window is in view'
sed 's/^window_mm = .*/window_mm = 0.6/' "$rig" >tiny_rig.toml
capture tiny light_freckles.toml "$scale" tiny_rig.toml
shows tiny 'no window in the tape was found'

# --- for one band
sed 's/^window_mm = .*/window_mm = 6.5/' "$rig" >smaller_rig.toml
capture smaller light_freckles.toml "$scale" smaller_rig.toml
mix smaller 540
drops mixed 540 'left out: its window is|photosites wide, that of the other bands'
capture moved light_freckles.toml "$scale\nstretch_mm = 0.4"
mix moved 540
drops mixed 540 'left out: lies|px off the other bands inside the window'

finish
