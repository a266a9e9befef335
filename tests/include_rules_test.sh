#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The rule checker must itself be able to fail: plants one violation of each kind into a copy of the headers.
# Usage: include_rules_test.sh ROOT
set -uo pipefail
root=${1:?usage: include_rules_test.sh ROOT}
copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
(cd "$root" && find common acquire calibrate fit render studies apps tests/reference \( -name '*.h' -o -name '*.cpp' \) \
  -exec cp --parents {} "$copy" \; 2>/dev/null)
mkdir -p "$copy"/{studies,apps,tests/reference}

"$root/tests/include_rules.sh" "$copy" >/dev/null || { echo "the clean copy is refused"; exit 1; }

# plant FILE LINE: with this line added to the file, the checker must fail.
plant() {
  local file="$copy/$1"
  mkdir -p "$(dirname "$file")"
  local before=""
  [ -f "$file" ] && before=$(mktemp) && cp "$file" "$before"
  echo "$2" >>"$file"
  if "$root/tests/include_rules.sh" "$copy" >/dev/null 2>&1; then
    echo "not noticed: '$2' in $1"
    exit 1
  fi
  if [ -n "$before" ]; then mv "$before" "$file"; else rm "$file"; fi
}
plant common/core/error.h '#include "common/files/stack.h"'
plant common/transport/forward_model.h '#include "fit/fit_result.h"'
plant calibrate/planted.cpp '#include "acquire/sequence.h"'
plant render/planted.cpp '#include <OpenImageIO/imageio.h>'
plant fit/planted.cpp '#include <libusb-1.0/libusb.h>'
plant render/planted.cpp '#include <ceres/ceres.h>'
plant acquire/planted.cpp '#include <libraw/libraw.h>'
plant fit/fit_result.h '#include <opencv2/core.hpp>'
plant studies/planted.cpp '#include "apps/commands.h"'
plant studies/planted.cpp '#include "tests/fit/scene.h"'
plant fit/planted.cpp '#include "tests/reference/monte_carlo.h"'
plant apps/planted.cpp '#include "tests/reference/monte_carlo.h"'
plant tests/reference/planted.cpp '#include "common/optics/profile_source.h"'
echo "every planted violation was noticed"
