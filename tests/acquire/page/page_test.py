#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# The operator's page in a real Chromium, against a daemon on emulated devices below the real drivers; what is done there is
# page_in_browser.mjs. Ends with 77 (skipped) where there is no Chromium or no Playwright.
# Usage: page_test.py DERMAP EMULATOR [PICTURES_FOLDER]
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE + "/..", HERE + "/../.."]
import in_browser
from small_station import ServedStation, write_station


def main():
    dermap, emulator, *pictures = sys.argv[1:]
    if in_browser.is_missing():
        return in_browser.SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        write_station(folder, "starlight", enlarged=3)
        station = ServedStation(dermap, emulator, folder, ["full@3:0"])  # its operator is the page
        try:
            in_browser.run(HERE + "/page_in_browser.mjs", "http://127.0.0.1:%d/" % station.port, *pictures)
        finally:
            station.close()
        for name in ("one", "two"):
            subprocess.run([dermap, "verify", folder + "/sessions/" + name], check=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
