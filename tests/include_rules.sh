#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Holds the house's include rules: who may include whom, and which library may appear where. Usage: include_rules.sh ROOT
set -uo pipefail
root=${1:?usage: include_rules.sh ROOT}
cd "$root" || exit 2
failures=0

fail() {
  echo "include rules: $*" >&2
  failures=$((failures + 1))
}

# sources DIR...: our C++ files below these folders.
sources() { find "$@" -name '*.cpp' -o -name '*.h' 2>/dev/null | sort; }

# forbid WHY PATTERN FILES...: no file may have an include line that matches.
forbid() {
  local why=$1 pattern=$2 hits
  shift 2
  [ $# -gt 0 ] || return 0
  hits=$(grep -nE "^#include +[\"<]($pattern)" "$@" /dev/null) && fail "$why"$'\n'"$hits"
  return 0
}

# 1. Bottom-up: a folder includes only itself and what stands before it here.
house=(common/core common/spectra common/tissue common/optics common/transport common/files)
for ((i = 0; i < ${#house[@]}; i++)); do
  later=$(IFS='|'; echo "${house[*]:i+1}")
  mapfile -t files < <(sources "${house[i]}")
  [ ${#files[@]} -gt 0 ] || fail "${house[i]} has no sources: the list in this script is out of date"
  [ -n "$later" ] && forbid "${house[i]} may not include what stands above it" "($later)/" "${files[@]}"
  forbid "${house[i]} may not include the stages" "(acquire|calibrate|fit|render|studies|apps)/" "${files[@]}"
done

# 2. The four stages never include one another, nor what stands above them.
stages=(acquire calibrate fit render)
for stage in "${stages[@]}"; do
  others=$(printf '%s\n' "${stages[@]}" studies apps | grep -vx "$stage" | paste -sd'|')
  mapfile -t files < <(sources "$stage")
  [ ${#files[@]} -gt 0 ] || fail "$stage has no sources: the list in this script is out of date"
  forbid "$stage may not include the other stages" "($others)/" "${files[@]}"
done

# 3. Libraries stay in their rooms.
# only WHY PATTERN ROOMS_REGEX: the library's headers may appear only in files that match.
only() {
  local why=$1 pattern=$2 rooms=$3 files
  mapfile -t files < <(sources common acquire calibrate fit render studies apps | grep -vE "$rooms")
  [ ${#files[@]} -gt 0 ] && forbid "$why" "$pattern" "${files[@]}"
}
only "libgphoto2 and libusb belong in acquire/devices/*.cpp" 'gphoto2/|libusb' '^acquire/devices/[^/]*\.cpp$'
only "libumockdev belongs in acquire/emulator/usb_bus.cpp and usbfs.cpp" 'umockdev|glib' '^acquire/emulator/(usb_bus|usbfs)\.cpp$'
only "cpp-httplib belongs in acquire/daemon/*.cpp" 'httplib' '^acquire/daemon/[^/]*\.cpp$'
only "OpenImageIO belongs in common/files/*.cpp and calibrate/" 'OpenImageIO/' '^(common/files/[^/]*\.cpp|calibrate/.*)$'
only "Ceres belongs in fit/" 'ceres/' '^fit/'
# Damaged files can end LibRaw: whoever opens files by it asks the guard first.
mapfile -t files < <(sources common acquire calibrate fit render studies apps | grep -v '^common/files/raw_guard' | xargs grep -lE '^#include <libraw/')
for file in "${files[@]}"; do
  grep -q '^#include "common/files/raw_guard.h"' "$file" || fail "$file opens files by LibRaw without common/files/raw_guard.h"
done

# 4. Third-party device, image and solver headers stay out of our headers; headers guard themselves with #pragma once.
mapfile -t headers < <(find common acquire calibrate fit render studies apps -name '*.h' | sort)
forbid "third-party headers belong in .cpp files" 'gphoto2/|libusb|OpenImageIO/|ceres/|opencv2/|libraw/|toml\+\+|nlohmann/json\.hpp|tbb/|umockdev|glib|httplib' "${headers[@]}"
for header in "${headers[@]}"; do
  grep -q '^#pragma once' "$header" || fail "$header has no #pragma once"
done

# 5. Studies stand above the stages and below the commands; beside tests, they alone may ask the judges.
mapfile -t files < <(sources studies)
[ ${#files[@]} -gt 0 ] || fail "studies has no sources: the list in this script is out of date"
forbid "studies may not include the commands" "apps/" "${files[@]}"
mapfile -t files < <(sources studies | xargs grep -lE '^#include +"tests/' | sort)
[ ${#files[@]} -gt 0 ] && forbid "studies may include only the judges of the tests" 'tests/(acquire|calibrate|common|fit|render|bench|cli)/' "${files[@]}"
mapfile -t files < <(sources common acquire calibrate fit render apps)
forbid "only studies and tests may include the judges" "tests/" "${files[@]}"

# 6. The reference judges share no optics code with the model that they judge.
mapfile -t files < <(sources tests/reference | grep -vE '_test\.cpp$')
[ ${#files[@]} -gt 0 ] && forbid "tests/reference shares no optics code with common/" \
  'common/(spectra|tissue|optics|transport)/' "${files[@]}"

[ $failures -eq 0 ] && echo "include rules hold" && exit 0
exit 1
