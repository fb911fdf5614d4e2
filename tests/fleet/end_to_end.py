"""A laboratory's first hour with a fleet: made by its owner, filled by a bench, read by an analyst, verified and copied home.

    end_to_end.py PROGRAM
"""

import os
import sqlite3
import sys
import tempfile

from server import Program, content_of, expect, make_store, server_for, skip_unless_possible

skip_unless_possible()
path = sys.argv[1]

with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as folder, server_for("first_hour") as server:
    lab = Program(path, folder)
    server.new_database("tactile")
    owner = server.conninfo()

    # --- the owner makes it, twice without harm
    expect("TB-FLEET-EMPTY" in lab.run("fleet", "status", "--to", owner, "--db", make_store(lab, 3), code=5), "no fleet yet")
    made = [lab.json("fleet", "migrate", "--to", owner)["schema_before"] for _ in range(2)]
    expect(made[0] == 0 and made[1] > 0, made)
    server.new_role("bench_a", "LOGIN IN ROLE tactbench_bench")
    server.new_role("ana", "LOGIN IN ROLE tactbench_analyst")
    bench, analyst = server.conninfo(user="bench_a"), server.conninfo(user="ana")

    # --- a bench pushes; again, nothing is sent
    status = lab.json("fleet", "status", "--to", bench)
    expect(status["waiting_runs"] == 3 and status["waiting_frames"] > 0, status)
    first = lab.json("fleet", "push", "--to", bench)
    expect(len(first["pushed"]) == 3 and first["frames"] == status["waiting_frames"] and first["pushed"][0]["fits"] == 1, first)
    again = lab.json("fleet", "push", "--to", bench)
    expect(again["pushed"] == [] and again["ended_runs"] == 3 and again["not_pushed"] == 0, again)
    local = {run["uuid"]: run for run in lab.json("runs", "list")["runs"]}
    expect(content_of(server, "tactile") == {uuid: run["content_sha256"] for uuid, run in local.items()}, "the same content")

    # --- what is said later follows, as a further row; the fleet's number stays
    lab.run("runs", "tag", 2, "good")
    lab.run("runs", "note", 2, "the door was open")
    lab.run("fit", 1)
    lab.run("judge", 1, 2, "--limits", "limits.toml", code=None)
    lab.run("runs", "void", 3, "--reason", "gauge closed", "--by", "me")
    expect(lab.json("fleet", "status", "--to", bench)["waiting_remarks"] == 3, "three runs have something newer")
    later = lab.json("fleet", "push", "--to", bench)
    expect(later["frames"] == 0 and [p["fleet_run"] for p in later["pushed"]] == [p["fleet_run"] for p in first["pushed"]], later)
    rows = server.sql("SELECT tags, notes, void, (SELECT count(*) FROM fleet.simulated_verdicts v WHERE v.run = r.run) "
                      "FROM fleet.simulated_runs r ORDER BY run")
    expect(len(rows) == 3 and rows[1][0] == "good" and rows[1][1].endswith("the door was open") and int(rows[1][3]) > 0, rows)
    expect(rows[2][2] == "t", rows)
    # A tag that is taken away again: the state of before is said once more. An old copy of the store takes nothing back.
    with sqlite3.connect(f"{folder}/runs.db") as source, sqlite3.connect(f"{folder}/old.db") as old:
        source.backup(old)
    lab.run("runs", "tag", 2, "good", "--remove")
    lab.run("runs", "tag", 1, "second")
    expect(len(lab.json("fleet", "push", "--to", bench)["pushed"]) == 2, "two runs have changed")
    expect(lab.json("fleet", "push", "--to", bench, "--db", "old.db")["pushed"] == [], "the old copy has nothing new")
    expect(server.sql("SELECT tags FROM fleet.every_run ORDER BY run")[:2] == [["first second"], [""]], "as the store has it")

    # --- the analyst reads the same as the bench does of its own store
    listed = {run["uuid"]: run for run in lab.json("fleet", "runs", "--from", analyst, "--origin", "simulated", "--all")["runs"]}
    own = {run["uuid"]: run for run in lab.json("runs", "list", "--all")["runs"]}
    for uuid, run in own.items():
        expect({**listed[uuid], "run": 0} == {**run, "run": 0}, (run, listed[uuid]))
    expect(lab.json("fleet", "runs", "--from", analyst)["runs"] == [], "hardware and simulated runs do not mix")
    numbers = {uuid: listed[uuid]["run"] for uuid in listed}
    uuid_of = {run["run"]: uuid for uuid, run in own.items()}
    shown, mine = lab.json("fleet", "show", uuid_of[2][:8], "--from", analyst), lab.json("runs", "show", 2)
    for key in ("run", "verdict", "verdicts"):  # its models' run is not read with it
        shown.pop(key), mine.pop(key)
    expect(shown == mine, "all that is stored about a run")
    expect("bench_a" in lab.run("fleet", "show", uuid_of[2], "--from", analyst), "who pushed it")
    for condition, uuids in (("tags LIKE '%first%'", [uuid_of[1]]), ("facts->'tags' ? 'none'", [])):
        found = lab.json("fleet", "runs", "--from", analyst, "--origin", "simulated", "--where", condition)
        expect([run["uuid"] for run in found["runs"]] == uuids, (condition, found))
    filtered = lab.json("fleet", "runs", "--from", analyst, "--origin", "simulated", "--sensor", "S-2")
    expect(filtered["runs"] == [], filtered)
    figures = lambda trend: [[f["name"], f["values"]] for s in trend["subjects"] for f in s["figures"]]
    expect(figures(lab.json("fleet", "trend", "--from", analyst, "--origin", "simulated")) == figures(lab.json("trend")),
           "the same figures over time")

    # --- verified from the raw frames that the fleet holds, and copied home again
    for run in (1, 2):
        verified = lab.json("verify", uuid_of[run], "--from", analyst)
        expect(verified["holds"] and verified["content"]["computed_sha256"] == own[uuid_of[run]]["content_sha256"], verified)
        expect(verified["run"] == numbers[uuid_of[run]] and len(verified["analysis"]) > 0, verified)
        expect(all(result["recomputed"] for result in verified["analysis"]), verified)
    lab.run("runs", "copy", uuid_of[1], numbers[uuid_of[2]], "--from", analyst, "--to", "home.db")
    lab.run("verify", "--db", "home.db")
    expect(lab.json("verify", 2, "--db", "home.db")["analysis"] != [], "with its verdicts")
    lab.run("verify", uuid_of[1], "--from", "fleet", env={"TACTBENCH_FLEET": analyst})
    for code, name, words in ((2, "TB-USAGE", ("verify", uuid_of[1], "--from", "fleet")),
                              (2, "TB-FLEET-NOT-FOUND", ("fleet", "show", "99999", "--from", analyst)),
                              (2, "TB-FLEET-NOT-FOUND", ("fleet", "show", "x' OR '1'='1", "--from", analyst)),
                              (2, "TB-FLEET-WHERE", ("fleet", "runs", "--from", analyst, "--where", "no_such = 1")),
                              (2, "TB-FLEET-WHERE", ("fleet", "runs", "--from", analyst, "--where", "true); SELECT 1; --"))):
        expect(name in lab.run(*words, code=code), words)

    # --- the same store from another place, and pushes at the same time: one number a run
    lab.run("runs", "tag", 1, "third")
    with sqlite3.connect(f"{folder}/runs.db") as source, sqlite3.connect(f"{folder}/moved.db") as moved:
        source.backup(moved)
    before = int(server.sql("SELECT count(*) FROM fleet.runs")[0][0])
    both = [lab.start("fleet", "push", "--to", bench, "--db", name) for name in ("moved.db", "moved.db", "runs.db")]
    expect([one.wait(timeout=120) for one in both] == [0, 0, 0], [one.stdout.read() for one in both])
    expect(server.sql("SELECT count(*), count(DISTINCT run) FROM fleet.runs") == [[str(before + 1), "3"]], "one more row")

    # --- the demonstration: models with lag and creep, held-out runs
    lab.run("demo", "--db", "demo.db", "-o", "demo.html", code=None)
    lab.run("fleet", "push", "--to", bench, "--db", "demo.db")
    for run in lab.json("runs", "list", "--db", "demo.db")["runs"]:
        there, here = lab.json("verify", run["uuid"], "--from", analyst), lab.json("verify", run["run"], "--db", "demo.db")
        expect(there["holds"] and [r["recomputed"] for r in there["analysis"]] == [r["recomputed"] for r in here["analysis"]],
               (there, here))
print("a fleet was made, filled, read, verified and copied")
