#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Places that cannot be written: exit code 4 (docs/formats.md), one sentence that names the file, nothing half-written,
# and what was there before is still there. Usage: unwritable_test.sh DERMAP MAKE_INPUTS ROOT
set -uo pipefail
# shellcheck source=harness.sh
. "$(dirname "$0")/harness.sh" "$@"

mkdir in
"$make_inputs" in || exit 1
echo file >in/file
fit=(fit in/good.exr --method descent --max-iterations 1 --profiles multipole --size 16)
render=(render in/maps.exr --profiles multipole)
printf '[wheel]\n[[wheel.slot]]\nslot = 1\nwavelength_nm = 600\n[[wheel.slot]]\nslot = 9\nopaque = true\n' >in/rig.toml
printf '[[exposure]]\nslot = 1\niso = 125\n' >in/plan.toml
capture=(capture in/plan.toml --rig in/rig.toml --scene "$root/config/scenes/gray_50.toml")

# --- a path that leads through a file, a folder in the file's place, a device
refuses 4 - 'in/file/out' -- "${fit[@]}" -o in/file/out
refuses 4 - 'in/file/out.exr' -- "${render[@]}" -o in/file/out.exr
refuses 4 - 'in/file/session' -- "${capture[@]}" --out in/file/session
refuses 4 - 'in/file/sessions' -- serve --rig "$root/config/rigs/simulated_8band.toml" --root in/file/sessions --listen 127.0.0.1:0
mkdir folder.exr
refuses 4 - 'folder.exr' -- "${render[@]}" -o folder.exr
rmdir folder.exr || complain "render wrote into folder.exr"

# --- a limit on the size of files acts like a full disk, anywhere and without privileges
limited() {  # BLOCKS: of 1024 bytes
  local blocks=$1
  real=$dermap
  dermap=$work/.limited
  printf '#!/usr/bin/env bash\nulimit -f %s\nexec "%s" "$@"\n' "$blocks" "$real" >"$dermap"
  chmod +x "$dermap"
}
unlimited() { dermap=$real; }
limited 1
refuses 4 - 'out/|remedy' -- "${fit[@]}" -o out
[ -z "$(find out -type f 2>/dev/null)" ] || [ ! -e out/maps.exr ] || [ "$(wc -c <out/maps.exr)" -gt 1024 ] ||
  complain "fit left a short out/maps.exr"
echo old >kept.exr
refuses 4 - 'kept.exr' -- "${render[@]}" -o kept.exr
[ "$(cat kept.exr)" = old ] || complain "render spoiled the file that was there"
refuses 4 - 'session/' -- "${capture[@]}" --out session
unlimited
for frame in session/frames/*; do
  [ ! -e "$frame" ] || [ "$(wc -c <"$frame")" -gt 100000 ] || complain "capture left half a frame: $frame"
done
# With room again the session goes on, and nothing of it was lost or doubled.
accepts 0 -- "${capture[@]}" --out session --resume
frames=$(find session/frames -type f | wc -l)
listed=$(grep -c '"sha256"' session/session.json)
[ "$frames" -eq 3 ] && [ "$listed" -eq 3 ] || complain "resumed session: $frames files, $listed listed, expected 3"

# --- file systems that are full or read-only: only where this test may mount one of its own
if unshare -m true 2>/dev/null && mkdir -p small && unshare -m mount -t tmpfs -o size=64k tmpfs small 2>/dev/null; then
  cat >inside.sh <<'INSIDE'
mount -t tmpfs -o size=64k tmpfs small || exit 99
head -c 60000 /dev/zero >small/filler
"$dermap" "${fit[@]}" -o small/out >.stdout 2>.stderr </dev/null; echo $? >.full
find small -name '*.partial*' >.left
mount -o remount,ro small || exit 99
"$dermap" "${fit[@]}" -o small/other >.stdout2 2>.stderr2 </dev/null; echo $? >.readonly
INSIDE
  {
    printf 'dermap=%q\n' "$dermap"
    printf 'fit=('
    printf '%q ' "${fit[@]}"
    printf ')\n'
    cat inside.sh
  } >mounted.sh
  unshare -m bash mounted.sh
  checks=$((checks + 2))
  [ "$(cat .full)" = 4 ] && [ "$(wc -l <.stderr)" -eq 1 ] && grep -q 'No space left' .stderr && [ ! -s .left ] ||
    complain "full disk: exit code $(cat .full), left: $(cat .left), said: $(cat .stderr)"
  [ "$(cat .readonly)" = 4 ] && [ "$(wc -l <.stderr2)" -eq 1 ] && grep -q 'small/other' .stderr2 ||
    complain "read-only: exit code $(cat .readonly), said: $(cat .stderr2)"
else
  echo "SKIPPED: full and read-only file systems (no right to mount one here)"
fi

finish
