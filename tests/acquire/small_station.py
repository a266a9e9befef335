#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# A small station for tests and soaks of whole programs: two filters (540 nm, 650 nm), the opaque slot and a flat target;
# and `dermap serve` on it, below the emulator.
# Usage: small_station.py FOLDER WHEEL CAMERA   writes scene.toml, rig.toml and plan.toml into it, for these drivers.
import collections
import os
import re
import signal
import subprocess
import sys
import threading

SCENE = """seed = 9
flat_reflectance = 0.5
[bench]
width_px = %d
height_px = %d
scale_px_per_mm = %d
window_center_px = [%g, %g]
flash_drift = 0
motion_shift_mm = 0
"""
RIG = """name = "small"
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
SENSOR = (96, 72, 7, 38, 35.5)     # its size in pixels, pixels a mm, and the window's center


def write_station(folder, wheel, camera="gphoto2", enlarged=1):
    """scene.toml, rig.toml and plan.toml; `enlarged` times the pixels along each side."""
    for name, text in (("scene.toml", SCENE % tuple(enlarged * n for n in SENSOR)), ("rig.toml", RIG % (camera, wheel)),
                       ("plan.toml", PLAN)):
        with open(os.path.join(folder, name), "w") as file:
            file.write(text)


class ServedStation:
    """`dermap serve` below the emulator, in a folder that has a station."""

    def __init__(self, dermap, emulator, folder, faults=(), wheel="starlight"):
        self.sessions = folder + "/sessions"
        command = [emulator, "--rig", folder + "/rig.toml", "--wheel", wheel]
        for fault in faults:
            command += ["--fault", fault]
        command += ["--", dermap, "serve", "--rig", folder + "/rig.toml", "--plan", folder + "/plan.toml", "--root",
                    self.sessions, "--listen", "127.0.0.1:0"]
        self.log = collections.deque(maxlen=200)
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        for line in self.process.stderr:
            found = re.search(r"http://127\.0\.0\.1:(\d+)/", line)
            if found:
                break
        else:
            raise RuntimeError("the daemon does not start")
        self.port = int(found.group(1))
        threading.Thread(target=self.drain, daemon=True).start()

    def drain(self):
        for line in self.process.stderr:
            self.log.append(line)

    def close(self):
        """Its exit status."""
        self.process.send_signal(signal.SIGTERM)
        try:
            return self.process.wait(60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()


if __name__ == "__main__":
    write_station(*sys.argv[1:4])
