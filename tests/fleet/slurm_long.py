"""The shipped suite with several seeds in several parts through a real Slurm, beside the same night on one machine: runs,
figures, a baseline accepted on it, the next night against that baseline, pages. Arguments: the program, seeds, parts."""

import os
import subprocess
import sys
import tempfile
import time

import slurm as real
from night_facts import facts, page

PROGRAM, SEEDS, PARTS = sys.argv[1], sys.argv[2], sys.argv[3]


def call(*words, codes=(0, 1, 6), environment=None):
    begun = time.monotonic()
    done = subprocess.run([PROGRAM, *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          env=environment)
    assert done.returncode in codes, (words, done.returncode, done.stdout[-3000:], done.stderr[-3000:])
    print(f"{time.monotonic() - begun:7.1f} s  tactbench {' '.join(words)}: {done.stdout.strip().splitlines()[-1]}", flush=True)
    return done


for name in ("TACTBENCH_BENCH", "TACTBENCH_DB"):
    os.environ.pop(name, None)
why = real.missing()
if why:
    print(f"SKIPPED: {why}")
    sys.exit(77)
with tempfile.TemporaryDirectory() as folder, real.Slurm(folder) as slurm:
    environment = slurm.environment
    night = ["nightly", "nightly", "--seeds", SEEDS, "--jobs", "1", "-q"]
    call("fleet", "slurm", "--shards", PARTS, "--", *night, "--db", "parts.db", "--html", "parts.html", environment=environment)
    night[night.index("--jobs") + 1] = "2"
    call(*night, "--db", "one.db", "--html", "one.html")
    runs = len(facts(PROGRAM, folder, "one.db")[0])
    assert facts(PROGRAM, folder, "parts.db") == facts(PROGRAM, folder, "one.db")
    assert page(os.path.join(folder, "parts.html")) == page(os.path.join(folder, "one.html"))
    if int(SEEDS) >= 8:
        for db in ("parts.db", "one.db"):
            call("baseline", "accept", f"1-{runs}", "--db", db, "--by", "test", "--reason", "as made", codes=(0,))
        a, b = facts(PROGRAM, folder, "parts.db"), facts(PROGRAM, folder, "one.db")
        for baseline in (*a[2], *b[2]):
            baseline.pop("accepted_utc")
        assert a == b
        for db in ("parts.db", "one.db"):
            call("nightly", "nightly", "--only", "paper", "--seed", "99", "--db", db, "--html", db + ".html", "-q")
        assert page(os.path.join(folder, "parts.db.html")) == page(os.path.join(folder, "one.db.html"))
    print(f"{runs} runs: the night in {PARTS} parts through Slurm is that of one machine")
