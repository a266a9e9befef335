#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The emulator dies at the fourth press and takes its client with it: resumed, the session is whole.
# Usage: emulator_killed_test.sh DERMAP EMULATOR
set -euo pipefail
dermap=$1 emulator=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$(dirname "$0")/../small_station.py" "$work" starlight gphoto2
capture() { # capture EMULATOR_FLAGS -- CAPTURE_FLAGS
  local flags=()
  while [ "$1" != -- ]; do flags+=("$1"); shift; done
  shift
  "$emulator" --rig "$work/rig.toml" "${flags[@]}" -- "$dermap" capture "$work/plan.toml" --rig "$work/rig.toml" \
    --out "$work/session" "$@" >"$work/log" 2>&1
}
code=0
{ capture --fault emulator-killed@4 -- || code=$?; } 2>/dev/null # the shell tells of the kill
[ "$code" -eq 137 ] || { cat "$work/log" >&2; echo "the emulator ended with $code, expected to be killed" >&2; exit 1; }
for _ in $(seq 100); do # its client ends by itself, and lets go of the journal
  flock -n "$work/session/journal.jsonl" true && break
  sleep 0.1
done
[ "$(grep -c '"event":"frame"' "$work/session/journal.jsonl")" -eq 3 ] || { echo "expected three frames" >&2; exit 1; }
capture -- --resume || { cat "$work/log" >&2; exit 1; }
"$dermap" verify "$work/session"
