#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# Takes one session after the other with one daemon, on emulated devices below the real drivers, with random faults,
# pauses, ends, resumptions and retakes, while others watch; then tells whether anything was lost, got stuck or leaked.
# Usage: sessions_soak.py DERMAP EMULATOR [--sessions N] [--seed N] [--watchers N]
import argparse
import http.client
import json
import os
import random
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time

sys.path[:0] = [os.path.dirname(os.path.abspath(__file__)) + up for up in ("", "/..")]
from session_check import check
from small_station import EXPECTED, ServedStation, write_station

# Faults and how often they strike, relative to each other; those that cost many seconds are rare.
CAMERA_FAULTS = [("busy", 10), ("stall", 10), ("truncated", 10), ("repeated", 10), ("ram", 10), ("settings", 10),
                 ("unplug", 8), ("unplug-read", 8), ("sleep", 8), ("second-client", 6), ("full", 6), ("late", 4),
                 ("hang", 2), ("missing", 1)]
WHEEL_FAULTS = [("wheel-slip", 8), ("wheel-unplug", 8), ("wheel-silent", 3), ("wheel-stuck", 1)]
SECONDS = {"full": 0, "second-client": 0.3, "late": 1}
MOST_SECONDS_WITHOUT_CHANGE = 150  # beyond it a session is stuck: the longest wait of a driver is 30 s
MOST_FAILURES = 10  # of one session, likewise: each is resumed
MOST_GROWTH_MB = 0.5  # of the daemon from the second quarter of the sessions to the last, where there are enough of them
FILES_OF_A_PLUG = 2  # that the emulator keeps while somebody has the device's node open
ENOUGH_SESSIONS = 100  # fewer tell warming up from leaking in files and threads alone


def plan_faults(rng, sessions):
    """NAME@COUNT:SECONDS for about every second session, camera and wheel."""
    faults = []
    for names, counts, share in ((CAMERA_FAULTS, 8 * sessions, 1 / 14), (WHEEL_FAULTS, 6 * sessions, 1 / 40)):
        for count in range(3, counts):
            if rng.random() < share:
                name = rng.choices([n for n, _ in names], [w for _, w in names])[0]
                faults.append("%s@%d:%g" % (name, count, SECONDS.get(name, 0.4)))
    return faults


class Watchers:
    """So many clients of the event stream; tells how many were cut off."""

    def __init__(self, port, count):
        self.lost, self.bytes, self.ending = 0, 0, False
        self.threads = [threading.Thread(target=self.watch, args=(port,)) for _ in range(count)]
        for thread in self.threads:
            thread.start()

    def watch(self, port):
        with socket.create_connection(("127.0.0.1", port)) as stream:
            stream.sendall(b"GET /api/events HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n" % port)
            stream.settimeout(30)
            while not self.ending:
                block = stream.recv(1 << 16)
                if not block:
                    self.lost += not self.ending
                    return
                self.bytes += len(block)

    def end(self):
        self.ending = True
        for thread in self.threads:
            thread.join()


class Station(ServedStation):
    """One that is steered."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        self.key = ""
        self.steer()
        children = open("/proc/%d/task/%d/children" % (self.process.pid, self.process.pid)).read().split()
        self.daemon = int(children[0])

    def ask(self, method, path, body=None):
        headers = {"X-Dermap-Key": self.key, "Content-Type": "application/json"}
        self.connection.request(method, path, None if body is None else json.dumps(body), headers)
        answer = self.connection.getresponse()
        text = answer.read()
        return answer.status, json.loads(text) if text else {}

    def steer(self):
        status, answer = self.ask("POST", "/api/steer", {"key": self.key})
        if status != 200:
            raise RuntimeError("no helm: %s" % answer)
        self.key = answer["key"]

    def state(self):
        return self.ask("GET", "/api/state")[1]


def usage(pid):
    """MB in memory, open files and threads of a process."""
    status = open("/proc/%d/status" % pid).read()
    rss = int(re.search(r"VmRSS:\s+(\d+)", status).group(1)) / 1024
    return rss, len(os.listdir("/proc/%d/fd" % pid)), int(re.search(r"Threads:\s+(\d+)", status).group(1))


class Soak:
    def __init__(self, station, rng):
        self.station, self.rng = station, rng
        self.counts = {"faults seen to": 0, "ended and resumed": 0, "paused": 0, "retakes": 0, "failed and resumed": 0}

    def act_at_random(self, state):
        """What an operator might do at any moment."""
        if state["state"] == "running" and self.rng.random() < 0.004:
            if self.station.ask("POST", "/api/pause", {})[0] == 200:
                self.counts["paused"] += 1
        elif state["state"] in ("running", "waiting") and self.rng.random() < 0.002:
            self.station.ask("POST", "/api/abort", {})

    def take(self, name):
        """One session to its end; returns what is wrong."""
        form = {"session": name, "subject": "S%d" % self.rng.randrange(100), "resume": False}
        if self.station.ask("POST", "/api/start", form)[0] != 200:
            return ["stuck: does not start"]
        form["resume"] = True
        retake = self.rng.random() < 0.2
        changed, version, failures = time.monotonic(), 0, 0
        while True:
            state = self.station.state()
            if state["version"] != version:
                changed, version = time.monotonic(), state["version"]
            elif time.monotonic() - changed > MOST_SECONDS_WITHOUT_CHANGE:
                return ["stuck: %s, %s, %s" % (state["state"], state["step"], state["request"])]
            if state["state"] == "waiting":
                time.sleep(0.05)  # the emulated operator reads the same request, and puts the target in place
                if state["request"]["kind"] == "fault":
                    self.counts["faults seen to"] += 1
                self.station.ask("POST", "/api/answer", {})
            elif state["state"] == "paused":
                self.station.ask("POST", "/api/continue", {})
            elif state["state"] in ("ended", "failed"):
                self.counts["ended and resumed" if state["state"] == "ended" else "failed and resumed"] += 1
                failures += state["state"] == "failed"
                if failures > MOST_FAILURES:
                    return ["stuck: fails again and again: %s" % state["problem"]]
                begun = os.path.exists("%s/%s/journal.jsonl" % (self.station.sessions, name))
                self.station.ask("POST", "/api/start", dict(form, resume=begun))
            elif state["state"] == "complete" and retake:
                retake = False
                self.counts["retakes"] += 1
                self.station.ask("POST", "/api/retake", {"number": self.rng.randrange(1, len(EXPECTED) + 1)})
            elif state["state"] == "complete":
                return []
            self.act_at_random(state)
            self.station.steer()
            time.sleep(0.03)


def run(options, folder):
    rng = random.Random(options.seed)
    faults = plan_faults(rng, options.sessions)
    wheel = rng.choice(["starlight", "thorlabs"])
    write_station(folder, wheel)
    station = Station(options.dermap, options.emulator, folder, faults, wheel)
    watchers = Watchers(station.port, options.watchers)
    soak, wrong, light, used = Soak(station, rng), [], {}, []
    print("%d sessions, seed %d, wheel %s, %d faults planned, %d watchers" %
          (options.sessions, options.seed, wheel, len(faults), options.watchers), flush=True)
    for number in range(1, options.sessions + 1):
        name = "session_%d" % number
        problems = soak.take(name)
        problems += check(station.sessions + "/" + name, light) if not problems else []
        wrong += ["session %d: %s" % (number, p) for p in problems]
        for problem in problems:
            print("session %d: %s" % (number, problem), flush=True)
        if any(p.startswith("stuck") for p in problems) or len(wrong) > 20:
            break
        subprocess.run(["rm", "-rf", station.sessions + "/" + name], check=True)
        used.append(usage(station.daemon) + usage(station.process.pid))
        if number % max(1, options.sessions // 25) == 0:
            print("after %d sessions: daemon %.1f MB, %d files, %d threads; emulator %.1f MB, %d files, %d threads" %
                  ((number,) + used[-1]), flush=True)
    watchers.end()
    code = station.close()
    if wrong:
        print("".join(list(station.log)[-40:]))
    return soak, wrong, used, watchers, code


def growth(used):
    """Of each figure, from the second quarter of the sessions to the last: by then everything has been in use once."""
    quarter = max(1, len(used) // 4)
    middle, last = used[quarter:2 * quarter] or used, used[-quarter:]
    return [sum(after) / len(last) - sum(before) / len(middle) for before, after in zip(zip(*middle), zip(*last))]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("dermap")
    parser.add_argument("emulator")
    parser.add_argument("--sessions", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--watchers", type=int, default=50)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        soak, wrong, used, watchers, code = run(options, folder)
    growth_mb, files, threads, *of_emulator = growth(used)
    kinds = {kind: sum(kind in w for w in wrong) for kind in ("lost", "doubled", "mislabelled", "stuck")}
    print("soak: %d sessions: %s; %s; %d watchers cut off" %
          (len(used), ", ".join("%d %s" % (n, kind) for kind, n in kinds.items()),
           ", ".join("%d %s" % (n, what) for what, n in soak.counts.items()), watchers.lost))
    print("soak: from the second quarter to the last: daemon %+.2f MB, %+.1f files, %+.1f threads; emulator %+.2f MB, "
          "%+.1f files, %+.1f threads; ended with %d" % (growth_mb, files, threads, *of_emulator, code))
    leaks = max(files, threads) > 0.5
    if len(used) >= ENOUGH_SESSIONS:
        leaks = leaks or growth_mb > MOST_GROWTH_MB or max(of_emulator[1:]) > 2 * FILES_OF_A_PLUG
    if leaks:
        print("soak: it leaks")
    return 1 if wrong or leaks or watchers.lost or code != 0 else 0


if __name__ == "__main__":
    sys.exit(main())
