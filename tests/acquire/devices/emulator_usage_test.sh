#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What the emulator is told wrongly it refuses whole, with exit code 2 (docs/formats.md) and a sentence.
# Usage: emulator_usage_test.sh EMULATOR
set -euo pipefail
emulator=$1
refuses() { # PATTERN flags...
  local pattern=$1 code=0 said
  shift
  said=$("$emulator" "$@" -- true 2>&1) || code=$?
  [ "$code" -eq 2 ] || { echo "$*: ended with $code, expected 2: $said" >&2; exit 1; }
  grep -q -- "$pattern" <<<"$said" || { echo "$*: says '$said', expected '$pattern'" >&2; exit 1; }
}
for fault in busy@0 busy@1x busy@1:nan busy@1:-5 busy@1:0.5x0 nonsense@1 busy; do
  refuses "'$fault' is no fault; expected NAME@COUNT" --fault "$fault"
done
refuses 'network' --network 65536
refuses 'operator-s' --operator-s -1
refuses 'no emulated wheel' --wheel none
refuses 'cannot read nothing.toml' --rig nothing.toml
code=0
"$emulator" >/dev/null 2>&1 || code=$?
[ "$code" -eq 2 ] || { echo "without a command it ends with $code, expected 2" >&2; exit 1; }
