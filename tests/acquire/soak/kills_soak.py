#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# Kills a capture at random moments and resumes it, again and again; then tells how many frames were lost, doubled or
# mislabelled. With EMULATOR the devices are emulated below the real drivers, outlive the killed capture with whatever
# state it left them in, and fail at random as well.
# Usage: kills_soak.py DERMAP [--emulator EMULATOR] [--kills N] [--seed N]
import argparse
import fcntl
import json
import os
import random
import select
import subprocess
import sys
import tempfile
import time

sys.path[:0] = [os.path.dirname(os.path.abspath(__file__)) + up for up in ("", "/..")]
from session_check import check
from small_station import write_station

FAULTS = ["busy", "stall", "truncated", "repeated", "unplug", "unplug-read", "settings", "ram"]
LONGEST_RESUMPTION_S = 300  # of a session that nobody kills any more


class Captures:
    def __init__(self, dermap, folder, session, log):
        self.command = [dermap, "capture", folder + "/plan.toml", "--rig", folder + "/rig.toml", "--out", session]
        self.session, self.log = session, log

    def start(self):
        """Begins the session, or goes on with it. Questions and answers pass to whoever runs us: the emulator."""
        begun = os.path.exists(self.session + "/journal.jsonl") and os.path.getsize(self.session + "/journal.jsonl") > 0
        if not begun:
            subprocess.run(["rm", "-rf", self.session], check=True)
        return subprocess.Popen(self.command + (["--resume"] if begun else []), stdout=self.log)


def confirmed(session):
    """Number and hash of the frames that the journal tells of; the last of each number counts."""
    try:
        lines = open(session + "/journal.jsonl").read().split("\n")[:-1]
    except FileNotFoundError:
        return {}
    events = [json.loads(line) for line in lines]
    return {e["frame"]["number"]: e["frame"]["sha256"] for e in events if e["event"] == "frame"}


def forget_answers():
    """An answer that the killed capture did not read is not for the next one."""
    time.sleep(0.05)
    while select.select([0], [], [], 0)[0] and os.read(0, 4096):
        pass


def wait_for_journal(session):
    """A killed capture's helper may outlive it a little; the journal's lock tells that all is over."""
    try:
        with open(session + "/journal.jsonl") as journal:
            fcntl.flock(journal, fcntl.LOCK_EX)
    except FileNotFoundError:
        pass


def kill_and_resume(options, folder):
    rng = random.Random(options.seed)
    wrong, light, kills, sessions, longest_s = [], {}, 0, 0, None
    with open(folder + "/log", "w") as log:
        while kills < options.kills:
            session = "%s/session_%d" % (folder, sessions)
            sessions += 1
            captures = Captures(options.dermap, folder, session, log)
            before = {}
            start = time.monotonic()
            process = captures.start()
            while longest_s and kills < options.kills:  # the first one is left alone, to know how long it takes
                moment_s = rng.uniform(0, longest_s)
                try:
                    process.wait(moment_s)
                    break
                except subprocess.TimeoutExpired:
                    pass
                process.kill()
                process.wait()
                kills += 1
                if options.emulated:
                    forget_answers()
                wait_for_journal(session)
                now = confirmed(session)
                gone = [number for number, sha256 in before.items() if number not in now]
                wrong += ["lost: frame %d of session %d from the journal" % (n, sessions) for n in gone]
                before = now
                print("kill %d after %.0f ms: %d frames confirmed" % (kills, 1000 * moment_s, len(now)), flush=True)
                process = captures.start()
            code = process.wait(LONGEST_RESUMPTION_S)
            if code != 0:
                wrong.append("lost: session %d ended with %d" % (sessions, code))
                if code == 3 or code == 1:  # a device's fault that lasts: resumed, as an operator would
                    wrong.pop()
                    code = captures.start().wait(LONGEST_RESUMPTION_S)
            if longest_s is None:
                longest_s = time.monotonic() - start
            problems = check(session, light) if code == 0 else ["lost: session ended with %d" % code]
            after = confirmed(session)
            problems += ["lost: frame %d was confirmed, and taken again" % n for n, s in before.items() if after.get(n) != s]
            if subprocess.run([options.dermap, "verify", session], stdout=log).returncode != 0:
                problems.append("lost: does not verify")
            for problem in problems:
                print("session %d: %s" % (sessions, problem), flush=True)
            wrong += problems
            subprocess.run(["rm", "-rf", session], check=True)
    counts = ", ".join("%d %s" % (sum(w.startswith(kind) for w in wrong), kind)
                       for kind in ("lost", "doubled", "mislabelled"))
    print("soak: %d kills in %d sessions on %s devices: frames: %s" %
          (kills, sessions, "emulated" if options.emulated else "simulated", counts))
    return 1 if wrong else 0


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("dermap")
    parser.add_argument("--emulator")
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--emulated", metavar="FOLDER", help="what the emulator runs: ourselves, on its devices")
    options = parser.parse_args()
    if options.emulated:
        return kill_and_resume(options, options.emulated)
    with tempfile.TemporaryDirectory() as folder:
        write_station(folder, *(("starlight", "gphoto2") if options.emulator else ("simulated", "simulated")))
        if not options.emulator:
            return kill_and_resume(options, folder)
        rng = random.Random(options.seed)
        presses = [p for p in range(10, 8 * options.kills) if rng.random() < 1 / 20]
        faults = [word for p in presses for word in ("--fault", "%s@%d:0.4" % (rng.choice(FAULTS), p))]
        return subprocess.run([options.emulator, "--rig", folder + "/rig.toml"] + faults +
                              ["--", sys.executable, __file__, options.dermap, "--emulated", folder, "--kills",
                               str(options.kills), "--seed", str(options.seed)]).returncode


if __name__ == "__main__":
    sys.exit(main())
