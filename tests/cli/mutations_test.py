#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# Random damage to everything that `dermap calibrate` reads: raw frames, manifest, the TOML of a folder of raw files, rig and
# certificate. Whatever the bytes, it ends in time with a documented exit code, with one sentence where it refuses, and
# leaves a whole result or none.
# Usage: mutations_test.py DERMAP MAKE_INPUTS ROOT [ROUNDS [SEED]]
import json
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

DERMAP, ROOT = Path(sys.argv[1]).resolve(), Path(sys.argv[3]).resolve()
ROUNDS = int(sys.argv[4]) if len(sys.argv) > 4 else 160
SEED = int(sys.argv[5]) if len(sys.argv) > 5 else 1
SECONDS, MEMORY = 60, 6 << 30
ODD_NUMBERS = ["nan", "inf", "-inf", "-1", "0", "1e308", "-1e308", "1e-308", "99999999999999999999", "4294967296", "0.5"]
ODD_TEXTS = ['""', '"\\u0000"', '"../../../etc/passwd"', '"' + "x" * 100000 + '"', "[]", "{}", "null", "true", "\u00e9", "\x00"]

BENCH = """
[bench]
width_px = 256
height_px = 160
scale_px_per_mm = 12.0
window_center_px = [100.0, 79.5]
"""
PLAN = """
black_frames = 1
spectralon_frames = 1
skin_frames = 1
adapt_exposure = false
[[exposure]]
slot = 4
iso = 100
exposure_ms = 10
"""


def damaged_bytes(data, rng):
    data = bytearray(data)
    kind = rng.randrange(6)
    if kind == 0:
        return bytes(data[: rng.randrange(len(data))])
    if kind == 1:  # a few bits, mostly in the header
        for _ in range(rng.randint(1, 8)):
            data[rng.randrange(min(len(data), rng.choice([64, 1024, len(data)])))] ^= 1 << rng.randrange(8)
    if kind == 2:  # a word of the header
        at = rng.randrange(min(len(data), 1024) - 4)
        data[at : at + 4] = rng.choice([b"\xff\xff\xff\xff", b"\0\0\0\0", b"\0\0\0\x80", b"\xff\xff\xff\x7f"])
    if kind == 3:  # a stretch of anything
        at, length = rng.randrange(len(data)), rng.randint(1, 4096)
        data[at : at + length] = rng.randbytes(length)
    if kind == 4:
        return rng.randbytes(rng.randint(0, 5000))
    if kind == 5:  # a piece of itself, elsewhere
        at, to = rng.randrange(len(data)), rng.randrange(len(data))
        data[to:to] = data[at : at + rng.randint(1, 2000)]
    return bytes(data)


def damaged_text(text, rng):
    kind = rng.randrange(5)
    numbers = list(re.finditer(r"-?\d+(\.\d+)?", text))
    lines = text.split("\n")
    if kind == 0 and numbers:
        m = rng.choice(numbers)
        return text[: m.start()] + rng.choice(ODD_NUMBERS) + text[m.end() :]
    if kind == 1:
        m = rng.choice(list(re.finditer(r'"[^"\n]*"', text)) or numbers)
        return text[: m.start()] + rng.choice(ODD_TEXTS) + text[m.end() :]
    if kind == 2:
        del lines[rng.randrange(len(lines))]
        return "\n".join(lines)
    if kind == 3:
        i = rng.randrange(len(lines))
        return "\n".join(lines[:i] + [lines[i]] * rng.randint(2, 50) + lines[i:])
    return damaged_bytes(text.encode(), rng)


def limits():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def run(arguments, folder):
    return subprocess.run(
        [DERMAP, *map(str, arguments)], cwd=folder, capture_output=True, timeout=SECONDS, preexec_fn=limits,
        stdin=subprocess.DEVNULL, env={**os.environ, "DERMAP_CONFIG_DIR": str(ROOT / "config")})


def complaint(done, folder):
    """What is wrong with how a run ended, or None."""
    error = done.stderr.decode(errors="replace")
    results = [p for p in (folder / "out.exr", folder / "out.calibration.json", folder / "out.calibration") if p.exists()]
    if done.returncode not in (0, 1, 2):
        return f"exit code {done.returncode}: {error[-500:]}"
    if left := list(folder.rglob("*.partial*")):
        return f"left {left[0]} behind"
    if done.returncode == 2:
        if not error.startswith("dermap calibrate: error: ") or error.count("\n") != 1 or done.stdout:
            return f"not one sentence: {error[-500:]}"
        if len(error) > 2000:
            return f"a sentence of {len(error)} letters"
        return f"refused, but left {results[0]}" if results else None
    if len(results) != 3:
        return "succeeded without a whole result"

    def no_constant(text):
        raise ValueError(f"{text} in the record")

    try:
        json.loads((folder / "out.calibration.json").read_text(), parse_constant=no_constant)
    except ValueError as wrong:
        return f"the record is not JSON: {wrong}"
    return None


def make_session(folder):
    rig = (ROOT / "config/rigs/simulated_8band.toml").read_text()
    (folder / "cert.csv").write_text((ROOT / "config/spectra/spectralon_99_labsphere.csv").read_text())
    (folder / "rig.toml").write_text(re.sub(r'spectralon_csv = ".*"', 'spectralon_csv = "cert.csv"', rig))
    (folder / "scene.toml").write_text((ROOT / "config/scenes/gray_50.toml").read_text() + BENCH)
    (folder / "plan.toml").write_text(PLAN)
    made = run(["capture", "plan.toml", "--rig", "rig.toml", "--out", "session", "--scene", "scene.toml"], folder)
    assert made.returncode == 0, made.stderr
    frames = sorted(p.name for p in (folder / "session/frames").iterdir())
    files = 'rig = "rig.toml"\n'
    for name in frames:
        role = "black" if "black" in name else "spectralon" if "spectralon" in name else "skin"
        files += f'[[frame]]\nfile = "session/frames/{name}"\nrole = "{role}"\n'
        files += "wavelength_nm = 540\n" if role != "black" else ""
    (folder / "files.toml").write_text(files)
    return [Path("session/frames") / name for name in frames]


def main():
    rng = random.Random(SEED)
    ends, failures = {0: 0, 1: 0, 2: 0}, 0
    with tempfile.TemporaryDirectory(prefix="dermap_mutations.") as place:
        good = Path(place) / "good"
        good.mkdir()
        frames = make_session(good)
        by_session = ["calibrate", "session", "-o", "out.exr", "--no-verify"]
        by_folder = ["calibrate", "--from-folder", "files.toml", "-o", "out.exr"]
        for whole in (by_session, by_folder):
            bad = Path(place) / "whole"
            shutil.copytree(good, bad)
            done = run(whole, bad)
            assert done.returncode == 0 and complaint(done, bad) is None, done.stderr
            shutil.rmtree(bad)
        targets = [(frame, by_session) for frame in frames]
        targets += [(Path("session/session.json"), by_session)] * 3
        targets += [(Path(name), by_folder) for name in ("files.toml", "rig.toml", "cert.csv")]
        for number in range(ROUNDS):
            victim, arguments = targets[number % len(targets)]
            bad = Path(place) / "bad"
            shutil.copytree(good, bad)
            text = victim.suffix != ".dng"
            data = damaged_text((bad / victim).read_text(), rng) if text else damaged_bytes((bad / victim).read_bytes(), rng)
            (bad / victim).write_bytes(data if isinstance(data, bytes) else data.encode())
            try:
                done = run(arguments, bad)
                wrong = complaint(done, bad)
                ends[done.returncode] = ends.get(done.returncode, 0) + 1
            except subprocess.TimeoutExpired:
                wrong = f"still running after {SECONDS} s"
            if wrong:
                failures += 1
                print(f"FAILED: round {number} of seed {SEED}, {victim}: {wrong}", file=sys.stderr)
            shutil.rmtree(bad)
    print(f"{ROUNDS} damaged inputs: {ends[0]} calibrated all the same, {ends[1]} in part, {ends[2]} refused, {failures} failed")
    return 1 if failures or ends[2] < ROUNDS / 4 else 0


if __name__ == "__main__":
    sys.exit(main())
