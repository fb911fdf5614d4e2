"""One PostgreSQL for the tests that need none of their own: a fixture of ctest starts it before them and stops it after. It has
a database `fleet_made`, migrated, to make others from. Beside it lies a cluster that never ran, which the tests with a server
of their own copy: making one takes longer than most of what they do.

    common_server.py start PROGRAM FILE     FILE: where the tests find it (TACTBENCH_TEST_SERVER)
    common_server.py stop FILE

It ends by itself when ctest does, however that ends.
"""

import json
import os
import shutil
import signal
import sys
import tempfile
import time

from server import MADE, Program, Server, expect, fast_place, skip_unless_possible


def alive(pid):
    try:
        os.kill(pid, 0)
        return True
    except ProcessLookupError:
        return False


def keep(folder, program, file, ctest):
    """In a process of its own: the server, until the file is gone or ctest is."""
    pristine = os.path.join(folder, "pristine")
    with Server(made_in=pristine) as server, tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as work:
        server.new_database(MADE)
        Program(program, work).run("fleet", "migrate", "--to", server.conninfo(MADE))
        with open(file + ".new", "w") as out:
            json.dump({"port": server.port, "pristine": pristine, "folder": folder}, out)
        os.rename(file + ".new", file)
        while os.path.exists(file) and alive(ctest) and server.process.poll() is None:
            time.sleep(0.05)


def start(program, file):
    skip_unless_possible()
    stop(file)
    ctest = os.getppid()
    if os.fork() == 0:
        os.setsid()
        log = os.open(file + ".log", os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        for stream, target in ((0, os.open(os.devnull, os.O_RDONLY)), (1, log), (2, log)):
            os.dup2(target, stream)
        os.closerange(3, 256)
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
        folder = tempfile.mkdtemp(prefix="tactbench-postgres-", dir=fast_place())
        try:
            keep(folder, os.path.abspath(program), file, ctest)
        finally:
            if os.path.exists(file):
                os.unlink(file)
            shutil.rmtree(folder, ignore_errors=True)
        sys.exit(0)
    end = time.monotonic() + 60
    while not os.path.exists(file):
        if time.monotonic() > end:
            sys.exit("the common server does not start:\n" + open(file + ".log").read())
        time.sleep(0.02)


def stop(file):
    if not os.path.exists(file):
        return
    with open(file) as known:
        folder = json.load(known)["folder"]
    os.unlink(file)
    end = time.monotonic() + 30
    while os.path.exists(folder):
        expect(time.monotonic() < end, "the common server does not end")
        time.sleep(0.02)


if sys.argv[1] == "start":
    start(*sys.argv[2:])
else:
    stop(*sys.argv[2:])
