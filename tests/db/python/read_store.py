"""Reads a store with Python's sqlite3 through the views, decodes a frame, and compares with `runs export`."""

import array
import csv
import json
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile

program = sys.argv[1]
folder = tempfile.mkdtemp()
for name in ("TACTBENCH_BENCH", "TACTBENCH_DB"):
    os.environ.pop(name, None)  # the developer's
os.environ["TACTBENCH_RUNTIME_DIR"] = folder  # commands to other runs of this machine do not reach it


def call(*words, codes=(0,)):
    done = subprocess.run([program, *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    assert done.returncode in codes, (words, done.returncode, done.stderr)


def rows(sql, *values):
    cursor = store.execute(sql, values)
    names = [column[0] for column in cursor.description]
    return [dict(zip(names, row)) for row in cursor]


try:
    call("init")
    call("sensors", "add", "S-1", "--type", "sensor.toml")
    with open(os.path.join(folder, "small.toml"), "w") as file:
        file.write('schema = 1\nname = "small"\nunit = "psi"\nturning_points = [0, 60, 20, 60, 0]\nstep = 20\n')
    call("run", "./small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "test", "--no-seating")
    call("run", "./small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "test", "--no-seating")
    call("fit", "1", "--model", "elam")
    call("judge", "1", "2", "--limits", "limits.toml", codes=(0, 1, 6))
    call("runs", "tag", "1", "from-python")
    call("runs", "export", "1", "-o", "run.csv")
    call("runs", "export", "1", "--format", "json", "-o", "run.json")
    store = sqlite3.connect(f"file:{folder}/runs.db?mode=ro", uri=True)

    (run,) = rows("SELECT * FROM v_runs WHERE run = 1")
    assert (run["frames"], run["tags"], run["void"]) == (11, "from-python", 0), run
    frames = rows("SELECT * FROM v_frames WHERE run = 1 ORDER BY position")
    assert [frame["setpoint_psi"] for frame in frames] == [0, 20, 40, 60, 40, 20, 40, 60, 40, 20, 0], frames
    assert all(abs(frame["reference_psi"] - frame["setpoint_psi"]) < 0.5 for frame in frames)
    assert all(frame["time_s"] == frame["time_ns"] * 1e-9 for frame in frames)
    assert {"run", "time_s", "kind", "id", "detail"} == set(rows("SELECT * FROM v_events")[0])
    assert len(rows("SELECT * FROM v_fit_taxels WHERE status = 'fitted'")) == 257
    assert "psi" in {row["unit"] for row in rows("SELECT * FROM v_verdicts")}
    assert len(rows("SELECT * FROM v_devices WHERE role = 'tactile scanner'")) == 2
    for view in ("v_runs", "v_frames", "v_verdicts", "v_events", "v_checks", "v_devices", "v_fit_taxels"):
        try:
            store.execute(f"DELETE FROM {view}")
        except sqlite3.Error:
            continue
        raise AssertionError(f"{view} takes a DELETE")

    # The view has the counts as well, and the value of one.
    assert all(frame["counts"] == blob[0] for frame, blob in zip(frames, store.execute("SELECT counts FROM frames WHERE frame < 2000000000 ORDER BY frame")))
    assert 0 < frames[0]["volts_per_count"] < 1e-3 and frames[0]["fz_n"] is None

    # A frame in one line.
    blobs = store.execute('SELECT counts, scans, "rows", columns FROM frames WHERE frame < 2000000000 ORDER BY frame').fetchall()
    decoded = [list(array.array("H", counts)) for counts, *_ in blobs]
    assert all(len(counts) == s * r * c for counts, (_, s, r, c) in zip(decoded, blobs))

    with open(os.path.join(folder, "run.csv"), newline="") as file:
        text = file.readlines()
    about = dict(line[2:].strip().split(": ", 1) for line in text if line.startswith("# "))
    assert about["tactbench"] == "frames of run 1" and about["origin"] == "simulated" and about["recipes"] == "small", about
    lines = list(csv.DictReader(line for line in text if not line.startswith("#")))
    scans = blobs[0][1]
    assert len(lines) == 11 * scans, len(lines)
    for number, line in enumerate(lines):
        frame, scan = number // scans, number % scans
        assert (int(line["frame"]), int(line["scan"])) == (frame + 1, scan)
        assert float(line["reference_psi"]) == frames[frame]["reference_psi"]
        assert line["recipe"] == "small"
        for r in range(16):
            for c in range(16):
                counts = int(line[f"counts_r{r}_c{c}"])
                assert counts == decoded[frame][(scan * 16 + r) * 16 + c]
                assert abs(float(line[f"volts_r{r}_c{c}"]) - counts * frames[frame]["volts_per_count"]) < 1e-6
        assert line["time_s"] == f"{frames[frame]['time_ns'] / 1e9:.9f}".rstrip("0").rstrip(".")

    with open(os.path.join(folder, "run.json")) as file:
        document = json.load(file)
    assert document["content_sha256"] == run["content_sha256"]
    # The view has the columns' names, the document those that every document has.
    for key, column in {"sensor": "sensor_serial", "bench": "bench_id", "git_commit": "git_commit"}.items():
        assert document[key] == run[column], key
    assert (document["void"], document["tags"], document["version"]) == (False, ["from-python"], 2)
    assert all(len(recipe["sha256"]) == 64 for recipe in document["recipes"])
    assert [frame["counts"] for frame in document["frames"]] == decoded
    assert [frame["reference_psi"] for frame in document["frames"]] == [f["reference_psi"] for f in frames]
    assert document["events"] and document["recipes"][0]["toml"].startswith("schema")
finally:
    shutil.rmtree(folder)
