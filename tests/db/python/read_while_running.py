"""Readers query in a loop, and one holds a transaction open, while a run is written: no error on either side, and no
frame waits for them as long as a dwell (2 s)."""

import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time

program = sys.argv[1]
folder = tempfile.mkdtemp()
for name in ("TACTBENCH_BENCH", "TACTBENCH_DB"):
    os.environ.pop(name, None)  # the developer's
os.environ["TACTBENCH_RUNTIME_DIR"] = folder  # commands to other runs of this machine do not reach it
store = os.path.join(folder, "runs.db")
faults = []
ended = threading.Event()


def call(*words):
    subprocess.run([program, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)


def hold_snapshots():
    """What a forgotten notebook does: a read transaction that stays open for a while."""
    try:
        connection = sqlite3.connect(f"file:{store}?mode=ro", uri=True, isolation_level=None)
        while not ended.is_set():
            connection.execute("BEGIN")
            before = connection.execute("SELECT count(*) FROM frames").fetchone()
            time.sleep(0.1)
            assert connection.execute("SELECT count(*) FROM frames").fetchone() == before
            connection.execute("COMMIT")
        connection.close()
    except Exception as error:  # reported below: a thread's own exception is not
        faults.append(repr(error))


try:
    call("init")
    call("sensors", "add", "S-1", "--type", "sensor.toml")
    holder = threading.Thread(target=hold_snapshots)
    holder.start()
    run = subprocess.Popen(
        [program, "run", "descending", "ascending", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "test",
         "-q"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    reader = sqlite3.connect(f"file:{store}?mode=ro", uri=True)
    seen, grew_at, longest, growths = 0, None, 0.0, 0
    while run.poll() is None:
        (count,) = reader.execute("SELECT count(*) FROM v_frames").fetchone()
        newest = reader.execute("SELECT length(counts), scans FROM frames ORDER BY frame DESC LIMIT 1").fetchone()
        assert newest is None or newest[0] == 2 * 256 * newest[1], newest
        assert count >= seen
        now = time.monotonic()
        if count > seen:
            if grew_at is not None:
                longest = max(longest, now - grew_at)
            seen, grew_at, growths = count, now, growths + 1
    output, errors = run.communicate()
    ended.set()
    holder.join()
    assert run.returncode == 0, (run.returncode, errors)
    assert not faults, faults
    assert growths >= 10, growths  # it did look while frames came in
    assert longest < 10.0, longest  # 0.02 s on a quiet machine, 5.7 s on a very busy one
    (outcome, frames) = reader.execute("SELECT outcome, frames FROM v_runs").fetchone()
    assert (outcome, frames >= seen) == ("completed", True), (outcome, frames, seen)
    call("verify", "1")
    print(f"{frames} frames, {growths} polls that found new ones, longest wait {longest:.3f} s")
finally:
    ended.set()
    shutil.rmtree(folder)
