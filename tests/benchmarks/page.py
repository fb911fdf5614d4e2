"""What the page costs: its process with 8 viewers at about 20 pictures a second, and a run beside it.

    tests/benchmarks/page.py build/tactbench

Prints lines FIGURE name value unit.
"""

import json
import os
import socket
import sqlite3
import statistics
import subprocess
import sys
import tempfile
import threading
import time

VIEWERS = 8
RATE = "48"  # process seconds in a real one: about 20 frames a second of one scan in 2.4 s
PAIRS, REPEATS = 5, 10  # of runs with viewers and without; of `descending` in each


def figure(name, value, unit):
    print(f"FIGURE page_{name} {value:.2f} {unit}")


class Bench:
    def __init__(self, program, folder):
        self.program, self.folder = os.path.abspath(program), folder
        self.tactbench("init")

    def words(self, *words):
        return [self.program, *words]

    def tactbench(self, *words):
        subprocess.run(self.words(*words), cwd=self.folder, check=True, stdout=subprocess.DEVNULL)

    def store(self, name):
        self.tactbench("sensors", "add", "S-1", "--type", "sensor.toml", "--db", name)
        self.run(name, 1)  # so that there is an earlier run
        return name

    def run(self, name, repeats, *more):
        """Carries `descending` out; processor seconds."""
        child = subprocess.Popen(
            self.words("run", "descending", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "benchmark", "--yes", "-q",
                       "--no-seating", "--set", f"recipe.repeats={repeats}", "--set", "recipe.conditioning.cycles=0", "--set",
                       "recipe.conditioning.least=0", "--db", name, *more),
            cwd=self.folder, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        if status != 0:
            raise SystemExit(f"the run ended with {os.waitstatus_to_exitcode(status)}")
        return usage.ru_utime + usage.ru_stime


class Page:
    """`tactbench page` on a store, with viewers."""

    def __init__(self, bench, store, reading=VIEWERS):
        self.child = subprocess.Popen(bench.words("page", "--db", store, "--port", "0", "--json"), cwd=bench.folder,
                                      stdout=subprocess.PIPE, text=True)
        text = ""
        while True:  # one document, over several lines
            text += self.child.stdout.readline()
            try:
                told = json.loads(text)
                break
            except ValueError:
                if self.child.poll() is not None:
                    raise SystemExit("the page does not start: " + text) from None
        self.pictures, self.viewers = {}, []  # when each position first came to the first viewer
        token = told["readers_link"].split("#")[1]
        for number in range(VIEWERS):
            viewer = socket.create_connection(("127.0.0.1", told["port"]))
            viewer.sendall(f"GET /events HTTP/1.1\r\nHost: 127.0.0.1:{told['port']}\r\nAuthorization: Bearer {token}\r\n\r\n"
                           .encode())
            self.viewers.append(viewer)
            if number < reading:  # the others read nothing
                threading.Thread(target=self.read, args=(viewer, number == 0), daemon=True).start()

    def read(self, viewer, first):
        text = b""
        while bytes_ := viewer.recv(65536):
            if not first:
                continue
            text += bytes_
            now = time.monotonic()
            *whole, text = text.split(b"\n\n")
            for event in whole:
                at = event.find(b'"position":')
                if b"event: picture" in event and at >= 0:
                    self.pictures.setdefault(int(event[at + 11:].split(b",")[0].rstrip(b"}")), now)

    def processor_s(self):
        with open(f"/proc/{self.child.pid}/stat", encoding="ascii") as file:
            fields = file.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def resident_mb(self):
        with open(f"/proc/{self.child.pid}/status", encoding="ascii") as file:
            return next(int(line.split()[1]) for line in file if line.startswith("VmHWM")) / 1024

    def __enter__(self):
        time.sleep(0.5)
        return self

    def __exit__(self, *_):
        self.child.terminate()
        self.child.wait()


def watch_store(path, run, stored, ended):
    """When each frame of the run was in the store, or up to 2 ms later."""
    db = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    count = "SELECT count(*) FROM frames JOIN branches USING (branch) WHERE run = ?"
    while not ended.is_set():
        while len(stored) < db.execute(count, (run,)).fetchone()[0]:
            stored.append(time.monotonic())
        time.sleep(0.002)


def serving(bench):
    store = bench.store("served.db")
    with Page(bench, store) as page:
        stored, ended = [], threading.Event()
        watcher = threading.Thread(target=watch_store, args=(os.path.join(bench.folder, store), 2, stored, ended))
        begun, before = time.monotonic(), page.processor_s()
        watcher.start()
        bench.run(store, 1, "--rate", RATE)
        took, core = time.monotonic() - begun, page.processor_s() - before
        ended.set()
        watcher.join()
        delays = [1e3 * (came - stored[position - 1]) for position, came in page.pictures.items()
                  if came > begun and 0 < position <= len(stored)]
        if len(delays) < 10:
            raise SystemExit("the viewers saw too little of the run")
        figure("frames", len(stored) / took, "1/s")
        figure("pictures", len(delays) / took, "1/s")
        figure("core", 100 * core / took, "%")
        figure("core_goal_at_most", 1, "%")
        figure("resident", page.resident_mb(), "MB")
        figure("resident_goal_at_most", 20, "MB")
        figure("stored_to_viewer_p95", sorted(delays)[int(0.95 * len(delays))], "ms")
        figure("stored_to_viewer_p95_goal_at_most", 150, "ms")


def beside(bench):
    ratios = []
    for pair in range(PAIRS):
        alone = bench.run(bench.store(f"alone-{pair}.db"), REPEATS)
        store = bench.store(f"seen-{pair}.db")
        with Page(bench, store, VIEWERS - 1):  # one viewer reads nothing
            ratios.append(bench.run(store, REPEATS) / alone)
    figure("run_with_viewers", statistics.median(ratios), "x")
    figure("run_with_viewers_goal_at_most", 1.02, "x")


with tempfile.TemporaryDirectory(prefix="tactbench-page-") as temporary:
    measured = Bench(sys.argv[1], temporary)
    serving(measured)
    beside(measured)
