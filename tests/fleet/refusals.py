"""What a bench is told when the fleet cannot be used, and that it loses nothing by it: wrong password, expired certificate,
another schema, a full disk, a server that has no TLS, is silent, or goes and comes back.

    refusals.py PROGRAM FULL_DISK_LIBRARY
"""

import os
import shutil
import subprocess
import sys
import tempfile

from libpq import Session
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
        refused(push(bench, PGPASSWORD="wrong"), 3, "TB-FLEET-LOGIN")
        refused(push(bench), 3, "TB-FLEET-LOGIN")
        trusting = bench.replace("127.0.0.1", "localhost") + f" hostaddr=127.0.0.1 sslmode=verify-full sslrootcert={keys}/server.crt"
        refused(push(trusting, PGPASSWORD="right"), 3, "TB-FLEET-TLS")
        refused(push(trusting.replace("server.crt", "none.crt"), PGPASSWORD="right"), 3, "TB-FLEET-TLS")
        refused(push(server.conninfo("no_such")), 3, "TB-FLEET-CONNECT")
        refused(push(bench.replace(f"port={server.port}", "port=1"), PGPASSWORD="right"), 3, "TB-FLEET-CONNECT")
        refused(push("nonsense"), 2, "TB-FLEET-CONNINFO")
        refused(lab.run("fleet", "status", "--to", bench.replace(f"port={server.port}", "port=1"), code=None), 3, "TB-FLEET-CONNECT")

        # --- another schema, and none
        server.sql("UPDATE fleet.about SET schema = 99")
        refused(push(bench, PGPASSWORD="right"), 5, "TB-FLEET-SCHEMA", "99")
        refused(lab.run("fleet", "migrate", "--to", server.conninfo(), code=None), 5, "TB-FLEET-SCHEMA")
        server.sql("UPDATE fleet.about SET schema = 1")
        server.new_database("empty")
        refused(push(server.conninfo("empty")), 5, "TB-FLEET-EMPTY", "fleet migrate")

        # --- no room on the server: a run is there whole or not at all
        open(mark, "w").close()
        refused(push(bench, PGPASSWORD="right"), 5, "TB-FLEET-FULL")
        os.unlink(mark)
        expect(server.sql("SELECT count(*) FROM fleet.runs") == [["0"]], "nothing of it is there")

        # --- a server without TLS for a bench that asks for it; one whose process for the push is stopped
        with Server() as plain:
            plain.new_database("tactile")
            lab.run("fleet", "migrate", "--to", plain.conninfo())
            refused(push(plain.conninfo(sslmode="require")), 3, "TB-FLEET-TLS")
            with Session(plain.conninfo()) as other:
                other.ask("BEGIN")
                other.ask("LOCK TABLE fleet.runs IN ACCESS EXCLUSIVE MODE")
                pushing = lab.start("fleet", "push", "--to", plain.conninfo(), "--patience", "3")
                said = pushing.communicate(timeout=LONGEST_S)[0]
                expect(pushing.returncode == 3 and "TB-FLEET-SILENT" in said, (pushing.returncode, said))
                other.ask("ROLLBACK")
            lab.run("fleet", "push", "--to", plain.conninfo())

        # --- the server goes in the midst of things and comes back
        lab.run("fleet", "push", "--to", bench, env={"PGPASSWORD": "right"})
        server.kill()
        lab.run("run", "loops.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "--seed", "77",
                "--no-seating", "-q")
        refused(push(bench, PGPASSWORD="right"), 3, "TB-FLEET-CONNECT")
        server.start()
        expect(push(bench, PGPASSWORD="right").returncode == 0, "the push of the third run")
        own = {run["uuid"]: run["content_sha256"] for run in lab.json("runs", "list")["runs"]}
        expect(content_of(server, "tactile") == own and len(own) == 3, "both agree")
    after = lab.json("runs", "list")
    expect(after["runs"][:2] == before["runs"], "the store is what it was")
    lab.run("verify")
print("every refusal was clear, and nothing was lost")
