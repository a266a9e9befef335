#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Cuts the power at every change that a capture makes on disk (or at every STEP-th): what was confirmed must be there, and
# the resumed session must be the one that was never cut. With EMULATOR on emulated devices below the real drivers: the same
# frames then, by number, role, slot and ISO, since their noise differs.
# Usage: power_loss_test.sh DERMAP POWER_CUT_LIBRARY [STEP [EMULATOR]]
set -euo pipefail
dermap=$1 library=$2 step=${3:-1} emulator=${4:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
drivers=(simulated simulated)
[ -z "$emulator" ] || drivers=(starlight gphoto2)
"$(dirname "$0")/../small_station.py" "$work" "${drivers[@]}"
# ISO 1600 saturates: the change of exposure is cut into as well.
printf '[[exposure]]\nslot = 1\niso = 1600\n' >"$work/plan.toml"
# What is the same in every session: hashes, or labels.
frames() {
  python3 -c 'import json,sys
for f in json.load(open(sys.argv[1]))["frames"]:
    print(f["sha256"] if sys.argv[2] == "" else "-".join(str(f[k]) for k in ("number", "role", "slot", "iso")))' \
    "$1/session.json" "$emulator"
}
# capture PRELOADED SESSION [--resume]
capture() {
  local preload=$1
  shift
  local command=("$dermap" capture "$work/plan.toml" --rig "$work/rig.toml" --out "$@")
  if [ -n "$emulator" ]; then
    "$emulator" --rig "$work/rig.toml" -- env LD_PRELOAD="$preload${preload:+:}libumockdev-preload.so.0" "${command[@]}"
  else
    LD_PRELOAD=$preload "${command[@]}"
  fi >/dev/null 2>>"$work/log"
}

capture "" "$work/alone"
expected=$(frames "$work/alone")
cuts=0 failures=0 confirmed=0
fail() {
  echo "cut at change $1: $2" >&2
  tail -3 "$work/log" >&2
  failures=$((failures + 1))
}
for ((at = 1; ; at += step)); do
  root=$work/disk_$at
  mkdir "$root"
  code=0
  DERMAP_POWER_ROOT=$root DERMAP_POWER_CUT_AT=$at capture "$library" "$root/session" 2>/dev/null || code=$?
  [ $code -ne 0 ] || break # it ended before
  [ $code -eq 137 ] || fail "$at" "ended with $code"
  cuts=$((cuts + 1))
  # What was confirmed at an earlier cut is confirmed at this one.
  lines=$(wc -l 2>/dev/null <"$root/session/journal.jsonl" || echo 0)
  [ "$lines" -ge "$confirmed" ] || fail "$at" "the journal has $lines lines, it had $confirmed before"
  confirmed=$lines
  if [ -s "$root/session/journal.jsonl" ]; then
    capture "" "$root/session" --resume || fail "$at" "does not resume"
  else
    rm -rf "$root/session"
    capture "" "$root/session" || fail "$at" "does not begin anew"
  fi
  ! grep -q "missing or damaged" "$work/log" || fail "$at" "lost a frame that was confirmed"
  "$dermap" verify "$root/session" >/dev/null || fail "$at" "does not verify"
  [ "$(frames "$root/session")" = "$expected" ] || fail "$at" "is another session"
  [ "$(ls "$root/session/frames" | wc -l)" -eq "$(wc -w <<<"$expected")" ] || fail "$at" "has files of no frame"
  rm -rf "$root"
  : >"$work/log"
done
echo "power loss: $cuts cuts, $failures failures"
[ "$confirmed" -gt 5 ] || { echo "nothing was ever confirmed" >&2; exit 1; }
[ $cuts -gt 10 ] && [ $failures -eq 0 ]
