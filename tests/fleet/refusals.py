"""What a bench is told when the fleet cannot be used, and that it loses nothing by it: wrong password, expired certificate,
another schema, a full disk, a server that is away, also while a run is carried out and `--follow` waits.

    refusals.py PROGRAM FULL_DISK_LIBRARY
"""

import os
import shutil
import signal
import subprocess
import sys
import tempfile

from server import LONGEST_S, Program, Server, comes_true, content_of, environment, expect, make_store, skip_unless_possible

skip_unless_possible()
path, full_disk = sys.argv[1:]


def refused(done, code, name, *words):
    expect(done.returncode == code, (code, done.returncode, done.stdout, done.stderr))
    for word in (name, "try: ", *words):
        expect(word in done.stderr, (word, done.stderr))


def expired_certificate(folder):
    """A certificate of its own that was good for the year 2020."""
    def openssl(*words):
        subprocess.run(["openssl", *words], cwd=folder, check=True, capture_output=True, timeout=LONGEST_S)

    openssl("req", "-newkey", "rsa:2048", "-nodes", "-keyout", "server.key", "-subj", "/CN=localhost", "-out", "server.csr")
    os.mkdir(os.path.join(folder, "ca"))
    with open(os.path.join(folder, "ca.cnf"), "w") as file:
        file.write("[ca]\ndefault_ca = d\n[d]\ndatabase = ca/index\nserial = ca/serial\nnew_certs_dir = ca\n"
                   "default_md = sha256\npolicy = p\n[p]\ncommonName = supplied\n")
    open(os.path.join(folder, "ca", "index"), "w").close()
    with open(os.path.join(folder, "ca", "serial"), "w") as file:
        file.write("01\n")
    openssl("ca", "-batch", "-selfsign", "-config", "ca.cnf", "-keyfile", "server.key", "-in", "server.csr", "-out", "server.crt",
            "-startdate", "20200101000000Z", "-enddate", "20210101000000Z", "-notext")
    for name in ("server.key", "server.crt"):
        shutil.chown(os.path.join(folder, name), "postgres", "postgres")
    os.chmod(os.path.join(folder, "server.key"), 0o600)


with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as folder, \
     tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as keys:
    os.chmod(keys, 0o755)
    expired_certificate(keys)
    mark = os.path.join(keys, "full")
    full_disk = shutil.copy(full_disk, keys)  # where user postgres can read it
    lab = Program(path, folder)
    make_store(lab, 2)
    before = lab.json("runs", "list")
    with Server("ssl=on", f"ssl_cert_file={keys}/server.crt", f"ssl_key_file={keys}/server.key",
                preload=full_disk, more_environment={"TACTBENCH_FULL_DISK": mark}) as server:
        server.new_database("tactile")
        lab.run("fleet", "migrate", "--to", server.conninfo())
        server.new_role("bench_a", "LOGIN PASSWORD 'right' IN ROLE tactbench_bench")
        with open(os.path.join(server.data, "pg_hba.conf"), "w") as file:
            file.write("host all postgres 127.0.0.1/32 trust\nhost all all 127.0.0.1/32 scram-sha-256\n")
        server.sql("SELECT pg_reload_conf()")
        bench = server.conninfo(user="bench_a")

        def push(to, **env):
            return lab.run("fleet", "push", "--to", to, code=None, env=env)

        # --- refused at the door
        comes_true(lambda: push(bench, PGPASSWORD="wrong").returncode == 3, "the new rules of login", 30)
        refused(push(bench, PGPASSWORD="wrong"), 3, "TB-FLEET-LOGIN", "password")
        refused(push(bench), 3, "TB-FLEET-LOGIN", ".pgpass")
        trusting = bench.replace("127.0.0.1", "localhost") + f" hostaddr=127.0.0.1 sslmode=verify-full sslrootcert={keys}/server.crt"
        refused(push(trusting, PGPASSWORD="right"), 3, "TB-FLEET-TLS", "expired")
        refused(push(trusting.replace("server.crt", "none.crt"), PGPASSWORD="right"), 3, "TB-FLEET-TLS", "none.crt")
        refused(push(server.conninfo("no_such")), 3, "TB-FLEET-CONNECT", "no_such")
        refused(push(bench.replace(f"port={server.port}", "port=1"), PGPASSWORD="right"), 3, "TB-FLEET-CONNECT", "refused")
        refused(push("nonsense"), 2, "TB-FLEET-CONNINFO")
        status = lab.json("fleet", "status", "--to", bench.replace(f"port={server.port}", "port=1"), code=3)
        expect(status["waiting_runs"] == 2 and not status["reached"] and status["by"] == "note", status)

        # --- another schema
        today = server.sql("SELECT version, program_version FROM fleet.migrations ORDER BY version")
        server.sql("INSERT INTO fleet.migrations VALUES (99, 'of tomorrow')")
        refused(push(bench, PGPASSWORD="right"), 5, "TB-FLEET-NEWER", "schema 99")
        refused(lab.run("fleet", "migrate", "--to", server.conninfo(), code=None), 5, "TB-FLEET-NEWER")
        server.sql("SET session_replication_role = replica; DELETE FROM fleet.migrations; INSERT INTO fleet.migrations VALUES (0, 'of yesterday')")
        server.sql("CREATE DATABASE older TEMPLATE tactile", "postgres")
        for version, program in today:
            server.sql(f"INSERT INTO fleet.migrations VALUES ({version}, '{program}')")
        server.sql("DROP SCHEMA fleet CASCADE", "older")
        refused(push(server.conninfo("older")), 5, "TB-FLEET-EMPTY", "fleet migrate")
        server.sql("CREATE SCHEMA fleet; CREATE TABLE fleet.migrations (version bigint); INSERT INTO fleet.migrations VALUES (-1)", "older")
        refused(push(server.conninfo("older")), 5, "TB-FLEET-OLDER", "fleet migrate")

        # --- no room on the server: a run is there whole or not at all
        open(mark, "w").close()
        refused(push(bench, PGPASSWORD="right"), 5, "TB-FLEET-FULL", "disk")
        os.unlink(mark)
        expect(server.sql("SELECT count(*) FROM fleet.runs") == [["0"]], "nothing of it is there")

        # --- after the refusals an ordinary run of another store is taken
        with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as odd:
            one = Program(path, odd)
            make_store(one, 1)
            one.run("runs", "note", 1, "fine")
            done = one.run("fleet", "push", "--to", bench, env={"PGPASSWORD": "right"}, code=None)
            expect(done.returncode == 0, done.stderr)

        # --- the server goes and comes back while --follow waits and a run is carried out; the run does not notice
        follower = lab.start("fleet", "push", "--to", bench, "--follow", "--every", "0.2",
                             env={**environment(), "PGPASSWORD": "right"})
        comes_true(lambda: server.sql("SELECT count(*) FROM fleet.runs") == [["3"]], "the push of two runs")
        server.kill()
        lab.run("run", "loops.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "--seed", "77",
                "--no-seating", "-q")
        expect(lab.json("fleet", "status", "--to", bench, code=3)["waiting_runs"] == 1, "the backlog by the note")
        expect("keeps everything" in lab.run("fleet", "status", "--to", bench, code=3), "in words")
        server.start()
        comes_true(lambda: server.try_sql("SELECT count(*) FROM fleet.runs") == [["4"]], "the push of the third run")
        follower.send_signal(signal.SIGTERM)
        said = follower.communicate(timeout=LONGEST_S)[0]
        expect(follower.returncode == 0 and "tried again" in said and "there again" in said, (follower.returncode, said))
        own = {run["uuid"]: run["content_sha256"] for run in lab.json("runs", "list")["runs"]}
        theirs = content_of(server, "tactile")
        expect(all(theirs[uuid] == own[uuid] for uuid in own), "both agree")

        # --- a fleet of schema 1, with runs in it, is brought up to date and takes more
        server.sql("SET session_replication_role = replica; DELETE FROM fleet.migrations WHERE version > 1; "
                   "ALTER TABLE fleet.reports DROP COLUMN reason")
        lab.run("runs", "note", 3, "after the migration")
        refused(push(bench, PGPASSWORD="right"), 5, "TB-FLEET-OLDER", "fleet migrate")
        lab.run("fleet", "migrate", "--to", server.conninfo())
        expect(server.sql("SELECT max(version) FROM fleet.migrations") == [[today[-1][0]]], "the schema of today")
        expect(push(bench, PGPASSWORD="right").returncode == 0, "a push to the migrated fleet")
        expect(content_of(server, "tactile") == theirs, "every run is there as it was")
        expect(lab.json("fleet", "status", "--to", bench, env={"PGPASSWORD": "right"})["waiting_runs"] == 0, "nothing waits")
    after = lab.json("runs", "list")
    expect(after["runs"][:2] == before["runs"], "the store is what it was")
    expect("sound" in lab.run("db", "check"), "and sound")
print("every refusal was clear, and nothing was lost")
