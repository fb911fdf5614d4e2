"""A server that does not answer, or has no TLS, falls silent, cannot keep a text, or holds something else than was sent; and runs of one serial with two
registrations. What the bench is told, by which exit code, and that nothing is lost, doubled or kept by half.

    server_errors.py PROGRAM
"""

import os
import shutil
import signal
import socket
import sqlite3
import sys
import tempfile
import time

from libpq import Session
from server import LONGEST_S, Program, comes_true, content_of, expect, make_store, server_for, skip_unless_possible

skip_unless_possible()
path = sys.argv[1]
RUNS = 2


def own_content(lab):
    return {run["uuid"]: run["content_sha256"] for run in lab.json("runs", "list")["runs"]}


def told(done, code, *words):
    expect(done.returncode == code, (code, done.returncode, done.stdout, done.stderr))
    for word in words:
        expect(word in done.stderr, (word, done.stderr))


def all_there(server, database, lab):
    """As many runs and frames as on the bench, each once, with the same content; nothing is sent by a further push."""
    to = server.conninfo(database)
    expect(content_of(server, database) == own_content(lab), "the same runs with the same content")
    frames = sum(run["frames"] for run in lab.json("runs", "list")["runs"])
    expect(server.sql("SELECT (SELECT count(*) FROM fleet.runs), (SELECT count(*) FROM fleet.frames)", database) ==
           [[str(len(own_content(lab))), str(frames)]], "each run and frame once")
    expect(lab.json("fleet", "push", "--to", to)["pushed"] == [], "nothing is sent once more")


def nothing_of(server, database, uuid):
    """No row of a run that could not be sent."""
    expect(server.sql(f"SELECT count(*) FROM fleet.runs WHERE uuid = '{uuid}'", database) == [["0"]], "no half of a run")
    expect(server.sql("SELECT count(*) FROM fleet.frames f WHERE NOT EXISTS (SELECT 1 FROM fleet.runs r WHERE r.run = f.run)",
                      database) == [["0"]], "no frame of no run")


def at_the_door(server, lab):
    """A server without TLS for a bench that asks for it; and one that does not answer, which a bench is told to leave."""
    server.new_fleet(lab, "door")
    told(lab.run("fleet", "push", "--to", server.conninfo("door", sslmode="require"), code=None), 3, "TB-FLEET-TLS", "does not support SSL")
    with socket.create_server(("127.0.0.1", 0)) as door:
        pushing = lab.start("fleet", "push", "--follow", "--to", f"host=127.0.0.1 port={door.getsockname()[1]} dbname=x user=y")
        link, _ = door.accept()
        expect(link.recv(8) != b"", "the bench speaks first")
        time.sleep(0.5)  # it waits for the answer now
        pushing.send_signal(signal.SIGTERM)
        time.sleep(0.5)
    link.close()
    said = pushing.communicate(timeout=30)[0]
    expect(pushing.returncode == 0 and "TB-FLEET-CONNECT" in said, (pushing.returncode, said))


def waiting_backend(server, database):
    rows = server.sql("SELECT pid FROM pg_stat_activity WHERE datname = current_database() AND application_name = 'tactbench' AND "
                      "wait_event_type = 'Lock'", database)
    return int(rows[0][0]) if rows else 0


def silent(server, lab):
    """The server's process that takes the push is stopped in the midst of it. A run goes on meanwhile."""
    server.new_fleet(lab, "silent")
    to = server.conninfo("silent")
    with Session(to) as other:
        other.ask("BEGIN")
        other.ask("LOCK TABLE fleet.frames IN ACCESS EXCLUSIVE MODE")
        pushing = lab.start("fleet", "push", "--to", to, "--patience", "3")
        comes_true(lambda: waiting_backend(server, "silent"), "the push comes to the frames", 30)
        backend = waiting_backend(server, "silent")
        os.kill(backend, signal.SIGSTOP)
        other.ask("ROLLBACK")
    try:
        lab.run("run", "loops.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "--seed", 55, "--no-seating", "-q")
        said = pushing.communicate(timeout=LONGEST_S)[0]
        expect(pushing.returncode == 3, (pushing.returncode, said))
        for word in ("TB-FLEET-SILENT", "has been silent for 3 s", "try: "):
            expect(word in said, (word, said))
    finally:
        os.kill(backend, signal.SIGCONT)
    expect(lab.json("runs", "list")["runs"][0]["outcome"] == "completed", "the run beside it does not notice")
    lab.run("fleet", "push", "--to", to)
    all_there(server, "silent", lab)


def text(server, lab):
    """A note that the database's encoding does not have, and one with a zero byte: that run waits, the others are sent."""
    server.new_database("latin", more="ENCODING 'LATIN1' LOCALE 'C'")
    to = server.conninfo("latin")
    lab.run("fleet", "migrate", "--to", to)
    uuid = next(run["uuid"] for run in lab.json("runs", "list")["runs"] if run["run"] == 1)

    def refused(*words):
        done = lab.run("fleet", "push", "--to", to, code=None)
        told(done, 5, "TB-FLEET-TEXT", "UTF8", *words)
        expect("1 could not be sent" in done.stdout, done.stdout)
        nothing_of(server, "latin", uuid)
        expect(len(content_of(server, "latin")) == len(own_content(lab)) - 1, "the others are there")
        expect(lab.json("fleet", "status", "--to", to)["waiting_runs"] == 1, "it waits")

    def note(words):
        with sqlite3.connect(os.path.join(lab.folder, "runs.db")) as store:
            store.execute("UPDATE runs SET notes = ? WHERE run = 1", (words,))

    note("5 k\u03a9")
    refused("LATIN1")
    note("one\0two")
    refused("zero byte")
    note("5 kOhm")
    lab.run("fleet", "push", "--to", to)
    all_there(server, "latin", lab)


def differs(server, lab):
    """A server that changes a byte of a frame on its way in, and a store that was changed since its run ended."""
    server.new_fleet(lab, "differs")
    to = server.conninfo("differs")
    uuid = next(run["uuid"] for run in lab.json("runs", "list")["runs"] if run["run"] == 2)
    server.sql(f"""CREATE FUNCTION spoil() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
                     IF NEW.position = 3 AND EXISTS (SELECT 1 FROM fleet.runs WHERE run = NEW.run AND uuid = '{uuid}') THEN
                       NEW.counts := set_byte(NEW.counts, 7, get_byte(NEW.counts, 7) # 1);
                     END IF;
                     RETURN NEW;
                   END $$;
                   CREATE TRIGGER spoil BEFORE INSERT ON fleet.frames FOR EACH ROW EXECUTE FUNCTION spoil()""", "differs")
    for _ in range(2):
        done = lab.run("fleet", "push", "--to", to, code=None)
        told(done, 5, "TB-FLEET-DIFFERS", "run 2: what came to the server has content", "nothing was kept there")
        expect("1 could not be sent" in done.stdout, done.stdout)
        nothing_of(server, "differs", uuid)
    expect(len(content_of(server, "differs")) == len(own_content(lab)) - 1, "the others are there")
    server.sql("DROP TRIGGER spoil ON fleet.frames", "differs")
    lab.run("fleet", "push", "--to", to)
    all_there(server, "differs", lab)

    server.new_fleet(lab, "changed")
    to = server.conninfo("changed")
    with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as other:
        bad = shutil.copy(os.path.join(lab.folder, "runs.db"), other)
        with sqlite3.connect(bad) as store:
            store.execute("UPDATE frames SET counts = zeroblob(length(counts)) WHERE frame = 2000000003")
        done = lab.run("fleet", "push", "--to", to, "--db", bad, code=None)
        told(done, 5, "TB-FLEET-DIFFERS", "the store itself has changed", "frame 3", "the last snapshot")
        nothing_of(server, "changed", uuid)
    lab.run("fleet", "push", "--to", to)
    all_there(server, "changed", lab)


def conflict(server, lab):
    """Two benches registered one serial with two types: the fleet keeps both, one store cannot hold them."""
    server.new_fleet(lab, "two")
    to = server.conninfo("two")
    with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as folder:
        other = Program(path, folder)
        other.run("init")
        shutil.copy(os.path.join(lab.folder, "loops.toml"), folder)
        with open(os.path.join(folder, "sensor.toml")) as file:
            kind = file.read()
        expect("pitch_mm = 2.54" in kind, kind)
        with open(os.path.join(folder, "sensor.toml"), "w") as file:
            file.write(kind.replace("pitch_mm = 2.54", "pitch_mm = 2.5"))
        other.run("sensors", "add", "S-1", "--type", "sensor.toml")
        other.run("run", "loops.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "--no-seating", "-q")
        for bench in (lab, other):
            bench.run("fleet", "push", "--to", to)
        both = {**own_content(lab), **own_content(other)}
        expect(content_of(server, "two") == both, "the fleet has the runs of both")
        first, second = next(iter(own_content(lab))), next(iter(own_content(other)))
        told(other.run("runs", "copy", first, second, "--from", to, "--to", "both.db", code=None), 2, "TB-FLEET-CONFLICT",
             "'S-1' registered with two types or scanners", "try: name runs of one registration")
        expect(not os.path.exists(os.path.join(folder, "both.db")), "no store of half of them")
        for uuid in (first, second):
            expect(other.json("verify", uuid, "--from", to)["holds"], "each by itself is sound")
            other.run("runs", "copy", uuid, "--from", to, "--to", f"{uuid}.db")
            copied = other.json("runs", "list", "--db", f"{uuid}.db")["runs"]
            expect([run["content_sha256"] for run in copied] == [both[uuid]], "and can be copied")


with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as laboratory, server_for("errors") as shared:
    bench = Program(path, laboratory)
    make_store(bench, RUNS)
    for case in (at_the_door, conflict, text, differs, silent):
        case(shared, bench)
    expect("sound" in bench.run("db", "check"), "the store is sound")
print("silence, texts, differences and conflicts are clear, and nothing was lost")
