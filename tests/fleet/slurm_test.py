"""`tactbench fleet slurm` with a real Slurm: four scenarios with three seeds in three parts, one of which is killed once;
the same parts under GNU parallel. Both nights are that of one machine. Argument: the program."""

import glob
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time

import slurm as real
from night_facts import facts, page

PROGRAM = sys.argv[1]
SUITE = """schema = 1
name = "parts"
[[scenario]]
name = "judged"
about = "models judged on another run"
recipes = ["production"]
held_out = ["recipe.repeats=1"]
[[scenario]]
name = "rest"
about = "no fit"
recipes = ["equilibration"]
fits = false
[[scenario]]
name = "red"
about = "a dead taxel that this scenario knows nothing of"
recipes = ["production"]
set = ['simulation.defect=[{kind="dead",row=3,column=4}]']
[[scenario]]
name = "steps"
about = "no fit either"
recipes = ["equilibration"]
fits = false
[scenario.figures]
frames = [60, 60.5]
"""
NIGHT = ["nightly", "./parts.toml", "--seeds", "3", "--jobs", "1"]


def call(*words, code=0, environment=None):
    done = subprocess.run([PROGRAM, *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300,
                          env=environment)
    assert done.returncode == code, (words, done.returncode, done.stdout[-2000:], done.stderr[-2000:])
    return done


def kill_once(shard, killed):
    """SIGKILL to the first process in this folder that carries out that part."""
    while not killed:
        for path in glob.glob("/proc/[0-9]*/cmdline"):
            try:
                with open(path, "rb") as file:
                    words = file.read().split(b"\0")
                if f"{shard}".encode() in words and b"nightly" in words and os.readlink(path[:-7] + "cwd") == folder:
                    os.kill(int(path.split("/")[2]), signal.SIGKILL)
                    killed.append(path)
                    return
            except (OSError, ValueError):
                continue
        time.sleep(0.01)


why = real.missing()
if why:
    print(f"SKIPPED: {why}")
    sys.exit(77)
with tempfile.TemporaryDirectory() as folder:
    folder = os.path.realpath(folder)
    for name in ("TACTBENCH_BENCH", "TACTBENCH_DB"):
        os.environ.pop(name, None)
    with open(os.path.join(folder, "parts.toml"), "w") as file:
        file.write(SUITE)
    call(*NIGHT, "--db", "one.db", "--html", "one.html", code=1)
    with real.Slurm(folder) as slurm:
        job = ["fleet", "slurm", "--shards", "3", "--tries", "1", "--", *NIGHT, "--db", "night.db", "--html", "night.html"]
        killed = []
        hunter = threading.Thread(target=kill_once, args=("2/3", killed), daemon=True)
        hunter.start()
        failed = call(*job, code=6, environment=slurm.environment)
        assert killed
        assert "TB-FLEET-SHARDS" in failed.stderr and "1 of 3 parts failed" in failed.stderr, failed.stderr
        assert "part 2 (" in failed.stderr and "exit code 137" in failed.stderr, failed.stderr
        assert not os.path.exists(os.path.join(folder, "night.db")), "nothing is put together of a part of a night"
        # The same words again: that part alone.
        done = call(*job, code=1, environment=slurm.environment)
        assert re.search(r"^2 parts done already: 2 left$", done.stderr, re.M), done.stderr
        assert re.search(r"^job \d+: part 2$", done.stderr, re.M), done.stderr
        assert "9 green, 3 red, 0 not run" in done.stdout, done.stdout
        assert facts(PROGRAM, folder, "night.db") == facts(PROGRAM, folder, "one.db")
        assert page(os.path.join(folder, "night.html")) == page(os.path.join(folder, "one.html"))
        call("db", "check", "--db", "night.db")
        # Killed once, a part is submitted again by itself; the next night begins anew in the same folder.
        killed = []
        hunter = threading.Thread(target=kill_once, args=("1/3", killed), daemon=True)
        hunter.start()
        again = ["fleet", "slurm", "--shards", "3", "--", *NIGHT, "--only", "judged", "--db", "night.db"]
        done = call(*again, environment=slurm.environment)
        assert killed and re.search(r"^job \d+: part 1 again$", done.stderr, re.M), done.stderr
        assert "same frames as run" in done.stdout, done.stdout
        # What Slurm refuses is said, and nothing is waited for.
        refused = call("fleet", "slurm", "--shards", "2", "--sbatch=--partition=none", "--", *NIGHT, "--only", "rest", "--db",
                       "new.db", code=6, environment=slurm.environment)
        assert "TB-FLEET-SLURM" in refused.stderr and "partition" in refused.stderr, refused.stderr
    # A part is a script and its number, whoever starts it.
    script = json.loads(call("fleet", "slurm", "--shards", "3", "--no-submit", "--folder", "by-hand", "--json", "--", *NIGHT,
                             "--db", "hand.db").stdout)["script"]
    parallel = ["parallel", "-j2", "sh", script, ":::", "1", "2", "3"]
    if subprocess.run(["which", "parallel"], capture_output=True).returncode != 0:
        parallel = ["xargs", "-P2", "-n1", "sh", script]
    subprocess.run(parallel, cwd=folder, input="1\n2\n3\n", text=True, check=True, capture_output=True, timeout=300)
    call("runs", "merge", *sorted(glob.glob(os.path.join(folder, "by-hand", "shard-*.db"))), "--db", "hand.db", "--html",
         "hand.html", code=1)
    assert facts(PROGRAM, folder, "hand.db") == facts(PROGRAM, folder, "one.db") and page(os.path.join(folder, "hand.html")) == page(os.path.join(folder, "one.html"))
    # Without Slurm it is said what is missing.
    lonely = call(*again, code=2, environment=dict(os.environ, PATH="/nowhere"))
    assert "TB-FLEET-NO-SLURM" in lonely.stderr, lonely.stderr
print("a night in three parts under Slurm, one of them killed, is the night of one machine")
