#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What the commands do unasked is what the documents say. Usage: defaults_test.sh DERMAP MAKE_INPUTS ROOT
set -uo pipefail
# shellcheck source=harness.sh
. "$(dirname "$0")/harness.sh" "$@"

mkdir in
"$make_inputs" in || exit 1

# fit NAME VALUE ARGS...: fit.json says that NAME was VALUE.
fits_with() {
  local name=$1 value=$2
  shift 2
  accepts '0|1' -- fit in/good.exr -o out "$@"
  grep -qF "\"$name\": \"$value\"" out/fit.json || complain "fit $*: $name is not $value: $(grep "\"$name\"" out/fit.json)"
  rm -rf out
}
fits_with method fast
fits_with profiles exact
fits_with engine lowrank
fits_with engine pyramid --engine pyramid
fits_with profiles multipole --profiles multipole

# helps COMMAND TEXT: its --help says so.
helps() {
  accepts 0 -- "$1" --help
  grep -qF -- "$2" .stdout || complain "$1 --help does not say '$2'"
}
for command in fit render; do
  helps "$command" '(default exact)'
  helps "$command" '(default lowrank)'
done

finish
