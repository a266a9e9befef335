#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What fits of many bands teach, and a fit of three bands with it. Usage: prior_test.sh DERMAP MAKE_INPUTS ROOT
set -uo pipefail
# shellcheck source=harness.sh
. "$(dirname "$0")/harness.sh" "$@"

mkdir in
"$make_inputs" in || exit 1
accepts 0 -- render in/maps.exr -o eight.exr --wavelengths-nm 450,480,510,540,560,580,610,650
accepts 0 -- render in/maps.exr -o other.exr --wavelengths-nm 450,480,510,540,560,580,610,650 --edit 'C_m*=1.5'
accepts 0 -- render in/maps.exr -o three.exr --wavelengths-nm 460,535,605 --edit 'C_m*=1.2'

# counts N: the prior holds so many fits.
counts() {
  grep -qF "\"fits\": $1," skin.json || complain "skin.json does not hold $1 fits: $(head -c 200 skin.json)"
}
accepts 0 -- fit eight.exr -o out --save-prior skin.json
counts 1
accepts 0 -- fit other.exr -o out --save-prior skin.json
counts 2
rm -rf out
refuses 2 out 'eight.exr|counts once' -- fit eight.exr -o out --save-prior skin.json
refuses 2 out 'three.exr|3 bands' -- fit three.exr -o out --save-prior skin.json
refuses 2 out '--prior' -- fit eight.exr -o out --save-prior skin.json --prior skin.json
counts 2

accepts 0 -- fit three.exr -o out --prior skin.json
grep -qF 'prior of 2 earlier fits' out/fit.json || complain 'fit.json does not tell of the prior'
grep -qF '"C_hd"' out/fit.json || complain 'not all parameters are free under a prior'
rm -rf out

refuses 2 out 'none.json|No such file' -- fit three.exr -o out --prior none.json
head -c 300 skin.json >torn.json
refuses 2 out 'torn.json|not valid JSON' -- fit three.exr -o out --prior torn.json
refuses 2 out 'torn.json|not valid JSON' -- fit eight.exr -o out --save-prior torn.json
sed 's/"format_version": 1/"format_version": 9/' skin.json >version.json
refuses 2 out 'version.json|version 9' -- fit three.exr -o out --prior version.json
refuses 2 out 'descent|--prior' -- fit three.exr -o out --prior skin.json --method descent

finish
