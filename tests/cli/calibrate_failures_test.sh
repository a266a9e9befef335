#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Sessions whose frames are not what they say, through `dermap calibrate`: exit code 2, one sentence that names frame and
# finding, a picture of it, and nothing that looks like a result.
# Usage: calibrate_failures_test.sh DERMAP MAKE_INPUTS ROOT
set -uo pipefail
# shellcheck source=harness.sh
. "$(dirname "$0")/harness.sh" "$@"

# --- a good session of two bands, and frames of others to put in the place of its own
rig=$root/config/rigs/simulated_8band.toml
plan() { # plan ISO
  printf 'black_frames = 1\nspectralon_frames = 1\nskin_frames = 1\n'
  printf '[[exposure]]\nslot = %s\nexposure_ms = 10\niso = %s\n' 1 "$1" 5 "$1"
}
red_plan() { plan "$1" | sed 's/slot = 5/slot = 7/'; } # 610 nm in the place of 560 nm
plan 125 >plan.toml
red_plan 125 >red.toml
{ echo 'adapt_exposure = false' && red_plan 3200; } >red_bright.toml
{ echo 'adapt_exposure = false' && plan 6400; } >bright.toml
capture() { # capture FOLDER PLAN RIG [SCENE]
  run capture "$2" --rig "$3" --out "$1" --scene "${4:-$root/config/scenes/gray_50.toml}"
  [ "$code" -eq 0 ] || { complain "capture of $1: $(cat .stderr)"; finish; }
}
sed 's/^gray_card_region = .*/gray_card_region = [0.80, 0.45, 0.14, 0.5]/' "$rig" >lower_card.toml
printf '[bench]\nmisfired_shots = [4]\n' | cat "$root/config/scenes/gray_50.toml" - >misfire.toml
capture good plan.toml "$rig"
capture bright bright.toml "$rig"
capture red red.toml "$rig"
capture red_bright red_bright.toml "$rig"
capture lower_card plan.toml lower_card.toml
capture misfire plan.toml "$rig" misfire.toml

frame() { echo "$1"/frames/*_"$2".dng; } # frame SESSION ROLE_WAVELENGTH
fresh() { rm -rf bad && cp -r good bad; }
swap() { # swap A B: two frames of the session `bad`
  local a b
  a=$(frame bad "$1") b=$(frame bad "$2")
  mv "$a" swapped && mv "$b" "$a" && mv swapped "$b"
}

# shows WORDS: the session `bad` is refused with those words, and a picture is left.
shows() {
  refuses 2 out.exr "$1|out.failure.png" -- calibrate bad -o out.exr --no-verify
  [ "$(head -c 8 out.failure.png 2>/dev/null | od -An -tx1 | tr -d ' ')" = 89504e470d0a1a0a ] || complain "$1: no picture"
  [ -e out.calibration.json ] && complain "$1: left a record"
  rm -f out.*
}

accepts 0 -- calibrate good -o good.exr

# --- swapped
fresh && swap skin_450nm spectralon_450nm
refuses 2 out.exr '450nm.dng|SHA-256' -- calibrate bad -o out.exr # what the manifest remembers gives it away at once
shows 'spectralon_450nm.dng|as a skin frame does'
fresh && cp "$(frame good spectralon_450nm)" "$(frame bad skin_450nm)"
shows 'skin_450nm.dng|no window in this skin frame'
fresh && swap skin_450nm skin_560nm
shows 'nm.dng|filter was out of order'
fresh && swap skin_450nm skin_560nm && swap spectralon_450nm spectralon_560nm
shows 'compare the wheel'
fresh && cp "$(frame good spectralon_450nm)" "$(echo bad/frames/0001_black*)"
shows '0001_black|black frame is lit'

# --- missing: the picture is of the session as it was found
fresh && rm "$(frame bad skin_560nm)"
refuses 2 out.exr 'skin_560nm.dng|out.failure.png' -- calibrate bad -o out.exr
[ -s out.failure.png ] || complain "no picture of a session that lacks a file"
shows 'skin_560nm.dng|no such file'
fresh && truncate -s 100000 "$(frame bad skin_560nm)"
shows 'skin_560nm.dng'
# lost ROLE_WAVELENGTH: the frame's record goes from the manifest, as if it had never been taken.
lost() {
  python3 - "$1" <<'PYTHON'
import json, sys
manifest = json.load(open("bad/session.json"))
manifest["frames"] = [f for f in manifest["frames"] if sys.argv[1] not in f["file"]]
json.dump(manifest, open("bad/session.json", "w"))
PYTHON
}
fresh && lost spectralon_450nm
shows 'no Spectralon frame for 450 nm'
fresh && lost black
shows 'black'
# A band that was never taken is left out by name, with the same picture.
fresh && lost skin_450nm
accepts 0 -- calibrate bad -o out.exr
grep -q 'no skin frame at 450 nm' .stdout || complain "a band that was never taken is not named: $(cat .stdout)"
[ -s out.missing.png ] || complain "no picture of a session that lacks a band"
rm -rf out.*
# Files that a TOML names are looked for as well.
printf '[[frame]]\nfile = "nowhere.dng"\nrole = "black"\n' >files.toml
refuses 2 out.exr 'nowhere.dng|no such file|out.failure.png' -- calibrate --from-folder files.toml -o out.exr
rm -rf out.*

# --- numbers that are none
for option in --spectralon-factor --edge-mask-px; do
  refuses 2 out.exr "$option|nan" -- calibrate good -o out.exr $option nan
done

# --- tables that cannot be: percent, none, a band that they do not reach; negative light
table() { # table KEY NAME CONTENTS: a CSV of the session's own
  fresh && printf "$3" >"bad/$2"
  sed -i "s|\"$1\": \"[^\"]*\"|\"$1\": \"$work/bad/$2\"|" bad/session.json
}
refused() { refuses 2 out.exr "$1" -- calibrate bad -o out.exr; }
table spectralon_csv cert.csv 'wavelength_nm,reflectance\n400,99\n700,99\n' && refused 'cert.csv|divide percent by 100'
table spectralon_csv cert.csv 'wavelength_nm,reflectance\n400,0.99\n700,-0.99\n' && refused 'cert.csv|-0.99'
table spectralon_csv cert.csv 'wavelength_nm,reflectance\n400,nan\n700,0.99\n' && refused 'cert.csv|nan'
table spectralon_csv cert.csv 'wavelength_nm,reflectance\n500,0.99\n700,0.99\n' && refused 'from 500 to 700 nm|450 nm'
table flash_csv flash.csv 'wavelength_nm,relative_power\n400,1\n700,-1\n' && refused 'flash.csv|-1'
table flash_csv flash.csv 'wavelength_nm,relative_power\n400,1\n700,1e300\n' && refused 'flash.csv|1e+300'

# --- dark: a flash that did not fire; a cap on the lens is a black frame in a lit one's place
cp -r misfire bad_flash && rm -rf bad && mv bad_flash bad
shows 'flash did not fire'
fresh && cp "$(echo good/frames/0001_black*)" "$(frame bad skin_450nm)"
shows 'skin_450nm.dng|flash did not fire|lens cap'

# --- saturated, moved
fresh && cp "$(frame bright spectralon_560nm)" "$(frame bad spectralon_560nm)"
shows 'spectralon_560nm.dng|saturated'
# At 610 nm red alone is: the other colours still tell a ratio, which must not be read as a flash that failed.
rm -rf bad && cp -r red bad && cp "$(frame red_bright spectralon_610nm)" "$(frame bad spectralon_610nm)"
shows 'spectralon_610nm.dng|Spectralon is saturated'
fresh && cp "$(frame lower_card skin_450nm)" "$(frame bad skin_450nm)"
shows 'skin_450nm.dng|gray card moved'

finish
