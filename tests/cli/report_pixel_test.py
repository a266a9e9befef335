#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# The report's pixel section in a real Chromium; what is done there is report_pixel.mjs. Ends with 77 (skipped) where there is no
# Chromium or no Playwright.
# Usage: report_pixel_test.py DERMAP MAKE_INPUTS ROOT [PICTURE.png]
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE + "/..")
import in_browser

BANDS = ["450", "480", "510", "540", "560", "580", "610", "650"]


def make_report(dermap, make_inputs, root, folder):
    environment = dict(os.environ, DERMAP_CONFIG_DIR=os.path.join(root, "config"))

    def run(*words):
        subprocess.run(words, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)

    os.mkdir(os.path.join(folder, "in"))
    run(make_inputs, "in")
    run(dermap, "render", "in/large_maps.exr", "-o", "stack.exr", "--wavelengths-nm", ",".join(BANDS))
    run(dermap, "fit", "stack.exr", "-o", "fit", "--size", "80")
    return "file://" + os.path.join(folder, "fit/report.html")


def main():
    if in_browser.is_missing():
        return in_browser.SKIPPED
    dermap, make_inputs, root = (os.path.realpath(path) for path in sys.argv[1:4])
    with tempfile.TemporaryDirectory() as folder:
        in_browser.run(HERE + "/report_pixel.mjs", make_report(dermap, make_inputs, root, folder), str(len(BANDS)), *sys.argv[4:])
    print("the pixel section works")
    return 0


if __name__ == "__main__":
    sys.exit(main())
