"""SIGKILL of the push, and of the server, at random moments; then a push again: nothing is lost, nothing doubled, and what the
fleet holds verifies.

    kills.py PROGRAM KILLS_OF_THE_PUSH KILLS_OF_THE_SERVER SEED
"""

import random
import sys
import tempfile
import time

from server import Program, Server, comes_true, content_of, expect, make_store, skip_unless_possible

skip_unless_possible()
path, pushes, servers, seed = sys.argv[1], *map(int, sys.argv[2:])
moments = random.Random(seed)
RUNS = 4


def check(server, database, own):
    """Whole runs only, each once."""
    # The server may still carry out what a killed push had sent.
    others = "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND pid <> pg_backend_pid()"
    comes_true(lambda: server.sql(others, database) == [["0"]], "the end of the killed push's session")
    theirs = content_of(server, database)
    expect(all(own.get(uuid) == content for uuid, content in theirs.items()), "a run that is there is the bench's")
    rows = server.sql("SELECT count(*), count(DISTINCT uuid), count(*) FILTER (WHERE body_sha256 = encode(sha256(body), 'hex')) "
                      "FROM fleet.runs", database)[0]
    expect(rows == [str(len(theirs))] * 3, ("each run once and whole", rows))
    return len(theirs)


with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as folder, Server() as server:
    lab = Program(path, folder)
    make_store(lab, RUNS)
    own = {run["uuid"]: run["content_sha256"] for run in lab.json("runs", "list")["runs"]}
    server.new_database("empty")
    lab.run("fleet", "migrate", "--to", server.conninfo("empty"))
    server.new_database("timed", "empty")
    begun = time.monotonic()
    lab.run("fleet", "push", "--to", server.conninfo("timed"))
    whole_s = time.monotonic() - begun
    partly = hit = i = 0
    kills = pushes + servers
    # A busy machine takes another time for each push: until kills came in time.
    while i < kills or (i < 5 * kills and hit < kills // 3):
        database = f"fleet_{i}"
        server.new_database(database, "empty")
        to = server.conninfo(database)
        pushing = lab.start("fleet", "push", "--to", to)
        time.sleep(moments.uniform(0.0, 1.1 * whole_s))
        if pushes <= i < kills:
            server.kill()
            code = pushing.wait(timeout=120)
            expect(code in (0, 3), (code, pushing.stdout.read()))
            hit += code == 3
            lab.run("fleet", "status", "--to", to, code=3)
            server.start()
        else:
            hit += pushing.poll() is None
            pushing.kill()
            pushing.wait()
        partly += 0 < check(server, database, own) < RUNS
        lab.run("fleet", "push", "--to", to)
        expect(check(server, database, own) == RUNS, "all are there after the next push")
        expect(lab.json("fleet", "push", "--to", to)["pushed"] == [], "and nothing is sent once more")
        expect(lab.json("fleet", "status", "--to", to)["waiting_runs"] == 0, "nothing waits")
        i += 1
    for uuid in own:
        expect(lab.json("verify", uuid, "--from", server.conninfo(f"fleet_{i - 1}"))["holds"], uuid)
    expect(hit >= kills // 3, f"only {hit} kills came while a push was under way")
    lab.run("verify")
print(f"{i - servers} kills of the push and {servers} of the server ({hit} of them in mid-push, {partly} between two runs): "
      "nothing lost, nothing doubled, hashes equal")
