"""Benches, stores and servers that one must not believe: forged names and rows, other benches' runs, one bad row, a clock that
was ahead, a run that is not what was stored, and servers that are none.

    forged_data.py PROGRAM
"""

import contextlib
import glob
import os
import shutil
import socket
import sqlite3
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zlib

from server import LONGEST_S, Program, environment, expect, make_store, server_for, skip_unless_possible

skip_unless_possible()
path = sys.argv[1]
RUNS = 3


def rows_of(server, columns="run, pushed_by, facts->>'operator'"):
    return server.sql(f"SELECT {columns} FROM fleet.every_run ORDER BY run", "roles")


def changed_copy(lab, name, sql):
    for left in glob.glob(os.path.join(lab.folder, name + "*")):
        os.unlink(left)
    shutil.copy(os.path.join(lab.folder, "runs.db"), os.path.join(lab.folder, name))
    with contextlib.closing(sqlite3.connect(os.path.join(lab.folder, name))) as store, store:
        store.execute(sql)


def roles(server, lab):
    """By SQL alone a bench can say what it likes of its own runs, and nothing of others'."""
    server.new_fleet(lab, "roles")
    for role in ("rig_a", "rig_b"):
        server.new_role(role, "LOGIN IN ROLE tactbench_bench")
    server.new_role("reader", "LOGIN IN ROLE tactbench_analyst")
    server.new_role("stranger")
    a, reader = server.conninfo("roles", "rig_a"), server.conninfo("roles", "reader")
    lab.run("fleet", "push", "--to", a)
    before = rows_of(server)
    expect([row[1] for row in before] == ["rig_a"] * RUNS, before)
    columns = "uuid, content_sha256, said_sha256, source, facts, body, body_sha256"
    same = "uuid, content_sha256, repeat('0', 64), source, facts || '{\"operator\": \"MALLORY\"}', body, body_sha256"
    of_a = "FROM fleet.runs ORDER BY revision LIMIT 1"
    new = "overlay(uuid placing 'aaaaaaaa' from 1)"
    for user, sql, word in (
            ("rig_b", f"INSERT INTO fleet.runs ({columns}) SELECT {same} {of_a}", "was pushed by rig_a"),
            ("rig_b", f"INSERT INTO fleet.runs ({columns}, pushed_by) SELECT {same}, 'rig_a' {of_a}", "denied"),
            ("rig_b", f"INSERT INTO fleet.runs ({columns}, pushed_at) SELECT {same}, '2001-01-01' {of_a}", "denied"),
            ("rig_b", f"INSERT INTO fleet.runs ({columns}, revision) SELECT {same}, 999999 {of_a}", "denied"),
            ("rig_b", "INSERT INTO fleet.owners (uuid, owner) VALUES ('aaaaaaaa-0000-4000-8000-000000000000', 'rig_a')", "denied"),
            ("rig_b", "UPDATE fleet.owners SET owner = 'rig_b'", "denied"),
            ("rig_b", "SELECT nextval('fleet.revisions')", "denied"),
            ("rig_b", "UPDATE fleet.runs SET facts = '{}'", "denied"),
            ("rig_b", "DELETE FROM fleet.runs", "denied"),
            ("rig_b", "TRUNCATE fleet.runs", "denied"),
            ("rig_b", "CREATE TABLE fleet.x (a int)", "denied"),
            ("rig_b", "SET SESSION AUTHORIZATION rig_a", "denied"),
            ("reader", f"INSERT INTO fleet.runs ({columns}) SELECT {same} {of_a}", "denied"),
            ("stranger", "SELECT count(*) FROM fleet.runs", "denied"),
            ("postgres", "UPDATE fleet.runs SET facts = '{}'", "nobody changes"),
            ("postgres", "DELETE FROM fleet.runs", "nobody changes"),
            ("postgres", "TRUNCATE fleet.runs", "nobody changes"),
            ("rig_b", f"INSERT INTO fleet.runs ({columns}) SELECT {new}, content_sha256, said_sha256, source, '[]', body, body_sha256 {of_a}", "check"),
            ("rig_b", f"INSERT INTO fleet.runs ({columns}) SELECT {new}, content_sha256, said_sha256, source, facts, body, repeat('0', 64) {of_a}", "check")):
        said = server.try_sql(sql, "roles", user)
        expect(isinstance(said, str) and word in said, (user, sql, said))
    expect(rows_of(server) == before, "nothing came of it")
    done = lab.run("fleet", "runs", "--from", server.conninfo("roles", "stranger"), code=5)
    expect("TB-FLEET-DENIED" in done, done)

    # --- what a bench says of runs of its own hides nobody else's: facts of any kind, a body that is none or a bomb
    bad = [("facts || '{\"frames\": 1e999, \"recipes\": 3, \"tags\": {\"a\": 1}, \"verdicts\": [3, {}], \"figures\": [1]}'", b"x"),
           ("jsonb_build_object('origin', 'simulated')", zlib.compress(b"no store")),
           ("facts", zlib.compress(bytes(3 << 20))),
           ("facts", None)]  # the body of another's run
    for i, (facts, body) in enumerate(bad):
        text = "body" if body is None else f"'\\x{body.hex()}'::bytea"
        server.sql(f"INSERT INTO fleet.runs ({columns}) SELECT overlay(uuid placing 'bbbbbbb{i}' from 1), content_sha256, said_sha256, "
                   f"source, {facts}, {text}, encode(sha256({text}), 'hex') {of_a}", "roles", "rig_b")
    for view in ("every_run", "simulated_runs", "simulated_verdicts", "simulated_figures", "simulated_fits"):
        server.sql(f"SELECT * FROM fleet.{view}", "roles", "reader")
    listed = lab.run("fleet", "runs", "--from", reader, "--origin", "simulated", "--json", code=None)
    expect(listed.returncode == 0 and listed.stderr.count("pushed by rig_b") == 2, listed.stderr)
    expect(all(row[0] in listed.stdout for row in before), "every other run is listed")
    lab.run("fleet", "trend", "--from", reader, "--origin", "simulated")
    for i in range(len(bad)):
        for words in (("verify",), ("fleet", "show")):
            done = lab.run(*words, f"bbbbbbb{i}", "--from", reader, code=5)
            expect("TB-FLEET-CHANGED" in done, done)
    uuids = [run["uuid"] for run in lab.json("runs", "list")["runs"]]
    for uuid in uuids:
        lab.run("verify", uuid, "--from", reader)
    expect(lab.json("fleet", "push", "--to", a)["pushed"] == [], "a push is not disturbed")

    # --- another bench has a copy of a run and says more of it: that run stays its bench's, the others are sent
    with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as folder:
        other = Program(path, folder)
        make_store(other, 2)
        lab.run("runs", "copy", 1, "--to", "copy.db")
        b = server.conninfo("roles", "rig_b")
        expect(lab.json("fleet", "push", "--to", b, "--db", "copy.db")["not_pushed"] == 0, "the same run is there")
        lab.run("runs", "tag", 1, "mine", "--db", "copy.db")
        pushed = lab.run("fleet", "push", "--to", b, "--db", "copy.db", code=5)
        expect("TB-FLEET-OWNER" in pushed, pushed)
        expect(len(other.json("fleet", "push", "--to", b)["pushed"]) >= 2, "its own are sent")

    # --- a change behind the program's back is found
    server.sql("SET session_replication_role = replica; ALTER TABLE fleet.runs DROP CONSTRAINT runs_check; "
               f"UPDATE fleet.runs SET body = set_byte(body, 99, get_byte(body, 99) # 1) WHERE uuid = '{uuids[0]}'", "roles")
    expect("TB-FLEET-CHANGED" in lab.run("verify", uuids[0], "--from", reader, code=5), "a changed body")


def refused_runs(server, lab):
    """What `verify` refuses is not sent, and holds up nothing else; a server that spoils a body keeps nothing of it."""
    server.new_fleet(lab, "bad")
    to = server.conninfo("bad")
    uuids = {run["run"]: run["uuid"] for run in lab.json("runs", "list")["runs"]}
    for change, ident in (("UPDATE frames SET counts = zeroblob(length(counts)) WHERE frame = 2000000003", "TB-STORE-CONFLICT"),
                          ("DELETE FROM fits WHERE run = 1", "TB-STORE-CONFLICT"),
                          ("UPDATE runs SET uuid = 'x' WHERE run = 2", "TB-FLEET-SQL")):
        changed_copy(lab, "bad.db", change)
        done = lab.run("fleet", "push", "--to", to, "--db", "bad.db", code=None)
        expect(done.returncode == 5 and ident in done.stderr, (change, done.stdout, done.stderr))
        waiting = lab.json("fleet", "status", "--to", to, "--db", "bad.db")
        expect(waiting["waiting_runs"] + waiting["waiting_remarks"] == 1, (change, waiting))
    expect(int(server.sql("SELECT count(DISTINCT uuid) FROM fleet.runs", "bad")[0][0]) == RUNS, "each of the others was sent")
    server.new_fleet(lab, "spoiled")
    to = server.conninfo("spoiled")
    server.sql(f"""ALTER TABLE fleet.runs DROP CONSTRAINT runs_check;
                   CREATE FUNCTION spoil() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
                     IF NEW.uuid = '{uuids[2]}' THEN NEW.body := set_byte(NEW.body, 7, get_byte(NEW.body, 7) # 1); END IF;
                     RETURN NEW;
                   END $$;
                   CREATE TRIGGER spoil BEFORE INSERT ON fleet.runs FOR EACH ROW EXECUTE FUNCTION spoil()""", "spoiled")
    done = lab.run("fleet", "push", "--to", to, code=None)
    expect(done.returncode == 5 and "TB-FLEET-DIFFERS" in done.stderr, done.stderr)
    expect(server.sql("SELECT count(*) FROM fleet.runs", "spoiled") == [[str(RUNS - 1)]], "the others are there, nothing of it")
    server.sql("DROP TRIGGER spoil ON fleet.runs", "spoiled")
    lab.run("fleet", "push", "--to", to)
    expect(server.sql("SELECT count(*) FROM fleet.runs", "spoiled") == [[str(RUNS)]], "now all")


def clock_ahead(server, lab):
    """A run's first row says that it ended in the year 2099: the row that came later counts all the same."""
    server.new_fleet(lab, "clock")
    to = server.conninfo("clock")
    changed_copy(lab, "ahead.db", "UPDATE runs SET started_utc = '2099-01-01T00:00:00Z', ended_utc = '2099-01-01T01:00:00Z'")
    lab.run("fleet", "push", "--to", to, "--db", "ahead.db")
    lab.run("runs", "tag", 1, "later")
    lab.run("fleet", "push", "--to", to)
    expect("later" in server.sql("SELECT tags FROM fleet.every_run ORDER BY run", "clock")[0][0], "the newest row counts")
    lab.run("runs", "tag", 1, "later", "--remove")


def registered_twice(server, lab):
    """Two benches registered one serial with two types: the fleet keeps both, one store cannot hold them."""
    server.new_fleet(lab, "two")
    to = server.conninfo("two")
    with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as folder:
        other = Program(path, folder)
        other.run("init")
        with open(f"{folder}/sensor.toml") as file:
            kind = file.read()
        with open(f"{folder}/sensor.toml", "w") as file:
            file.write(kind.replace("pitch_mm = 2.54", "pitch_mm = 2.5"))
        shutil.copy(f"{lab.folder}/loops.toml", folder)
        other.run("sensors", "add", "S-1", "--type", "sensor.toml")
        other.run("run", "loops.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "--no-seating", "-q")
        for bench in (lab, other):
            bench.run("fleet", "push", "--to", to)
        first, second = (bench.json("runs", "list")["runs"][0]["uuid"] for bench in (lab, other))
        expect("TB-FLEET-CONFLICT" in other.run("runs", "copy", first, second, "--from", to, "--to", "both.db", code=2), "both")
        expect(not os.path.exists(f"{folder}/both.db"), "no store of half of them")
        for uuid in (first, second):
            other.run("verify", uuid, "--from", to)


def message(kind, payload):
    return kind + struct.pack(">I", len(payload) + 4) + payload


STARTED = message(b"R", struct.pack(">I", 0)) + message(b"Z", b"I")
NO_ROW = message(b"1", b"") + message(b"2", b"") + message(b"n", b"") + message(b"C", b"SELECT 0\0") + message(b"Z", b"I")
ROWS = message(b"1", b"") + message(b"2", b"") + message(b"T", struct.pack(">H", 1) + b"x\0" + struct.pack(">IHIHIH", 0, 0, 25, 65535, 0xffffffff, 0))
A_ROW = message(b"D", struct.pack(">HI", 1, 100000) + b"A" * 100000)
A_NOTICE = message(b"N", b"SNOTICE\0C00000\0M" + b"\x1b[31mX\n" * 2000 + b"\0\0")


def no_servers(lab):
    """Each ends the push with an id, in bounded time and memory, and nothing of a terminal's control characters is printed."""
    def answer(link, first, each, endless):
        try:
            link.settimeout(60)
            if link.recv(8000)[4:8] == b"\x04\xd2\x16/":  # it asks for TLS
                link.sendall(b"N")
                link.recv(8000)
            link.sendall(first)
            while True:
                asked = link.recv(8000)
                if not asked:
                    return
                link.sendall(each)
                while endless:
                    link.sendall(endless)
        except OSError:
            pass

    for name, first, each, endless in (
            ("garbage", os.urandom(5000), b"", b""), ("http", b"HTTP/1.1 400 Bad Request\r\n\r\n", b"", b""),
            ("huge length", b"R\x7f\xff\xff\xff", b"", b""), ("no row", STARTED, NO_ROW, b""), ("rubbish", STARTED, os.urandom(3000), b""),
            ("notices", STARTED, b"", A_NOTICE), ("rows", STARTED, ROWS, A_ROW),
            ("escapes", message(b"E", b"SFATAL\0C28P01\0M\x1b[31mowned\x1b]0;t\x07\xff\0\0"), b"", b"")):
        with socket.create_server(("127.0.0.1", 0)) as door:
            def serve(door=door, first=first, each=each, endless=endless):
                while True:
                    try:
                        link, _ = door.accept()
                    except OSError:
                        return
                    threading.Thread(target=answer, args=(link, first, each, endless), daemon=True).start()
            threading.Thread(target=serve, daemon=True).start()
            begun = time.monotonic()
            done = subprocess.run(["sh", "-c", 'ulimit -v 4000000; exec "$@"', "sh", lab.path, "fleet", "push", "--patience", "3", "--to",
                                   f"host=127.0.0.1 port={door.getsockname()[1]} user=u dbname=d"],
                                  cwd=lab.folder, capture_output=True, timeout=LONGEST_S, env={**environment(), "PGPASSWORD": "x"}, check=False)
            expect(done.returncode == 3 and b"[TB-FLEET-" in done.stderr, (name, done))
            expect(time.monotonic() - begun < 60 and b"\x1b" not in done.stderr + done.stdout, (name, done))


def no_tls(lab):
    """A server without TLS that asks for the password in clear gets it on this computer, or where somebody said so."""
    for host, words, variables, told in (("127.0.0.1", "", {}, True), ("127.0.0.2", "", {}, False),  # any but 127.0.0.1 is elsewhere
                                         ("127.0.0.1,127.0.0.2", "", {}, False), ("127.0.0.2", "sslmode=prefer", {}, True),
                                         ("127.0.0.2", "", {"PGSSLMODE": "disable"}, True), ("", "service=lab", {}, False),
                                         ("", "service=open", {}, True), ("", "", {"PGHOST": "127.0.0.2"}, False),
                                         ("127.0.0.1", "hostaddr=127.0.0.2", {}, False), ("127.0.0.2", "sslmode=verify-full", {}, False)):
        heard = []

        def answer(link, heard=heard):
            with contextlib.suppress(OSError), link:
                link.settimeout(5)
                if link.recv(8000)[4:8] == b"\x04\xd2\x16/":
                    link.sendall(b"N")
                    link.recv(8000)
                link.sendall(message(b"R", struct.pack(">I", 3)))
                heard.append(link.recv(8000))

        with socket.create_server(("0.0.0.0", 0)) as door:
            port = door.getsockname()[1]

            def serve(door=door, answer=answer):
                with contextlib.suppress(OSError):
                    while True:
                        answer(door.accept()[0])
            threading.Thread(target=serve, daemon=True).start()
            with open(f"{lab.folder}/services", "w") as file:
                file.write("[lab]\nhost=127.0.0.2\n[open]\nhost=127.0.0.2\nsslmode=prefer\n")
            to = f"port={port} user=u dbname=d {words}" + (f" host={host}" if host else "")
            done = subprocess.run([lab.path, "fleet", "push", "--patience", "3", "--to", to], cwd=lab.folder, capture_output=True, check=False,
                                  timeout=LONGEST_S, env={**environment(), "PGPASSWORD": "hunter2", "PGSERVICEFILE": "services", **variables})
            expect(done.returncode == 3 and (b"hunter2" in b"".join(heard)) == told, (to, variables, heard, done))
            expect(told or b"[TB-FLEET-TLS]" in done.stderr, (to, variables, done))


with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as laboratory, server_for("hostile") as shared:
    bench = Program(path, laboratory)
    make_store(bench, RUNS)
    no_servers(bench)
    no_tls(bench)
    for case in (roles, refused_runs, clock_ahead, registered_twice):
        case(shared, bench)
    bench.run("verify")
    shared.new_database("latin", more="ENCODING 'LATIN1' LOCALE 'C'")
    expect("TB-FLEET-TEXT" in bench.run("fleet", "migrate", "--to", shared.conninfo("latin"), code=5), "encoding")
print("nobody was believed, and nothing was lost")
