"""SIGKILL of `runs merge` at random moments; then the merge again: the store is row by row that of a merge which was left alone,
nothing is doubled, and verify finds it sound, also right after each kill. The parts: a night of three shards, and a bench's
store with runs, fits, tags, a void and a baseline, and a copy of that store with one more fit.

    merge_kills.py PROGRAM KILLS SEED
"""

import os
import random
import shutil
import sqlite3
import sys
import tempfile
import time

from server import Program, expect, make_store

path, kills, seed = sys.argv[1], *map(int, sys.argv[2:])
moments = random.Random(seed)
PARTS = ["shard-1.db", "bench.db", "shard-2.db", "later.db", "shard-3.db"]
RUNS = 9  # one more than a baseline takes at least
SUITE = """schema = 1
name = "parts"
[[scenario]]
name = "judged"
about = "models judged on another run"
recipes = ["./loops.toml"]
held_out = ["recipe.repeats=2"]
[[scenario]]
name = "plain"
about = "no fit"
recipes = ["./loops.toml"]
fits = false
"""


def rows_of(db):
    """All rows of all tables, with their numbers."""
    with sqlite3.connect(f"file:{db}?mode=ro", uri=True) as store:
        tables = [name for name, in store.execute("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY 1")]
        return {table: sorted(store.execute(f'SELECT * FROM "{table}"').fetchall(), key=repr) for table in tables}


def difference(a, b):
    return [(table, len(a.get(table, [])), len(b.get(table, []))) for table in {**a, **b} if a.get(table) != b.get(table)]


with tempfile.TemporaryDirectory(prefix="tactbench-merge-") as folder:
    lab = Program(path, folder)
    make_store(lab, RUNS, "bench.db")
    for run in range(2, RUNS):
        lab.run("fit", run, "--model", "elam", "--db", "bench.db")
    lab.run("runs", "void", RUNS, "--reason", "gauge closed", "--by", "me", "--db", "bench.db")
    lab.run("sensors", "add", "S-2", "--type", "sensor.toml", "--db", "bench.db")
    lab.run("trend", "accept", "1-8", "--db", "bench.db", "--by", "me", "--reason", "as made")
    shutil.copy(os.path.join(folder, "bench.db"), os.path.join(folder, "later.db"))
    lab.run("fit", 4, "--model", "monotone", "--db", "later.db")
    with open(os.path.join(folder, "parts.toml"), "w") as file:
        file.write(SUITE)
    for k in (1, 2, 3):
        lab.run("nightly", "./parts.toml", "--seeds", 3, "--jobs", 1, "--shard", f"{k}/3", "--db", f"shard-{k}.db", "-q")
    merge = ["runs", "merge", *PARTS, "--db"]

    def merged(db):
        """Merges, which has to end, and with the night's own code: all are green."""
        return lab.json(*merge, db)

    merged("whole.db")
    whole = rows_of(os.path.join(folder, "whole.db"))
    expect(len(whole["nights"]) == 1 and len(whole["night_results"]) == 6 and len(whole["baselines"]) == 1, "a night and a baseline")
    expect(len(whole["runs"]) == RUNS + 9 and len(whole["fits"]) == RUNS - 1 + 1 + 3, (len(whole["runs"]), len(whole["fits"])))
    begun = time.monotonic()
    merged("timed.db")
    whole_s = time.monotonic() - begun
    expect(not difference(whole, rows_of(os.path.join(folder, "timed.db"))), "two merges give one store")

    hit = partly = i = 0
    # A busy machine takes another time for each merge: until kills came in time, and between two runs, too.
    while i < kills or (i < 10 * kills and (hit < kills // 2 or partly == 0)):
        db = os.path.join(folder, f"killed-{i}.db")
        for _ in range(1 + i % 3):  # also more than once in the same store
            merging = lab.start(*merge, db)
            time.sleep(moments.uniform(0.0, whole_s))
            under_way = merging.poll() is None
            merging.kill()
            merging.wait()
            hit += under_way
            there = 0
            if os.path.exists(db) and os.path.getsize(db) > 0:
                checked = lab.run("verify", "--db", db, code=None)
                if "TB-STORE-OPEN" in checked.stderr:  # before its first run
                    lab.run("db", "migrate", "--db", db)
                    checked = lab.run("verify", "--db", db, code=None)
                expect(checked.returncode == 0 and "sound" in checked.stdout, ("what a killed merge leaves", checked))
                there = len(lab.json("runs", "list", "--all", "--db", db)["runs"])
                partly += 0 < there < len(whole["runs"])
            if not under_way or there == 0:
                whole_s *= 1.1 if under_way else 0.9
        merged(db)
        expect(not difference(whole, rows_of(db)), (i, "table, rows, rows of the killed:", difference(whole, rows_of(db))))
        expect("sound" in lab.run("verify", "--db", db), "the store is sound")
        again = merged(db)
        expect((again["runs"], again["fits"], again["baselines"]) == (0, 0, 0) and again["nights"][0]["there"], again)
        expect(not difference(whole, rows_of(db)), "merging once more changes nothing")
        i += 1
    for part in PARTS:
        expect("sound" in lab.run("verify", "--db", part), "the parts are as they were")
    expect(hit >= kills // 2 and partly > 0, f"only {hit} kills came while a merge was under way, {partly} between two runs")
print(f"{hit} kills of a merge ({partly} of them between two runs): the same store as without, nothing doubled")
