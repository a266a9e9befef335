#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# The report's pixel section in a real Chromium: the spectrum of a pixel that is clicked or reached with the arrow keys.
# Usage: report_pixel_test.py DERMAP MAKE_INPUTS ROOT [PICTURE.png]; ends with 77 (skipped) where there is no Chromium.
import base64
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

BANDS = [450, 480, 510, 540, 560, 580, 610, 650]


def check(holds, what):
    if not holds:
        raise SystemExit("FAILED: " + what)


def make_report(dermap, make_inputs, root, folder):
    environment = dict(os.environ, DERMAP_CONFIG_DIR=os.path.join(root, "config"))

    def run(*words):
        subprocess.run(words, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)

    os.mkdir(os.path.join(folder, "in"))
    run(make_inputs, "in")
    run(dermap, "render", "in/large_maps.exr", "-o", "stack.exr", "--wavelengths-nm", ",".join(map(str, BANDS)))
    run(dermap, "fit", "stack.exr", "-o", "fit", "--size", "80")
    with open(os.path.join(folder, "fit/fit.json")) as file:
        check(json.load(file)["width"] == 80, "the fit is 80 pixels wide")
    return "file://" + os.path.join(folder, "fit/report.html")


def press(page, key, shift=False):
    for kind in ("keyDown", "keyUp"):
        page.call("Input.dispatchKeyEvent", type=kind, key=key, modifiers=8 if shift else 0)


def said(page):
    return page.eval("document.getElementById('pixel-said').textContent")


def pixel(page):
    return tuple(int(n) for n in re.match(r"Pixel (\d+), (\d+)", said(page)).groups())


def look(page, picture):
    page.wait("document.readyState === 'complete' && document.getElementById('pixel-rows').children.length >= 5")
    check(page.eval("document.querySelectorAll('#pixel-chart circle').length") == len(BANDS), "a dot a band")
    # 80 pixels in steps of 2: the middle is pixel 40.
    check(pixel(page) == (40, 40), "starts in the middle: " + said(page))
    page.eval("document.getElementById('pixel-stage').focus()")
    press(page, "ArrowRight")
    press(page, "ArrowUp", shift=True)
    check(pixel(page) == (42, 20), "the arrow keys move: " + said(page))
    before = page.eval("document.getElementById('pixel-chart').innerHTML")
    page.eval("""(() => { const map = document.querySelector('#maps img.pixels'); const box = map.getBoundingClientRect();
        map.dispatchEvent(new MouseEvent('click', {bubbles: true, clientX: box.left + 0.26 * box.width,
                                                   clientY: box.top + 0.76 * box.height})); })()""")
    check(pixel(page) == (20, 60), "a click on a map chooses its pixel: " + said(page))
    check(page.eval("document.getElementById('pixel-chart').innerHTML") != before, "the spectrum is another")
    # Without noise beyond the default's 1 %: what the fit predicts is near what was measured.
    check("as good as the measurement allows" in said(page), "the pixel is explained: " + said(page))
    row = page.eval("[...document.querySelector('#pixel-rows tr').children].map((c) => c.textContent)")
    check(row[0] == "C_m" and 0.03 < float(row[2]) < 0.13 and row[3].startswith("\u00b1"), "melanin: " + str(row))
    if picture:
        page.eval("document.getElementById('pixel').scrollIntoView({behavior: 'instant'})")
        shot = page.call("Page.captureScreenshot", format="png")
        with open(picture, "wb") as file:
            file.write(base64.b64decode(shot["data"]))


def main():
    program = shutil.which("chromium")
    if not program:
        print("skipped: no chromium here")
        return 77
    dermap, make_inputs, root = (os.path.realpath(path) for path in sys.argv[1:4])
    import browser
    with tempfile.TemporaryDirectory() as folder:
        chromium = browser.Browser(program)
        try:
            page = browser.Page(chromium, make_report(dermap, make_inputs, root, folder), 1280)
            look(page, sys.argv[4] if len(sys.argv) > 4 else None)
            check(not chromium.said, "no script failed: " + str(chromium.said))
        finally:
            chromium.close()
    print("the pixel section works")
    return 0


if __name__ == "__main__":
    sys.exit(main())
