"""fleet fit: which sensors it fits and why, and that the child of a fit is what the bench itself would make.

    fit.py PROGRAM
"""

import os
import sqlite3
import sys
import tempfile

from server import Program, expect, make_store, recipe, server_for, skip_unless_possible

skip_unless_possible()
path = sys.argv[1]

with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as folder, server_for("fit") as server:
    lab = Program(path, folder)
    make_store(lab, 1)
    with open(os.path.join(folder, "walk.toml"), "w") as file:
        file.write(recipe("walk", [0, 30, 10, 50, 0]))
    lab.run("sensors", "add", "S-2", "--type", "sensor.toml")

    def measure(name, sensor, seed):
        lab.run("run", f"{name}.toml", "--bench", "bench.toml", "--sensor", sensor, "--operator", "t", "--seed", seed,
                "--no-seating", "-q")

    server.new_fleet(lab, "tactile")
    to = server.conninfo()
    measure("loops", "S-2", 5)  # run 2: no model was made of S-2
    measure("walk", "S-1", 6)   # run 3: newer, but not of the recipes that models are made from
    lab.run("fleet", "push", "--to", to)

    def fitted(*more):
        result = lab.json("fleet", "fit", "--to", to, "--origin", "simulated", *more)
        return result, {sensor["sensor"]: sensor for sensor in result["sensors"]}

    result, sensors = fitted()
    expect(result["fitted"] == 0 and result["up_to_date"] == 1 and result["left_out"] == 1, result)
    expect("no model yet" in sensors["S-2"]["why"], sensors)
    expect(lab.json("fleet", "fit", "--to", to)["sensors"] == [], "hardware runs: there are none")

    # --- a newer run of the same recipes
    measure("loops", "S-1", 7)  # run 4
    lab.run("fleet", "push", "--to", to)
    parent = server.sql("SELECT sha256 FROM fleet.fits")[0][0]
    result, sensors = fitted("--dry-run")
    expect(result["fitted"] == 1 and server.sql("SELECT count(*) FROM fleet.fits") == [["1"]], "a dry run fits nothing")
    result, sensors = fitted("--where", "sensor_serial = 'S-2'")
    expect(result["fitted"] == 0, "the condition holds")
    result, sensors = fitted()
    expect(result["fitted"] == 1 and "newer" in sensors["S-1"]["why"], result)
    expect(sensors["S-1"]["parent_sha256"] == parent and 0 < sensors["S-1"]["own_error_psi"] < 10, sensors)
    rows = server.sql("SELECT f.parent_sha256, f.sha256, r.uuid FROM fleet.fits f JOIN fleet.runs r USING (run) ORDER BY fit")
    expect(len(rows) == 2 and rows[1][0] == parent, rows)
    expect(fitted()[0]["fitted"] == 0, "it is up to date now")
    # The bench makes the same of the run: bit for bit. Of the same second it would be the same fit, which is not sent twice.
    lab.run("fit", 4, "--model", "elam")
    with sqlite3.connect(os.path.join(folder, "runs.db")) as store:
        store.execute("UPDATE fits SET created_utc = strftime('%Y-%m-%dT%H:%M:%SZ', created_utc, '+1 minute') WHERE run = 4")
    lab.run("fleet", "push", "--to", to)
    taxels = server.sql("SELECT fit, md5(string_agg(taxel || status || encode(parameters || ascending_v || descending_v, 'hex'), ',' "
                        f"ORDER BY taxel)) FROM fleet.fit_taxels JOIN fleet.fits USING (fit) JOIN fleet.runs USING (run) WHERE uuid = '{rows[1][2]}' "
                        "GROUP BY fit")
    expect(len(taxels) == 2 and taxels[0][1] == taxels[1][1], taxels)
    verified = lab.json("verify", rows[1][2], "--from", to)
    expect(verified["holds"] and len(verified["analysis"]) == 2, verified)
    expect("child of " + parent[:12] in lab.run("fleet", "show", rows[1][2], "--from", to), "show names the parent")

    # --- a model by another version of the program
    lab.run("sensors", "add", "S-3", "--type", "sensor.toml")
    measure("loops", "S-3", 9)  # run 5
    lab.run("fit", 5, "--model", "elam")
    with sqlite3.connect(os.path.join(folder, "runs.db")) as store:
        store.execute("UPDATE fits SET program_version = '0.0.1' WHERE run = 5")
    lab.run("fleet", "push", "--to", to)
    result, sensors = fitted()
    expect(result["fitted"] == 1 and "0.0.1" in sensors["S-3"]["why"] and sensors["S-3"]["parent_sha256"], sensors)
    expect(fitted()[0]["fitted"] == 0, "its child is of this version")

    # --- another model: no parent
    parts = [fitted("--model", "preisach", "--dry-run", "--shard", f"{k}/3") for k in (1, 2, 3)]
    named = [serial for _, sensors in parts for serial in sensors]
    expect(sorted(named) == sorted(fitted("--model", "preisach", "--dry-run")[1]), "each sensor is in one part of three")
    expect([result["shard"] for result, _ in parts] == ["1/3", "2/3", "3/3"], parts)
    for k in (1, 2):
        fitted("--model", "monotone", "--shard", f"{k}/2")
    expect(fitted("--model", "monotone")[0]["fitted"] == 0, "two parts fit all")
    expect("TB-USAGE" in lab.run("fleet", "fit", "--to", to, "--shard", "3/2", code=2), "no such part")

    result, sensors = fitted("--model", "preisach")
    expect(result["fitted"] == 2 and sensors["S-1"]["parent_sha256"] == "", result)
    expect(fitted("--model", "preisach")[0]["fitted"] == 0, "once")
    expect("TB-USAGE" in lab.run("fleet", "fit", "--to", to, "--model", "dynamic", code=2), "the dynamic model is a person's choice")

    # --- a run that was declared void since is not fitted
    lab.run("runs", "void", 4, "--reason", "gauge closed", "--by", "me")
    lab.run("fleet", "push", "--to", to)
    result, sensors = fitted("--dry-run")
    expect(sensors["S-1"]["run"] == 1 or result["up_to_date"] == 1, (result, sensors))
print("the fleet fits what needs it, as the bench does")
