"""The shipped suite with several seeds in several parts through a real Slurm, beside the same night on one machine: runs,
figures, a baseline accepted on it, the next night against that baseline, pages. A folder in which the two differ is kept.

    slurm_long.py PROGRAM SEEDS PARTS [WORD...]     WORD...: further options of nightly, such as --only production
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time

import slurm as real
from night_facts import facts, page

PROGRAM, SEEDS, PARTS, *WORDS = sys.argv[1:]
PROGRAM = os.path.abspath(PROGRAM)
LONGEST_S = 4 * 3600
RUNS_OF_A_BASELINE = 8


def call(*words, codes=(0, 1, 6), environment=None):
    begun = time.monotonic()
    done = subprocess.run([PROGRAM, *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          env=environment, timeout=LONGEST_S)
    if done.returncode not in codes:
        raise AssertionError(f"tactbench {' '.join(words)} ended with {done.returncode}\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    print(f"{time.monotonic() - begun:7.1f} s  tactbench {' '.join(words)}: {done.stdout.strip().splitlines()[-1]}", flush=True)


def first_difference(a, b):
    """Where two nested values differ first, in words; nothing where they do not."""
    if type(a) is type(b) and isinstance(a, dict):
        pairs = [(key, a.get(key), b.get(key)) for key in {**a, **b}]
    elif type(a) is type(b) and isinstance(a, (list, tuple)) and len(a) == len(b):
        pairs = [(i, x, y) for i, (x, y) in enumerate(zip(a, b))]
    else:
        return "" if a == b else f": {str(a)[:300]} and {str(b)[:300]}"
    for key, x, y in pairs:
        said = first_difference(x, y)
        if said:
            return f"[{key}]{said}"
    return ""


def same(what, a, b):
    said = first_difference(a, b)
    assert not said, f"{what} differ: in parts and on one machine{said}"


def compare():
    begun = time.monotonic()
    parts = dict(zip(("runs", "trends", "baselines"), facts(PROGRAM, folder, "parts.db")))
    one = dict(zip(("runs", "trends", "baselines"), facts(PROGRAM, folder, "one.db")))
    for night in (parts, one):
        for baseline in night["baselines"]:
            baseline.pop("accepted_utc")
    same("the stores", parts, one)
    for name in ("parts", "one"):
        call("db", "check", "--db", f"{name}.db", codes=(0,))
    print(f"{time.monotonic() - begun:7.1f} s  the stores are equal", flush=True)
    return len(one["runs"])


def same_page(a, b):
    same(f"{a} and {b}", *(page(os.path.join(folder, name)).splitlines() for name in (a, b)))


for name in [name for name in os.environ if name.startswith("TACTBENCH_")]:
    del os.environ[name]
why = real.missing()
if why:
    print(f"SKIPPED: {why}")
    sys.exit(77)
folder = tempfile.mkdtemp(prefix="tactbench-slurm-")
os.environ["TACTBENCH_RUNTIME_DIR"] = os.environ["XDG_STATE_HOME"] = os.path.join(folder, "own")
os.mkdir(os.path.join(folder, "own"), 0o700)
try:
    with real.Slurm(folder) as slurm:
        night = ["nightly", "nightly", "--seeds", SEEDS, "--jobs", "1", "-q", *WORDS]
        call("fleet", "slurm", "--shards", PARTS, "--", *night, "--db", "parts.db", "--html", "parts.html",
             environment={**os.environ, **slurm.environment})
    night[night.index("--jobs") + 1] = "2"
    call(*night, "--db", "one.db", "--html", "one.html")
    runs = compare()
    same_page("parts.html", "one.html")
    if int(SEEDS) >= RUNS_OF_A_BASELINE:
        for db in ("parts.db", "one.db"):
            call("baseline", "accept", f"1-{runs}", "--db", db, "--by", "test", "--reason", "as made", codes=(0,))
        compare()
        for db in ("parts.db", "one.db"):
            call("nightly", "nightly", *(WORDS or ["--only", "paper"]), "--seed", "99", "--db", db, "--html", db + ".html", "-q")
        same_page("parts.db.html", "one.db.html")
except BaseException:
    print(f"kept: {folder}")
    raise
shutil.rmtree(folder, ignore_errors=True)
print(f"{runs} runs: the night in {PARTS} parts through Slurm is that of one machine")
