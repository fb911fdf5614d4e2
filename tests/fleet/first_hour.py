"""A laboratory's first hour with a fleet: made by its owner, filled by a bench, read by an analyst, who may not write.

    first_hour.py PROGRAM
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
    expect("TB-FLEET-EMPTY" in lab.run("fleet", "status", "--to", owner, "--db", make_store(lab, 3), code=5),
           "an empty database is named so")
    expect("made a fleet" in lab.run("fleet", "migrate", "--to", owner), "the fleet is made")
    expect("already" in lab.run("fleet", "migrate", "--to", owner), "and made once")
    server.new_role("bench_a", "LOGIN IN ROLE tactbench_bench")
    server.new_role("ana", "LOGIN IN ROLE tactbench_analyst")
    bench, analyst = server.conninfo(user="bench_a"), server.conninfo(user="ana")

    # --- a bench pushes; again, nothing is sent
    status = lab.json("fleet", "status", "--to", bench)
    expect(status["waiting_runs"] == 3 and status["reached"], status)
    first = lab.json("fleet", "push", "--to", bench)
    expect(len(first["pushed"]) == 3 and first["frames"] > 0 and first["pushed"][0]["fits"] == 1, first)
    again = lab.json("fleet", "push", "--to", bench)
    expect(again["pushed"] == [] and again["ended_runs"] == 3, again)
    local = {run["uuid"]: run for run in lab.json("runs", "list")["runs"]}
    expect(content_of(server, "tactile") == {uuid: run["content_sha256"] for uuid, run in local.items()},
           "the same runs with the same content")
    frames = int(server.sql("SELECT count(*) FROM fleet.frames")[0][0])
    expect(frames == first["frames"] == sum(run["frames"] for run in local.values()), "no frame lost, none doubled")
    months = server.sql("SELECT relname FROM pg_class WHERE relname LIKE 'frames\\_2%' AND relkind = 'r'")
    expect(len(months) >= 1, months)

    # --- what is said later follows, as a further revision; nothing of the content is sent again
    lab.run("runs", "tag", 2, "good")
    lab.run("runs", "note", 2, "the door was open")
    lab.run("fit", 1, "--held-out", 2, "--limits", "limits.toml", code=None)
    lab.run("runs", "void", 3, "--reason", "gauge closed", "--by", "me")
    expect(lab.json("fleet", "status", "--to", bench)["waiting_remarks"] == 3, "three runs have something newer")
    later = lab.json("fleet", "push", "--to", bench)
    expect(later["frames"] == 0 and len(later["pushed"]) == 3, later)
    expect(int(server.sql("SELECT count(*) FROM fleet.frames")[0][0]) == frames, "frames are as they were")
    row = server.sql("SELECT tags, notes, void, (SELECT count(*) FROM fleet.verdicts v WHERE v.revision = r.revision) "
                     "FROM fleet.simulated_runs r ORDER BY started_utc, run")
    expect(row[1][0] == "good" and row[1][1].endswith("the door was open") and int(row[1][3]) > 0, row)
    expect(row[2][2] == "t", row)
    # A tag that is taken away again: the state of before is said once more.
    lab.run("runs", "tag", 2, "good", "--remove")
    lab.run("fleet", "push", "--to", bench)
    expect(server.sql("SELECT tags FROM fleet.simulated_runs ORDER BY started_utc, run")[1] == [""], "the tag is gone")

    # --- the analyst reads the same as the bench does of its own store
    listed = {run["uuid"]: run for run in lab.json("fleet", "runs", "--from", analyst, "--origin", "simulated", "--all")["runs"]}
    own = {run["uuid"]: run for run in lab.json("runs", "list", "--all")["runs"]}
    for uuid, run in own.items():
        theirs = dict(listed[uuid])
        expect({**theirs, "run": 0} == {**run, "run": 0}, (run, theirs))
    expect(lab.json("fleet", "runs", "--from", analyst)["runs"] == [], "hardware and simulated runs do not mix")
    expect("simulated left out" in lab.run("fleet", "runs", "--from", analyst), "and it says so")
    numbers = {uuid: listed[uuid]["run"] for uuid in listed}
    uuid_1 = next(uuid for uuid, run in own.items() if run["run"] == 1)
    uuid_2 = next(uuid for uuid, run in own.items() if run["run"] == 2)
    shown, mine = lab.json("fleet", "show", uuid_2[:8], "--from", analyst), lab.json("runs", "show", 2)
    for key in ("run", "verdicts"):
        shown.pop(key), mine.pop(key)
    expect(shown == mine, "all that is stored about a run")
    expect("pushed by bench_a" in lab.run("fleet", "show", uuid_2, "--from", analyst), "who pushed it")
    by_condition = lab.json("fleet", "runs", "--from", analyst, "--origin", "simulated", "--where", "tags LIKE '%first%'")
    expect([run["uuid"] for run in by_condition["runs"]] == [uuid_1], by_condition)
    trends, my_trends = lab.json("fleet", "trend", "--from", analyst, "--origin", "simulated"), lab.json("trend")
    expect([[f["name"], f["values"]] for s in trends["subjects"] for f in s["figures"]] ==
           [[f["name"], f["values"]] for s in my_trends["subjects"] for f in s["figures"]], "the same figures over time")

    # --- verified from the raw frames that the fleet holds, and copied home again
    for uuid in (uuid_1, uuid_2):
        verified = lab.json("verify", uuid, "--from", analyst)
        expect(verified["holds"] and verified["content"]["computed_sha256"] == own[uuid]["content_sha256"], verified)
        for result in verified["analysis"]:
            expect(result["recomputed"] and "bit for bit" in result["compared"] or "modified" in result["compared"], result)
    expect(len(lab.json("verify", uuid_2, "--from", analyst)["analysis"]) > 0, "verdicts are recomputed, too")
    lab.run("runs", "copy", uuid_1, numbers[uuid_2], "--from", analyst, "--to", "home.db")
    expect(lab.run("db", "check", "home.db").count("2 runs as they were stored") == 1, "the copy is sound")
    home = {run["uuid"]: run for run in lab.json("runs", "list", "--db", "home.db")["runs"]}
    expect(home[uuid_1]["content_sha256"] == own[uuid_1]["content_sha256"], "the copy is the run")
    lab.run("verify", 1, "--db", "home.db")
    # From the environment, as on a bench.
    lab.run("verify", uuid_1, "--from", "fleet", env={"TACTBENCH_FLEET": analyst})
    expect("TB-USAGE" in lab.run("verify", uuid_1, "--from", "fleet", code=2), "no fleet is named")
    expect("TB-FLEET-NOT-FOUND" in lab.run("fleet", "show", "99999", "--from", analyst, code=2), "a run that is not there")
    expect("TB-FLEET-WHERE" in lab.run("fleet", "runs", "--from", analyst, "--where", "no_such = 1", code=2), "a wrong condition")
    expect("TB-FLEET-WHERE" in lab.run("fleet", "runs", "--from", analyst, "--where", "true); DELETE FROM fleet.runs; --", code=2),
           "a condition is no second command")

    # --- the same store from another place, and a second push at the same time: one row a run
    with sqlite3.connect(os.path.join(folder, "runs.db")) as source, sqlite3.connect(os.path.join(folder, "moved.db")) as moved:
        source.backup(moved)
    both = [lab.start("fleet", "push", "--to", bench, "--db", name) for name in ("moved.db", "moved.db", "runs.db")]
    expect([one.wait(timeout=120) for one in both] == [0, 0, 0], [one.stdout.read() for one in both])
    expect(server.sql("SELECT count(*), count(DISTINCT uuid) FROM fleet.runs") == [["3", "3"]], "one row a run")

    # --- who may what
    for text in ("UPDATE fleet.runs SET purpose = 'x'", "DELETE FROM fleet.frames", "TRUNCATE fleet.runs CASCADE",
                 "INSERT INTO fleet.about VALUES ('x')", "DROP TABLE fleet.frames"):
        for user in ("bench_a", "ana"):
            said = server.try_sql(text, user=user)
            expect("denied" in said or "must be owner" in said, (user, text, said))
    for text in ("UPDATE fleet.runs SET purpose = 'x'", "DELETE FROM fleet.frames", "TRUNCATE fleet.revisions CASCADE",
                 "DELETE FROM fleet.fits", "UPDATE fleet.revisions SET tags = 'x'"):
        expect("nobody changes or deletes" in server.try_sql(text), "not even the owner: " + text)
    expect("TB-FLEET-DENIED" in lab.run("fleet", "push", "--to", analyst, "--db", "home.db", code=None).stderr or
           lab.json("fleet", "push", "--to", analyst, "--db", "home.db")["pushed"] == [], "an analyst adds nothing")
    server.new_role("nobody_of_ours")
    expect("TB-FLEET-DENIED" in lab.run("fleet", "runs", "--from", server.conninfo(user="nobody_of_ours"), code=5), "a stranger")

    # --- a change behind the program's back is found
    server.sql("SET session_replication_role = replica; UPDATE fleet.frames SET counts = set_byte(counts, 3, get_byte(counts, 3) # 1) "
               f"WHERE run = {numbers[uuid_1]} AND position = 2")
    broken = lab.json("verify", uuid_1, "--from", analyst, code=5)
    expect("frame 2 " in broken["first_difference"], broken)
    server.sql(f"SET session_replication_role = replica; UPDATE fleet.fits SET summary_json = '{{}}' WHERE run = {numbers[uuid_1]}")
    expect("TB-FLEET-CHANGED" in lab.run("verify", uuid_1, "--from", analyst, code=5), "a changed fit")
print("a fleet was made, filled, read, verified and copied")
