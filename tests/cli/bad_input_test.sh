#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Bad input to every command: one sentence that names the file, the documented exit code (docs/formats.md), nothing
# half-written. Usage: bad_input_test.sh DERMAP MAKE_INPUTS ROOT
set -uo pipefail
# shellcheck source=harness.sh
. "$(dirname "$0")/harness.sh" "$@"

mkdir in
"$make_inputs" in || exit 1
printf '\x89PNG\r\n\x1a\n0000IHDR' >in/picture.exr
echo 'wavelength,reflectance' >in/text.exr
: >in/empty.exr
echo file >in/file
fast=(--method descent --max-iterations 1 --profiles multipole --size 16)

# --- usage
refuses 2 - 'unknown command' -- fitt
refuses 2 - 'in/good.exr' -- fit in/good.exr in/good.exr -o out
refuses 2 out '--help' -- fit in/good.exr -o out --no-such-flag
refuses 2 out 'STACK' -- fit -o out
refuses 2 out 'ceres|fast|descent' -- fit in/good.exr -o out --method newton
refuses 2 out 'nonsense' -- fit in/good.exr -o out --profiles nonsense
refuses 2 out '--pixel-size-mm' -- fit in/no_pixel_size.exr -o out --pixel-size-mm nan

# --- fit: stacks that are missing, foreign, damaged or of the wrong shape
refuses 2 out 'in/none.exr|No such file' -- fit in/none.exr -o out
refuses 2 out 'in|folder' -- fit in -o out
refuses 2 out 'in/picture.exr|not an OpenEXR file' -- fit in/picture.exr -o out
refuses 2 out 'in/text.exr|not an OpenEXR file' -- fit in/text.exr -o out
refuses 2 out 'in/empty.exr' -- fit in/empty.exr -o out
refuses 2 out 'in/truncated.exr|damaged or incomplete|remedy' -- fit in/truncated.exr -o out
refuses 2 out 'in/maps.exr|no reflectance channel|C_m' -- fit in/maps.exr -o out
refuses 2 out 'in/per_cent.exr|fraction' -- fit in/per_cent.exr -o out
refuses 2 out 'in/all_nan.exr' -- fit in/all_nan.exr -o out
refuses 2 out '--pixel-size-mm' -- fit in/no_pixel_size.exr -o out
cp in/good.exr in/good.tif
refuses 2 out 'in/good.tif|.exr' -- fit in/good.tif -o out
head -c 100 in/good.img >in/short.img
sed 's/^dermap sigma.*//' in/good.hdr >in/short.hdr
refuses 2 out 'in/short.img has 100 bytes' -- fit in/short.hdr -o out

# --- configuration
printf '[tissue]\nepidermis_thicknes_mm = 0.2\n' >in/unknown_key.toml
refuses 2 out 'in/unknown_key.toml line 2|epidermis_thickness_mm' -- fit in/good.exr -o out --config in/unknown_key.toml
printf '[tissue]\nn_dermis = 5\n' >in/range.toml
refuses 2 out 'in/range.toml|n_dermis' -- fit in/good.exr -o out --config in/range.toml
printf '[tissue\n' >in/not.toml
refuses 2 out 'in/not.toml line 1' -- fit in/good.exr -o out --config in/not.toml
refuses 2 out 'in/none.toml' -- render in/maps.exr -o out.exr --config in/none.toml

# --- what is odd but good is accepted: missing pixels, one band, a pixel size by hand
accepts '0|1' -- fit in/some_nan.exr -o out_nan "${fast[@]}"
accepts '0|1' -- fit in/one_band.exr -o out_band "${fast[@]}"
accepts '0|1' -- fit in/no_pixel_size.exr -o out_size --pixel-size-mm 0.3 "${fast[@]}"
for out in out_nan out_band out_size; do
  for file in maps.exr sigma.exr predicted.exr residual.exr flags.exr fit.json; do
    [ -s "$out/$file" ] || complain "fit made no $out/$file"
  done
done

# --- fit: tables of spectra
bands=R400,R440,R480,R520,R560,R600,R640,R680
numbers=0.1,0.12,0.15,0.2,0.2,0.3,0.35,0.4
table() { printf "$1" >in/spectra.csv; }
table "id,$bands\na,$numbers\n"
refuses 2 out 'in/none.csv|No such file' -- fit in/none.csv -o out
refuses 2 out "veins|vessels" -- fit in/spectra.csv -o out --model veins
refuses 2 out '--aperture-mm|-8' -- fit in/spectra.csv -o out --aperture-mm=-8
refuses 2 out '--noise|two' -- fit in/spectra.csv -o out --noise two
refuses 2 out '--range-nm' -- fit in/spectra.csv -o out --range-nm 700,400
refuses 2 out 'in/spectra.csv|8' -- fit in/spectra.csv -o out --range-nm 500,600
refuses 2 out '--method' -- fit in/spectra.csv -o out --method fast
refuses 2 out 'in/range.toml|n_dermis' -- fit in/spectra.csv -o out --config in/range.toml
for last in '' nan text 40 0.4,0.4 -0.5; do
  table "id,$bands\na,$numbers\nb,0.1,0.12,0.15,0.2,0.2,0.3,0.35,$last\n"
  refuses 2 out 'in/spectra.csv line 3' -- fit in/spectra.csv -o out
done
table "id,R500,R450\na,0.1,0.1\n"
refuses 2 out 'in/spectra.csv line 1|450' -- fit in/spectra.csv -o out
refuses 2 out 'in/one_band.exr|8' -- fit --spectra in/one_band.exr -o out
table "id,$bands\na,10,12,15,20,20,30,35,40\n"
accepts '0|1' -- fit in/spectra.csv -o out_spectra --percent --model core --threads 1
for file in spectra.csv spectra.json report.html; do
  [ -s "out_spectra/$file" ] || complain "fit of spectra made no out_spectra/$file"
done
refuses 4 out 'in/file' -- fit in/spectra.csv -o in/file/out --percent --model core

# --- render
refuses 2 out.exr 'in/none.exr' -- render in/none.exr -o out.exr
refuses 2 out.exr 'in/good.exr|C_m' -- render in/good.exr -o out.exr
refuses 2 out.exr 'in/truncated.exr' -- render in/truncated.exr -o out.exr
refuses 2 out.exr 'C_x' -- render in/maps.exr -o out.exr --edit 'C_x*=2'
refuses 2 out.exr 'C_m' -- render in/maps.exr -o out.exr --edit 'C_m*=two'
refuses 2 out.exr 'in/none.exr' -- render in/maps.exr -o out.exr --light in/none.exr
refuses 2 out.exr '1200' -- render in/maps.exr -o out.exr --wavelengths-nm 500,1200
refuses 2 out.tif '.exr' -- render in/maps.exr -o out.tif

# --- optics: grids that are missing, foreign, or wrong in one row
columns=wavelength_nm,mu_a_epidermis_per_mm,mu_a_dermis_per_mm
grid() { printf "$1" >in/grid.csv; }
grid "$columns\n500,1,0.3\n"
refuses 2 out.csv 'in/none.csv|No such file' -- optics in/none.csv -o out.csv
refuses 2 out.csv 'nonsense|multipole' -- optics in/grid.csv -o out.csv --profiles nonsense
refuses 2 out.csv '--radial-mm|0.1 mm' -- optics in/grid.csv -o out.csv --radial-mm '0.03,0.1 mm'
refuses 2 out.csv '--radial-mm|-1' -- optics in/grid.csv -o out.csv --radial-mm=-1
refuses 2 out.csv '--thin-dermis-mm' -- optics in/grid.csv -o out.csv --thin-dermis-mm 0
refuses 2 out.csv 'in/range.toml|n_dermis' -- optics in/grid.csv -o out.csv --config in/range.toml
refuses 2 out.csv 'multipole|single' -- optics in/grid.csv -o out.csv --profiles multipole --single
printf '[tissue]\nanisotropy = 0.8\n' >in/anisotropic.toml
refuses 2 out.csv 'multipole|anisotropy' -- optics in/grid.csv -o out.csv --profiles multipole --config in/anisotropic.toml
refuses 2 out.csv 'anisotropy|R(r)' -- optics in/grid.csv -o out.csv --radial-mm 0.1 --config in/anisotropic.toml
refuses 2 out.csv 'in/good.exr' -- optics in/good.exr -o out.csv
for row in '500,1' '500,1,0.3,4' '500,one,0.3' '500,nan,0.3' '500,-1,0.3' '500,1,1e9' '100,1,0.3' '500,,0.3' '500,"1,0.3'; do
  grid "# skins\r\n$columns\r\n500,1,0.3\r\n\r\n$row\r\n"
  refuses 2 out.csv 'in/grid.csv line 5' -- optics in/grid.csv -o out.csv
done
grid "$columns\n"
refuses 2 out.csv 'in/grid.csv|no rows' -- optics in/grid.csv -o out.csv
grid "wavelength_nm,mu_a_epidermis_mm,mu_a_dermis_per_mm\n500,1,1\n"
refuses 2 out.csv 'in/grid.csv line 1|mu_a_epidermis_per_mm' -- optics in/grid.csv -o out.csv
grid "\xef\xbb\xbf# skins\r\nmu_a_dermis_per_mm, wavelength_nm ,\"mu_a_epidermis_per_mm\"\r\n\r\n0.30,5e2,+1\r\n"
accepts 0 -- optics in/grid.csv -o out.csv --single --config in/anisotropic.toml
accepts 0 -- optics in/grid.csv -o out.csv --radial-mm 0.03,.50 --single --thin-dermis-mm 1
[ "$(head -1 out.csv)" = 'mu_a_dermis_per_mm,wavelength_nm,mu_a_epidermis_per_mm,reflectance,R1,T1,R2,single,stack_reflectance,stack_transmittance,R(0.03),R(.50)' ] ||
  complain "optics: the columns are $(head -1 out.csv)"
[ "$(wc -l <out.csv)" -eq 2 ] && grep -q '^0.30,5e2,+1,0\.' out.csv || complain "optics: $(cat out.csv)"
rm out.csv

# --- study
refuses 2 - 'name of a study is missing' -- study
refuses 2 - 'nonsense|--help' -- study nonsense -o out
refuses 2 out '--output' -- study optics --quick
refuses 4 out 'in/file' -- study optics --quick -o in/file/out
refuses 4 out 'in/file' -- study tradeoff --quick -o in/file/out
mkdir in/study && echo '{"settings":{"study":"tradeoff","seed":7}}' >in/study/tradeoff.journal.jsonl
refuses 2 in/study/tradeoff.json 'tradeoff.journal.jsonl|"seed":7|another folder' -- study tradeoff --quick -o in/study

# --- capture: rig and plan
rig=$root/config/rigs/simulated_8band.toml
plan=$root/config/plans/standard.toml
refuses 2 session 'in/none.toml' -- capture in/none.toml --rig "$rig" --out session
refuses 2 session 'in/none.toml' -- capture "$plan" --rig in/none.toml --out session
printf '[[exposure]]\nslot = 1\nexposure = 10\n' >in/plan_key.toml
refuses 2 session 'in/plan_key.toml line 3|exposure_ms' -- capture in/plan_key.toml --rig "$rig" --out session
printf '[[exposure]]\nslot = 12\n' >in/plan_slot.toml
refuses 2 session 'slot 12' -- capture in/plan_slot.toml --rig "$rig" --out session
printf '[wheel]\n[[wheel.slot]]\nslot = 1\nwavelength_nm = 1200\n' >in/rig_range.toml
refuses 2 session 'in/rig_range.toml line 4|wavelength_nm' -- capture "$plan" --rig in/rig_range.toml --out session
printf '[camera]\ndriver = "kodak"\n[wheel]\n[[wheel.slot]]\nslot = 1\nwavelength_nm = 600\n' >in/rig_driver.toml
printf 'black_frames = 0\n[[exposure]]\nslot = 1\n' >in/plan_one.toml
refuses 2 session 'kodak|simulated' -- capture in/plan_one.toml --rig in/rig_driver.toml --out session

# --- calibrate: a small session, then the same one spoiled
printf '[wheel]\n[[wheel.slot]]\nslot = 1\nwavelength_nm = 600\n[[wheel.slot]]\nslot = 9\nopaque = true\n' >in/rig.toml
printf '[[exposure]]\nslot = 1\niso = 125\n' >in/plan.toml
scene=$root/config/scenes/gray_50.toml
accepts 0 -- capture in/plan.toml --rig in/rig.toml --out session --scene "$scene"
refuses 2 - 'session|--resume' -- capture in/plan.toml --rig in/rig.toml --out session --scene "$scene"
refuses 2 stack.exr 'none' -- calibrate none -o stack.exr
refuses 2 stack.exr 'in/session.json' -- calibrate in -o stack.exr
spoiled() {
  rm -rf spoiled
  cp -r session spoiled
}
skin=$(basename "$(ls session/frames/*_skin_* | head -1)")
spoiled
head -c 200 session/session.json >spoiled/session.json
refuses 2 stack.exr 'spoiled/session.json|not valid JSON' -- calibrate spoiled -o stack.exr
spoiled
rm "spoiled/frames/$skin"
refuses 2 stack.exr "$skin|No such file" -- calibrate spoiled -o stack.exr
spoiled
head -c 3000 "session/frames/$skin" >"spoiled/frames/$skin"
refuses 2 stack.exr "$skin|SHA-256|remedy" -- calibrate spoiled -o stack.exr
refuses 2 stack.exr "$skin" -- calibrate spoiled -o stack.exr --no-verify
spoiled
cp in/picture.exr "spoiled/frames/$skin"
refuses 2 stack.exr "$skin" -- calibrate spoiled -o stack.exr --no-verify
spoiled
sed -i "s#frames/$skin#../$skin#" spoiled/session.json
refuses 2 stack.exr 'inside the session folder' -- calibrate spoiled -o stack.exr

# --- --json tells the same on stdout, as one object
run fit in/none.exr -o out --json
checks=$((checks + 1))
grep -q '"exit_code": 2' .stdout && grep -q 'in/none.exr' .stdout || complain "fit --json: no error object on stdout"

finish
