#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Cuts the power at every change that a capture makes on disk (or at every STEP-th): what was confirmed must be there, and
# the resumed session must be the one that was never cut. Usage: power_loss_test.sh DERMAP POWER_CUT_LIBRARY [STEP]
set -euo pipefail
dermap=$1 library=$2 step=${3:-1}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat >"$work/scene.toml" <<'TOML'
seed = 9
flat_reflectance = 0.5
[bench]
width_px = 96
height_px = 72
scale_px_per_mm = 7
window_center_px = [38, 35.5]
TOML
cat >"$work/rig.toml" <<'TOML'
name = "small"
[[wheel.slot]]
slot = 1
wavelength_nm = 540
[[wheel.slot]]
slot = 2
opaque = true
[wheel]
driver = "simulated"
[simulated]
scene = "scene.toml"
TOML
# ISO 1600 saturates: the change of exposure is cut into as well.
printf '[[exposure]]\nslot = 1\niso = 1600\n' >"$work/plan.toml"
hashes() { python3 -c 'import json,sys; print(*[f["sha256"] for f in json.load(open(sys.argv[1]))["frames"]])' "$1/session.json"; }
capture() { "$dermap" capture "$work/plan.toml" --rig "$work/rig.toml" --out "$@" >/dev/null 2>>"$work/log"; }

capture "$work/alone"
expected=$(hashes "$work/alone")
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
  DERMAP_POWER_ROOT=$root DERMAP_POWER_CUT_AT=$at LD_PRELOAD=$library capture "$root/session" 2>/dev/null || code=$?
  [ $code -ne 0 ] || break # it ended before
  [ $code -eq 137 ] || fail "$at" "ended with $code"
  cuts=$((cuts + 1))
  # What was confirmed at an earlier cut is confirmed at this one.
  lines=$(wc -l 2>/dev/null <"$root/session/journal.jsonl" || echo 0)
  [ "$lines" -ge "$confirmed" ] || fail "$at" "the journal has $lines lines, it had $confirmed before"
  confirmed=$lines
  if [ -s "$root/session/journal.jsonl" ]; then
    capture "$root/session" --resume || fail "$at" "does not resume"
  else
    rm -rf "$root/session"
    capture "$root/session" || fail "$at" "does not begin anew"
  fi
  ! grep -q "missing or damaged" "$work/log" || fail "$at" "lost a frame that was confirmed"
  "$dermap" verify "$root/session" >/dev/null || fail "$at" "does not verify"
  [ "$(hashes "$root/session")" = "$expected" ] || fail "$at" "is another session"
  [ "$(ls "$root/session/frames" | wc -l)" -eq "$(wc -w <<<"$expected")" ] || fail "$at" "has files of no frame"
  rm -rf "$root"
  : >"$work/log"
done
echo "power loss: $cuts cuts, $failures failures"
[ "$confirmed" -gt 5 ] || { echo "nothing was ever confirmed" >&2; exit 1; }
[ $cuts -gt 10 ] && [ $failures -eq 0 ]
