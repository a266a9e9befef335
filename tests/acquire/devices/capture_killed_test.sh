#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A capture is killed while its camera answers nothing any more (the emulator stands still): the helper process ends all
# the same, and leaves the camera to the next one. Once the emulator goes on, it ends as its program did.
# Usage: capture_killed_test.sh DERMAP EMULATOR
set -euo pipefail
dermap=$1 emulator=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { cat "$work/log" >&2; echo "$1" >&2; exit 1; }
await() { # await WHAT COMMAND...
  for _ in $(seq 300); do
    "${@:2}" && return
    sleep 0.1
  done
  fail "waited for 30 s in vain: $1"
}
has_ended() { case "$(ps -o stat= -p "$1" || true)" in "" | Z*) ;; *) return 1 ;; esac }

"$(dirname "$0")/../small_station.py" "$work" starlight gphoto2
"$emulator" --rig "$work/rig.toml" --operator-s 5 -- "$dermap" capture "$work/plan.toml" --rig "$work/rig.toml" \
  --out "$work/session" >"$work/log" 2>&1 &
emulator_id=$!
await "the first question" grep -q '^\[place' "$work/log"
capture_id=$(pgrep -P "$emulator_id" -x dermap)
helper_id=$(pgrep -P "$capture_id" -x dermap-camera)
kill -STOP "$emulator_id"
kill -KILL "$capture_id"
await "the helper's end" has_ended "$helper_id"
kill -CONT "$emulator_id"
code=0
{ wait "$emulator_id" || code=$?; } 2>/dev/null
[ "$code" -eq 137 ] || fail "the emulator ended with $code, expected that of its killed program"
