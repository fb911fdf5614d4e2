"""A run as Parquet by a line of docs/store.md, read back beside the store.

    parquet_test.py PROGRAM pandas|duckdb

Neither engine is in Debian 12 (PyPI: pandas with pyarrow; the module or the command duckdb). Ends with 77 where it is not there.
"""

import csv
import os
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile

PROGRAM, ENGINE = os.path.abspath(sys.argv[1]), sys.argv[2]
DOCUMENT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs", "store.md")
try:
    if ENGINE == "pandas":
        import pandas
        import pandas.io.parquet
        pandas.io.parquet.get_engine("auto")  # pyarrow or fastparquet
    elif not shutil.which("duckdb"):
        import duckdb
except ImportError as error:
    print(f"SKIPPED: {str(error).splitlines()[0]}")
    sys.exit(77)


def call(*words):
    done = subprocess.run([PROGRAM, *words], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, (words, done.stdout, done.stderr)


def duck(sql):
    """By the command, or by the module: the same engine."""
    if shutil.which("duckdb"):
        subprocess.run(["duckdb", "-c", sql], check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, timeout=900)
    else:
        duckdb.sql(sql)


def write_parquet(line):
    """Carries out the document's line."""
    if ENGINE == "pandas":
        exec(line, {"pandas": pandas})
    else:
        duck(re.fullmatch(r'duckdb -c "(.*)"', line).group(1))


def columns_of(file):
    """Column -> its numbers; what was not measured is None."""
    if ENGINE == "pandas":
        table = pandas.read_parquet(file)
        return {name: [None if value != value else value for value in table[name].tolist()] for name in table.columns}
    duck(f"COPY (FROM '{file}') TO 'back.csv'")
    with open("back.csv", newline="") as back:
        names, *rows = csv.reader(back)
    texts = ("sequence", "recipe", "status", "flags")
    return {name: [float(value) if value else None for value in column]
            for name, column in zip(names, zip(*rows)) if name not in texts}


with open(DOCUMENT) as text:
    lines = [line.strip() for line in text if ".parquet'" in line or '.parquet")' in line]
line = next(line for line in lines if line.startswith(ENGINE))
with tempfile.TemporaryDirectory() as folder:
    for name in ("TACTBENCH_BENCH", "TACTBENCH_DB"):
        os.environ.pop(name, None)
    os.environ["TACTBENCH_RUNTIME_DIR"] = folder
    os.chdir(folder)
    call("init")
    call("sensors", "add", "S-1", "--type", "sensor.toml")
    call("run", "ring", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "Zoë", "-q", "--yes")
    call("runs", "export", "1", "-o", "run.csv")
    write_parquet(line)
    found = columns_of("run.parquet")
    store = sqlite3.connect("runs.db")
    store.row_factory = sqlite3.Row
    frames = store.execute('SELECT * FROM v_frames ORDER BY position').fetchall()
    # A line of the CSV is a scan of a frame.
    scans = [(frame, scan) for frame in frames for scan in range(frame["scans"])]
    assert len(scans) > 20 and len(found["reference_psi"]) == len(scans), (len(scans), len(found["reference_psi"]))
    for name, column in (("frame", "position"), *((name, name) for name in ("reference_psi", "setpoint_psi", "fz_n", "z_mm"))):
        assert found[name] == [frame[column] for frame, _ in scans], (name, found[name][:3])
    taxels, columns = frames[0]["rows"] * frames[0]["columns"], frames[0]["columns"]
    for taxel in (0, 3 * columns + 4, taxels - 1):
        own = [int.from_bytes(frame["counts"][at:at + 2], "little")
               for frame, scan in scans for at in [2 * (scan * taxels + taxel)]]
        place = f"r{taxel // columns}_c{taxel % columns}"
        assert found[f"counts_{place}"] == own, place
        volts = found[f"volts_{place}"]
        assert all(abs(v - c * frames[0]["volts_per_count"]) < 1e-6 for v, c in zip(volts, own)), place
print(f"{len(scans)} scans in Parquet by the document's line are what the store holds: {line}")
