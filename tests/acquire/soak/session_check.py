# SPDX-License-Identifier: Apache-2.0
# What can be wrong with a session that the small station took. Knows nothing of dermap but the files that
# docs/formats.md describes.
import hashlib
import json
import os
import struct

from small_station import EXPECTED

SAME_LIGHT = 0.03                  # of a frame's mean above black, from session to session
BLACK_LEVEL = 126                  # of the emulated camera


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
