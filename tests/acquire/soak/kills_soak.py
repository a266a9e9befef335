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
LONGEST_END_S = 60  # of the emulator, once its program is over
STUCK = "stuck"


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


class Soak:
    def __init__(self, options, folder, log):
        self.options, self.folder, self.log = options, folder, log
        self.rng = random.Random(options.seed)
        self.wrong, self.light, self.kills, self.sessions = [], {}, 0, 0
        self.longest_s = None  # that a session takes: the first one is left alone, to know

    def finish(self, process):
        """Its exit status; one that does not end is killed and counts as stuck."""
        try:
            return process.wait(LONGEST_RESUMPTION_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            return STUCK

    def kill_at_random(self, captures, process, before):
        """Kills and resumes until it ends by itself or has had its kills; returns the last one to run."""
        while self.longest_s and self.kills < self.options.kills:
            moment_s = self.rng.uniform(0, self.longest_s)
            try:
                process.wait(moment_s)
                break
            except subprocess.TimeoutExpired:
                pass
            process.kill()
            process.wait()
            self.kills += 1
            if self.options.emulated:
                forget_answers()
            wait_for_journal(captures.session)
            now = confirmed(captures.session)
            gone = [n for n in before if n not in now]
            self.wrong += ["lost: frame %d of session %d from the journal" % (n, self.sessions) for n in gone]
            before.clear()
            before.update(now)
            print("kill %d after %.0f ms: %d frames confirmed" % (self.kills, 1000 * moment_s, len(now)), flush=True)
            process = captures.start()
        return process

    def take_session(self):
        """What is wrong with it in the end."""
        session = "%s/session_%d" % (self.folder, self.sessions)
        self.sessions += 1
        captures = Captures(self.options.dermap, self.folder, session, self.log)
        before, start = {}, time.monotonic()
        code = self.finish(self.kill_at_random(captures, captures.start(), before))
        if code in (1, 3):  # a device's fault that lasts: resumed, as an operator would
            code = self.finish(captures.start())
        self.longest_s = self.longest_s or time.monotonic() - start
        if code == STUCK:
            return ["stuck: session does not end in %d s" % LONGEST_RESUMPTION_S]
        problems = check(session, self.light) if code == 0 else ["lost: session ended with %d" % code]
        after = confirmed(session)
        problems += ["lost: frame %d was confirmed, and taken again" % n for n, s in before.items() if after.get(n) != s]
        if subprocess.run([self.options.dermap, "verify", session], stdout=self.log).returncode != 0:
            problems.append("lost: does not verify")
        subprocess.run(["rm", "-rf", session], check=True)
        return problems

    def run(self):
        while self.kills < self.options.kills and not any(w.startswith("stuck") for w in self.wrong):
            problems = self.take_session()
            for problem in problems:
                print("session %d: %s" % (self.sessions, problem), flush=True)
            self.wrong += problems
        counts = ", ".join("%d %s" % (sum(w.startswith(kind) for w in self.wrong), kind)
                           for kind in ("lost", "doubled", "mislabelled", "stuck"))
        print("soak: %d kills in %d sessions on %s devices: frames: %s" %
              (self.kills, self.sessions, "emulated" if self.options.emulated else "simulated", counts), flush=True)
        return 1 if self.wrong else 0


def kill_and_resume(options, folder):
    with open(folder + "/log", "w") as log:
        return Soak(options, folder, log).run()


def run_in_emulator(options, folder):
    """Ourselves below the emulator; once the totals are told it has to end, or is killed."""
    rng = random.Random(options.seed)
    presses = [p for p in range(10, 8 * options.kills) if rng.random() < 1 / 20]
    faults = [word for p in presses for word in ("--fault", "%s@%d:0.4" % (rng.choice(FAULTS), p))]
    emulator = subprocess.Popen([options.emulator, "--rig", folder + "/rig.toml"] + faults +
                                ["--", sys.executable, __file__, options.dermap, "--emulated", folder, "--kills",
                                 str(options.kills), "--seed", str(options.seed)], stdout=subprocess.PIPE, text=True)
    for line in emulator.stdout:
        print(line, end="", flush=True)
        if line.startswith("soak:"):
            break
    try:
        return emulator.wait(LONGEST_END_S)
    except subprocess.TimeoutExpired:
        emulator.kill()
        print("soak: the emulator itself does not end")
        return 1


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
        return run_in_emulator(options, folder)


if __name__ == "__main__":
    sys.exit(main())
