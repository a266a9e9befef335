# SPDX-License-Identifier: Apache-2.0
# Sourced by the command-line tests: runs dermap and holds it to what every command promises.
# Sourced as `. harness.sh DERMAP MAKE_INPUTS ROOT`: sets $dermap (the program), $make_inputs (makes small files), $root (the
# project) and $work, an empty folder of the test's own that goes with it, and moves there.
dermap=$(realpath "$1")
make_inputs=$(realpath "$2")
root=$(realpath "$3")
export DERMAP_CONFIG_DIR=$root/config
work=$(mktemp -d "${TMPDIR:-/tmp}/dermap_cli.XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1

failures=0
checks=0

complain() {
  failures=$((failures + 1))
  printf 'FAILED: %s\n' "$*" >&2
}

# run ARGS...: leaves $code, and what was printed in $work/.stdout and $work/.stderr.
run() {
  "$dermap" "$@" >"$work/.stdout" 2>"$work/.stderr" </dev/null
  code=$?
}

# No temporary file may be left anywhere, whatever happened.
check_nothing_half_written() {
  local left
  left=$(find "$work" -name '*.partial*' -print -quit)
  [ -z "$left" ] || complain "$1: left $left behind"
}

# refuses CODE OUTPUT WORDS -- ARGS...: the command ends with that exit code, says one line on stderr that holds each of
# WORDS (separated by '|', at least one of them the file's name), prints nothing on stdout, and does not make OUTPUT.
refuses() {
  local expected=$1 output=$2 words=$3 name word
  shift 4
  name="dermap $*"
  checks=$((checks + 1))
  run "$@"
  [ "$code" -eq "$expected" ] || complain "$name: exit code $code, expected $expected: $(cat "$work/.stderr")"
  [ "$(wc -l <"$work/.stderr")" -eq 1 ] || complain "$name: expected one line on stderr: $(cat "$work/.stderr")"
  [ -s "$work/.stdout" ] && complain "$name: wrote to stdout: $(head -c 300 "$work/.stdout")"
  local IFS='|'
  for word in $words; do
    grep -qF -- "$word" "$work/.stderr" || complain "$name: '$word' is not in: $(cat "$work/.stderr")"
  done
  if [ "$output" != - ] && [ -e "$output" ]; then
    complain "$name: left something at $output: $(find "$output" | head -5)"
    rm -rf "$output"
  fi
  check_nothing_half_written "$name"
}

# accepts CODES -- ARGS...: the command ends with one of these exit codes ("0|1").
accepts() {
  local codes=$1 ok
  shift 2
  checks=$((checks + 1))
  run "$@"
  case "|$codes|" in *"|$code|"*) ok=1 ;; *) ok=0 ;; esac
  [ $ok -eq 1 ] || complain "dermap $*: exit code $code, expected $codes: $(cat "$work/.stderr")"
  check_nothing_half_written "dermap $*"
}

finish() {
  [ $failures -eq 0 ] || { echo "$failures of $checks checks failed" >&2; exit 1; }
  [ $checks -gt 0 ] || { echo "nothing was checked" >&2; exit 1; }
  echo "$checks checks passed"
}
