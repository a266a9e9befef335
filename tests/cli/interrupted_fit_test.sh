#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A fit that is interrupted leaves what it has, marked, and goes on from there. Usage:
# interrupted_fit_test.sh DERMAP MAKE_INPUTS ROOT
set -uo pipefail
# shellcheck source=harness.sh
. "$(dirname "$0")/harness.sh" "$@"

mkdir in
"$make_inputs" in || exit 1
bands=450,480,510,540,560,580,610,650
accepts 0 -- render in/large_maps.exr -o large.exr --wavelengths-nm $bands
accepts 0 -- render in/maps.exr -o small.exr --wavelengths-nm $bands

# listens PID SIGNAL_NUMBER: waits until the process handles the signal itself.
listens() {
  local caught
  for _ in $(seq 600); do
    caught=$(sed -n 's/^SigCgt:\t//p' "/proc/$1/status" 2>/dev/null) || return 1
    [ -n "$caught" ] || return 1
    [ $((0x$caught >> ($2 - 1) & 1)) -eq 1 ] && return 0
    sleep 0.05
  done
  return 1
}

# interrupts SIGNAL ARGS...: the signal ends the fit before it is done; the folder is whole and says so.
interrupts() {
  local signal=$1 number pid name="kill -$1, dermap fit ${*:2}"
  shift
  number=$(kill -l "$signal")
  rm -rf out
  checks=$((checks + 1))
  "$dermap" fit "$@" -o out >.stdout 2>.stderr </dev/null &
  pid=$!
  listens $pid "$number" || complain "$name: does not handle the signal"
  kill -"$signal" $pid
  wait $pid
  code=$?
  [ $code -eq 1 ] || complain "$name: exit code $code, expected 1: $(cat .stderr)"
  grep -q INTERRUPTED .stdout || complain "$name: the summary does not say so: $(cat .stdout)"
  grep -qF '"finished": false' out/fit.json || complain "$name: fit.json does not say so"
  grep -q INTERRUPTED out/report.html || complain "$name: the report does not say so"
  for file in maps.exr sigma.exr predicted.exr residual.exr flags.exr; do
    [ -s out/$file ] || complain "$name: no out/$file"
  done
  check_nothing_half_written "$name"
}

# finishes ARGS...: the same fit goes on and ends.
finishes() {
  accepts '0|1' -- fit "$@" -o out --resume
  grep -qF '"finished": true' out/fit.json || complain "dermap fit $* --resume: not finished"
  grep -qF 'Goes on from the maps in out' out/fit.json || complain "dermap fit $* --resume: does not say so"
}

interrupts INT large.exr
refuses 2 - 'out|method|fast|descent' -- fit large.exr -o out --resume --method descent
refuses 2 - 'out|data|stack' -- fit small.exr -o out --resume
refuses 2 - 'out|maps of 160|64' -- fit large.exr -o out --resume --size 64
finishes large.exr
accepts 0 -- fit large.exr -o whole
refuses 2 - 'out/fit.json|finished' -- fit large.exr -o out --resume
refuses 2 none 'none/fit.json|No such file' -- fit large.exr -o none --resume

interrupts TERM large.exr --method descent --size 64 --max-iterations 200 --stop-chi2 0
finishes large.exr --method descent --size 64 --max-iterations 3 --stop-chi2 0
interrupts INT large.exr --method ceres --size 64
finishes large.exr --method ceres --size 64 --max-iterations 3

finish
