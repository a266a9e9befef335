# SPDX-License-Identifier: Apache-2.0
# Pages in a real Chromium: a script of Playwright's is run, where scripts/setup could install both.
import os
import shutil
import subprocess

SKIPPED = 77  # CTest's SKIP_RETURN_CODE


def is_missing():
    """Says what is not to be had here, if anything is."""
    missing = [name for name in ("chromium", "node") if shutil.which(name) is None]
    if not os.path.isdir(os.path.dirname(os.path.abspath(__file__)) + "/node_modules/playwright-core"):
        missing.append("playwright-core")
    if missing:
        print("skipped: no %s here; remedy: scripts/setup" % ", no ".join(missing))
    return bool(missing)


def run(script, url, *words):
    subprocess.run(["node", script, url, shutil.which("chromium"), *words], check=True)
