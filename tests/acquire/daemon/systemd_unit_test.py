#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# The systemd unit: systemd-analyze finds nothing wrong with it and little that it exposes, and the daemon says what its
# Type=notify and its watchdog wait for, in the words of sd_notify(3). Usage: systemd_unit_test.py DERMAP UNIT RIG; ends
# with 77 (skipped) where there is no systemd-analyze.
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile

dermap, unit, rig = sys.argv[1:4]
# Ten times systemd's own figure, of which 0 to 4 is "OK". USB devices and a port on loopback leave some of it.
MOST_EXPOSED = 20


def verify(folder):
    # The program need not be installed here: any that can be executed stands for it.
    text = open(unit).read()
    installed = re.search(r"^ExecStart=(\S+)", text, re.M).group(1)
    copy = folder + "/dermap.service"
    with open(copy, "w") as file:
        file.write(text.replace(installed, os.path.abspath(dermap)))
    found = subprocess.run(["systemd-analyze", "verify", copy], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    ours = [line for line in found.stdout.splitlines() if "dermap" in line]
    if ours or found.returncode != 0:
        sys.exit("systemd-analyze verify: %d\n%s" % (found.returncode, found.stdout))
    exposed = subprocess.run(["systemd-analyze", "security", "--offline=true", "--threshold=%d" % MOST_EXPOSED, copy],
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if exposed.returncode != 0:
        sys.exit("systemd-analyze security: %s" % exposed.stdout.splitlines()[-1])
    if re.search(r"^(Type=notify|WatchdogSec=\d+)$.*^(Type=notify|WatchdogSec=\d+)$", text, re.M | re.S) is None:
        sys.exit("the unit has no Type=notify with a watchdog")


def notifies(folder):
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    listener.bind(folder + "/notify")
    listener.settimeout(60)  # only so that a failure ends
    environment = dict(os.environ, NOTIFY_SOCKET=folder + "/notify", WATCHDOG_USEC="400000")
    daemon = subprocess.Popen([dermap, "serve", "--rig", rig, "--root", folder + "/sessions", "--listen", "127.0.0.1:0"],
                              env=environment, stderr=subprocess.DEVNULL)
    try:
        words = [listener.recv(200).decode() for _ in range(3)]
        if words != ["READY=1", "WATCHDOG=1", "WATCHDOG=1"]:
            sys.exit("the daemon said %s" % words)
        daemon.send_signal(signal.SIGTERM)
        while (word := listener.recv(200).decode()) == "WATCHDOG=1":
            pass
        if word != "STOPPING=1" or daemon.wait(60) != 0:
            sys.exit("at its end the daemon said %s" % word)
    finally:
        daemon.kill()
        daemon.wait()


if shutil.which("systemd-analyze") is None:
    print("skipped: no systemd-analyze here")
    sys.exit(77)
with tempfile.TemporaryDirectory() as place:
    verify(place)
    notifies(place)
