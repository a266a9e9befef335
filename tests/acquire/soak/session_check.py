# SPDX-License-Identifier: Apache-2.0
# A small station and plan for soaks, and what can be wrong with a session that was taken with them. Knows nothing of
# dermap but the files that docs/formats.md describes.
import hashlib
import json
import os
import struct

SCENE = """seed = 9
flat_reflectance = 0.5
[bench]
width_px = 96
height_px = 72
scale_px_per_mm = 7
window_center_px = [38, 35.5]
flash_drift = 0
motion_shift_mm = 0
"""
RIG = """name = "soak"
[camera]
driver = "%s"
[wheel]
driver = "%s"
[[wheel.slot]]
slot = 1
wavelength_nm = 540
[[wheel.slot]]
slot = 2
wavelength_nm = 650
[[wheel.slot]]
slot = 3
opaque = true
[simulated]
scene = "scene.toml"
"""
PLAN = "[[exposure]]\nslot = 1\niso = 100\n[[exposure]]\nslot = 2\niso = 250\n"
# What the plan asks for, by hand: role, slot and ISO of every frame.
EXPECTED = [("black", 3, 100), ("black", 3, 250), ("spectralon", 1, 100), ("spectralon", 2, 250), ("skin", 1, 100),
            ("skin", 2, 250)]
SAME_LIGHT = 0.03                  # of a frame's mean above black, from session to session
BLACK_LEVEL = 126                  # of the emulated camera


def write_station(folder, wheel, camera="gphoto2"):
    """scene.toml, rig.toml and plan.toml."""
    for name, text in (("scene.toml", SCENE), ("rig.toml", RIG % (camera, wheel)), ("plan.toml", PLAN)):
        with open(os.path.join(folder, name), "w") as file:
            file.write(text)


def mean_above_black(path):
    """Of the photosites: a strip of 12-bit numbers, two in three bytes."""
    data = open(path, "rb").read()
    offset, size = strip_of(data)
    strip = data[offset:offset + size]
    total = sum((strip[i] << 4 | strip[i + 1] >> 4) + ((strip[i + 1] & 15) << 8 | strip[i + 2])
                for i in range(0, size, 3))
    return total / (size * 2 / 3) - BLACK_LEVEL


def strip_of(tiff):
    """Offset and size of the one strip of a little-endian TIFF: tags 273 and 279 of its first directory."""
    directory, = struct.unpack_from("<I", tiff, 4)
    count, = struct.unpack_from("<H", tiff, directory)
    tags = {}
    for i in range(count):
        tag, kind, _, value = struct.unpack_from("<HHII", tiff, directory + 2 + 12 * i)
        tags[tag] = value & 0xFFFF if kind == 3 else value
    return tags[273], tags[279]


def check(folder, light):
    """What is wrong with a complete session; `light` is what every frame has shown so far, by role and slot."""
    manifest = json.load(open(folder + "/session.json"))
    found = [(f["role"], f["slot"], f["iso"]) for f in manifest["frames"]]
    # Behind them black frames may lie, for an exposure that was changed and changed back.
    extra = [role for role, _, _ in found[len(EXPECTED):]]
    if not manifest["complete"] or found[:len(EXPECTED)] != EXPECTED or set(extra) - {"black"}:
        return ["lost: has frames %s" % found]
    wrong = []
    if len({f["sha256"] for f in manifest["frames"]}) != len(found):
        wrong.append("doubled: two frames are one file")
    if len(os.listdir(folder + "/frames")) != len(found):
        wrong.append("doubled: files of no frame: %s" % os.listdir(folder + "/frames"))
    for f in manifest["frames"]:
        path = folder + "/" + f["file"]
        if hashlib.sha256(open(path, "rb").read()).hexdigest() != f["sha256"]:
            wrong.append("lost: %s is not as it was written" % f["file"])
            continue
        mean = mean_above_black(path)
        first = light.setdefault((f["role"], f["slot"]), mean)
        if abs(mean - first) > max(2.0, SAME_LIGHT * first):
            wrong.append("mislabelled: %s has %.1f in place of %.1f" % (f["file"], mean, first))
    return wrong
