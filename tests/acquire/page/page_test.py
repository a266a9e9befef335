#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# The operator's page in a real Chromium, against a daemon on emulated devices below the real drivers: a whole session with
# a fault and its recovery, an end and a resumption, two windows, keys alone, a narrow screen.
# Usage: page_test.py DERMAP EMULATOR [PICTURES_FOLDER]; ends with 77 (skipped) where there is no Chromium.
import json
import os
import shutil
import subprocess
import sys
import tempfile

sys.path[:0] = [os.path.dirname(os.path.abspath(__file__)) + up for up in ("", "/..")]
from browser import Browser, Page
from small_station import ServedStation, write_station


def expect(condition, what):
    if not condition:
        raise AssertionError(what)


STATE = "(S && S.state)"


def answer_until(page, condition, most=20):
    """Presses Enter for whatever is asked, until the condition holds."""
    for _ in range(most):
        page.wait("%s || (S && S.request)" % condition)
        if page.eval(condition):
            return
        sentence = page.text("sentence")
        page.key("Enter", text="\r")
        page.wait("%s || !S.request || S.request.sentence !== %s" % (condition, json.dumps(sentence)))
    raise AssertionError("asked too often")


def whole_session(page, picture):
    page.wait("S && key")
    expect(page.eval("document.title") == "dermap station", "the title")
    expect(page.text("state").upper() == "READY", "it is ready: " + page.text("state"))
    picture("ready")
    page.eval("$('session').value='one';$('subject').value='S7';$('site').value='forearm';$('session').focus()")
    page.key("Enter", text="\r")  # sends the form
    page.wait(STATE + " === 'waiting'")
    expect("black" in page.text("sentence"), "asks for the black frames: " + page.text("sentence"))
    picture("asked")
    # A full card at the third press: the page says what to do, and goes on.
    page.eval("document.activeElement.blur()")
    answer_until(page, "(S.request && S.request.kind === 'fault')")
    expect("card" in page.text("sentence"), "the fault's sentence: " + page.text("sentence"))
    expect(page.eval("getComputedStyle($('ask')).borderColor") == "rgb(255, 92, 87)", "a fault is red")
    picture("fault")
    answer_until(page, "(S.state === 'complete')")
    expect(page.text("now") == "Session complete", page.text("now"))
    expect(page.text("count").startswith("6 of 6"), page.text("count"))
    page.wait("[...document.images].length === 6 && [...document.images].every(i => i.complete && i.naturalWidth > 0)")
    expect(page.eval("document.querySelectorAll('.card svg rect').length") == 6 * 64, "a histogram for each frame")
    expect(page.text("window") == "yes", "the window was found: " + page.text("window"))
    picture("complete")


def two_windows(browser, page, url, picture):
    watcher = Page(browser, url, 1300)
    watcher.wait("S && !$('helm').classList.contains('hide')")
    expect(watcher.eval("$('formbox').classList.contains('hide')"), "who watches cannot start")
    expect(watcher.eval("!document.querySelector('[data-retake]')"), "who watches cannot retake")
    before = page.eval("S.frames.find(f => f.number === 6).version")
    page.eval("document.querySelector('[data-retake=\"6\"]').click()")
    # The old session is complete too: another picture of the frame tells that this one is.
    again = "(S.state === 'complete' && S.frames.find(f => f.number === 6).version > %d)" % before
    answer_until(page, again)
    watcher.wait(again)
    picture("watching", watcher)
    watcher.close()


def end_and_resume(page):
    page.eval("window.confirm = () => true; $('session').value='two'; $('resume').checked=false")
    page.eval("$('form').requestSubmit()")
    page.wait(STATE + " === 'waiting'")
    page.eval("document.activeElement.blur()")
    page.key("e", "KeyE", "e")
    page.wait(STATE + " === 'ended'")
    expect("can be resumed" in page.text("now"), page.text("now"))
    page.eval("$('session').value='two'; $('resume').checked=true; $('form').requestSubmit()")
    page.wait(STATE + " === 'waiting'")
    page.eval("document.activeElement.blur()")
    answer_until(page, "(S.state === 'complete')")


def narrow(page, picture):
    for width in (360, 800):
        page.resize(width, 800)
        page.wait("innerWidth === %d" % width)
        expect(page.eval("document.documentElement.scrollWidth") <= width,
               "at %d px it scrolls sideways: %s" % (width, page.eval("document.documentElement.scrollWidth")))
        picture("narrow_%d" % width)
    page.resize(1300)


def keyboard(page):
    """Every control can be reached by Tab and shows that it has been."""
    page.eval("document.activeElement.blur(); scrollTo(0,0)")
    reached = set()
    for _ in range(40):
        page.key("Tab")
        reached.add(page.eval("document.activeElement.id || document.activeElement.dataset.retake || "
                              "document.activeElement.className"))
        outline = page.eval("document.activeElement === document.body ? '3px' : "
                            "getComputedStyle(document.activeElement).outlineWidth")
        expect(outline == "3px", "no visible focus on " + str(reached))
    for control in ("session", "subject", "site", "notes", "reference", "resume", "go", "1", "6"):
        expect(control in reached, "Tab never reaches %s: %s" % (control, reached))


def main():
    dermap, emulator = sys.argv[1], sys.argv[2]
    pictures = sys.argv[3] if len(sys.argv) > 3 else None
    program = shutil.which("chromium")
    if program is None:
        print("skipped: no chromium here")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        write_station(folder, "starlight", enlarged=3)
        station = ServedStation(dermap, emulator, folder, ["full@3:0"])  # its operator is the page
        browser = Browser(program)
        try:
            url = "http://127.0.0.1:%d/" % station.port
            page = Page(browser, url, 1300)

            def picture(name, of=None):
                if pictures:
                    (of or page).picture(os.path.join(pictures, name + ".png"))

            whole_session(page, picture)
            two_windows(browser, page, url, picture)
            keyboard(page)
            end_and_resume(page)
            narrow(page, picture)
            expect(not browser.said, "errors on the page: " + "; ".join(browser.said)[:500])
        finally:
            browser.close()
            station.close()
        for name in ("one", "two"):
            subprocess.run([dermap, "verify", folder + "/sessions/" + name], check=True)
    print("the page works")
    return 0


if __name__ == "__main__":
    sys.exit(main())
