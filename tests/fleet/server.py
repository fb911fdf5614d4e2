"""A real PostgreSQL for a test: its own cluster in a temporary folder, on loopback and a free port, as user postgres; no
service of the system is used or made. And the program under test, run as a person would.

Where it cannot run (not root, no PostgreSQL 15), the test ends with 77, which ctest shows as skipped.
"""

import ctypes
import glob
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

SKIPPED = 77
LONGEST_S = 300
BIN = "/usr/lib/postgresql/15/bin"


def skip_unless_possible():
    if os.geteuid() != 0:
        print("skipped: PostgreSQL is started as user postgres, which takes root")
        sys.exit(SKIPPED)
    if not os.path.exists(f"{BIN}/postgres"):
        print("skipped: postgresql-15 is not installed (./quickstart test installs it)")
        sys.exit(SKIPPED)


def dies_with_us():
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


PRIVATE = tempfile.TemporaryDirectory(prefix="tactbench-fleet-")


def environment(**more):
    """Nothing of the machine's own fleets, benches and profiles reaches the program, and nothing of it theirs."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PG", "TACTBENCH_"))}
    return {**kept, "TACTBENCH_RUNTIME_DIR": PRIVATE.name, "XDG_STATE_HOME": PRIVATE.name, **more}


class Server:
    def __init__(self, *settings, preload=None, more_environment=None):
        self.folder = tempfile.mkdtemp(prefix="tactbench-postgres-")
        os.chmod(self.folder, 0o711)
        self.data = os.path.join(self.folder, "data")
        os.mkdir(self.data)
        shutil.chown(self.data, "postgres", "postgres")
        self.settings, self.process, self.port = list(settings), None, 0
        self.environment = {**environment(), **({"LD_PRELOAD": preload} if preload else {}), **(more_environment or {})}
        self.as_postgres([f"{BIN}/initdb", "-D", self.data, "-A", "trust", "-U", "postgres", "--no-sync", "-E", "UTF8",
                          "--locale", "C.UTF-8"])

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.kill()
        shutil.rmtree(self.folder, ignore_errors=True)

    def as_postgres(self, command):
        subprocess.run(command, user="postgres", group="postgres", extra_groups=[], cwd="/", check=True, timeout=LONGEST_S,
                       stdout=subprocess.DEVNULL, env=environment())

    def start(self):
        """On the same port as before; on another where that one is taken."""
        for _ in range(5):
            self.port = self.port or free_port()
            command = [f"{BIN}/postgres", "-D", self.data, "-c", f"port={self.port}", "-c", "listen_addresses=127.0.0.1",
                       "-c", "unix_socket_directories=", "-c", "fsync=off", "-c", "logging_collector=off"]
            for setting in self.settings:
                command += ["-c", setting]
            with open(os.path.join(self.folder, "log"), "ab") as log:
                self.process = subprocess.Popen(
                    command, user="postgres", group="postgres", extra_groups=[], cwd="/", stdin=subprocess.DEVNULL,
                    stdout=log, stderr=log, preexec_fn=dies_with_us, start_new_session=True,
                    env=self.environment)
            end = time.monotonic() + LONGEST_S
            while time.monotonic() < end and self.process.poll() is None:
                if subprocess.run([f"{BIN}/pg_isready", "-q", "-h", "127.0.0.1", "-p", str(self.port)],
                                  env=environment(), check=False).returncode == 0:
                    return
                time.sleep(0.05)
            if self.process.poll() is None:
                self.kill()
                break
            self.port = 0
        sys.exit("PostgreSQL does not start:\n" + open(os.path.join(self.folder, "log"), errors="replace").read()[-3000:])

    def kill(self):
        """SIGKILL of the server with all its processes, as by a power cut of its machine; nothing is left running."""
        if self.process is None:
            return
        try:
            os.killpg(self.process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.process.wait()
        # Backends have sessions of their own: they end by themselves when they find the postmaster dead.
        end = time.monotonic() + LONGEST_S
        while self.children() and time.monotonic() < end:
            for pid in self.children():
                try:
                    os.kill(pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            time.sleep(0.02)
        for left in glob.glob(os.path.join(self.data, "postmaster.pid")):
            os.unlink(left)
        self.process = None

    def children(self):
        """Processes that run in this cluster's folder."""
        found = []
        for path in glob.glob("/proc/[0-9]*/cwd"):
            try:
                if os.readlink(path) == self.data:
                    found.append(int(path.split("/")[2]))
            except OSError:
                pass
        return found

    def stop(self):
        """As an administrator stops it: connections are ended."""
        self.process.send_signal(signal.SIGINT)
        self.process.wait(timeout=LONGEST_S)
        self.process = None

    def conninfo(self, database="tactile", user="postgres", **more):
        words = {"host": "127.0.0.1", "port": self.port, "dbname": database, "user": user, **more}
        return " ".join(f"{name}={value}" for name, value in words.items())

    def sql(self, text, database="tactile", user="postgres"):
        """Rows as lists of text; ends the test when the server refuses."""
        done = self.try_sql(text, database, user)
        if done.returncode != 0:
            sys.exit(f"psql: {text}\n{done.stderr}")
        return [line.split("\x1f") for line in done.stdout.splitlines()]

    def try_sql(self, text, database="tactile", user="postgres"):
        return subprocess.run([f"{BIN}/psql", "-X", "-q", "-A", "-t", "-F", "\x1f", "-v", "ON_ERROR_STOP=1",
                               self.conninfo(database, user), "-c", text], capture_output=True, text=True, check=False,
                              timeout=LONGEST_S, env=environment())

    def new_database(self, name, template="template0"):
        self.sql(f"CREATE DATABASE {name} TEMPLATE {template}", "postgres")


class Program:
    """tactbench in a folder of its own."""

    def __init__(self, path, folder):
        self.path, self.folder = os.path.abspath(path), folder

    def run(self, *words, code=0, env=None, cwd=None):
        """What it prints; ends the test when it ends with another code. code=None: the whole result."""
        done = subprocess.run([self.path, *map(str, words)], capture_output=True, text=True, cwd=cwd or self.folder,
                              timeout=LONGEST_S, env={**environment(), **(env or {})}, check=False)
        if code is None:
            return done
        if done.returncode != code:
            sys.exit(f"tactbench {' '.join(map(str, words))}\nended with {done.returncode}, not {code}\n{done.stdout}{done.stderr}")
        return done.stdout + done.stderr

    def json(self, *words, **more):
        done = subprocess.run([self.path, *map(str, words), "--json"], capture_output=True, text=True, cwd=self.folder,
                              timeout=LONGEST_S, env=environment(), check=False)
        if done.returncode != more.get("code", 0):
            sys.exit(f"tactbench {' '.join(map(str, words))} --json ended with {done.returncode}\n{done.stdout}{done.stderr}")
        return json.loads(done.stdout)

    def start(self, *words, **more):
        return subprocess.Popen([self.path, *map(str, words)], cwd=self.folder, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True, preexec_fn=dies_with_us, **{"env": environment(), **more})


def expect(so, what):
    if not so:
        sys.exit(f"FAILED: {what}")


def comes_true(condition, what, longest_s=120):
    end = time.monotonic() + longest_s
    while not condition():
        if time.monotonic() > end:
            sys.exit(f"FAILED: {what} did not come true in {longest_s} s")
        time.sleep(0.1)


def recipe(name, levels, step=10, repeats=1):
    return (f'schema = 1\nname = "{name}"\nunit = "psi"\nturning_points = {levels}\nstep = {step}\nrepeats = {repeats}\n')


def make_store(program, runs, store="runs.db"):
    """A simulated bench with so many short runs of sensor S-1; the first one has the fit of an ELAM and a tag."""
    program.run("init")
    with open(os.path.join(program.folder, "loops.toml"), "w") as file:
        file.write(recipe("loops", [0, 60, 0, 40, 0, 60, 20, 60, 0]))
    program.run("sensors", "add", "S-1", "--type", "sensor.toml", "--db", store)
    for i in range(runs):
        program.run("run", "loops.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "--db", store,
                    "--seed", 100 + i, "--no-seating", "-q")
    program.run("fit", 1, "--db", store)
    program.run("runs", "tag", 1, "first", "--db", store)
    return os.path.join(program.folder, store)


def content_of(server, database):
    """UUID -> content hash of the newest row, as the fleet says."""
    return dict(server.sql("SELECT uuid, content_sha256 FROM fleet.every_run", database))
