"""A night in three parts by the script that ships, under a real Slurm and without: it is the night of one machine. A part that
is killed leaves no store, and the same command carries out that part alone.

    night.py PROGRAM SCRIPT
"""

import glob
import os
import signal
import subprocess
import sys
import tempfile
import time

import slurm as real
from night_facts import facts, page
from server import LONGEST_S, Program, environment, expect

PROGRAM, SCRIPT = map(os.path.abspath, sys.argv[1:])
SUITE = """schema = 1
name = "parts"
[[scenario]]
name = "judged"
about = "models judged on another run"
recipes = ["production"]
held_out = []
[[scenario]]
name = "rest"
about = "no fit"
recipes = ["equilibration"]
fits = false
[[scenario]]
name = "red"
about = "more frames than it has"
recipes = ["equilibration"]
fits = false
[scenario.figures]
frames = [1, 2]
"""
NIGHT = ["./parts.toml", "--seeds", "2", "--jobs", "1"]


def part(number, folder, **more):
    return subprocess.Popen(["sh", SCRIPT, "3", folder, *NIGHT], cwd=lab.folder, stdin=subprocess.DEVNULL,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True,
                            env={**environment(), "TACTBENCH": PROGRAM, "PART": str(number), **more})


def merged(name, folder):
    lab.run("runs", "merge", *sorted(glob.glob(f"{lab.folder}/{folder}/part-*.db")), "--db", f"{name}.db", "--html",
            f"{name}.html", code=1)
    for what in (lambda night: facts(PROGRAM, lab.folder, f"{night}.db"), lambda night: page(f"{lab.folder}/{night}.html")):
        expect(what(name) == what("one"), (name, "is the night of one machine"))


with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as place:
    lab = Program(PROGRAM, place)
    with open(f"{place}/parts.toml", "w") as file:
        file.write(SUITE)
    lab.run("nightly", *NIGHT, "--db", "one.db", "--html", "one.html", code=1)
    os.mkdir(f"{place}/hand")
    killed = part(2, "hand")
    time.sleep(0.5)
    os.killpg(killed.pid, signal.SIGKILL)
    killed.wait()
    expect(os.listdir(f"{place}/hand") == [], "a part that was killed leaves no store")
    expect(part(1, "nowhere").wait(LONGEST_S) != 0 and part("x", "hand").wait(LONGEST_S) == 2, "what cannot be done fails")
    ends = [part(number, "hand").wait(LONGEST_S) for number in (1, 2, 3)]
    expect(ends == [0, 0, 0], ends)
    stamps = [os.stat(path).st_mtime_ns for path in sorted(glob.glob(f"{place}/hand/part-*.db"))]
    expect([part(number, "hand").wait(LONGEST_S) for number in (1, 2, 3)] == [0, 0, 0], "again")
    expect(stamps == [os.stat(path).st_mtime_ns for path in sorted(glob.glob(f"{place}/hand/part-*.db"))], "nothing anew")
    merged("hand", "hand")
    print("a night in three parts is the night of one machine")
    if why := real.missing():
        print(f"not under Slurm: {why}")
        sys.exit(0)
    with real.Slurm(place) as slurm:
        os.mkdir(f"{place}/slurm-night")
        done = subprocess.run(["sbatch", "--wait", "--array=1-3", f"--output={place}/part-%a.log", SCRIPT, "3",
                               f"{place}/slurm-night", *NIGHT], cwd=place, capture_output=True, text=True, timeout=900,
                              env={**slurm.environment, **environment(SLURM_CONF=slurm.environment["SLURM_CONF"]), "TACTBENCH": PROGRAM})
        expect(done.returncode == 0, (done.stdout, done.stderr, *[open(log).read()[-500:] for log in glob.glob(f"{place}/part-*.log")]))
        merged("array", "slurm-night")
        print("and under Slurm as well")
