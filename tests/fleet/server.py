"""A real PostgreSQL for a test: its own cluster in a temporary folder, on loopback and a free port, as user postgres; no
service of the system is used or made. Or databases on a server that several tests share (common_server.py). And the program
under test, run as a person would.

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

from libpq import Refused, ask

SKIPPED = 77
LONGEST_S = 300
BIN = "/usr/lib/postgresql/15/bin"
MADE = "fleet_made"  # on the common server: a fleet's tables, to make databases from


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


def fast_place():
    """A folder in memory where there is room for a cluster, since most of its making is writing; else that of temporary files.
    Who cleans up behind the test itself (tests/mutants) names another."""
    if "TACTBENCH_TEST_PLACE" in os.environ:
        return os.environ["TACTBENCH_TEST_PLACE"]
    try:
        return "/dev/shm" if shutil.disk_usage("/dev/shm").free > 2 << 30 else None
    except OSError:
        return None


def common():
    """What common_server.py says of itself; nothing: it does not run."""
    try:
        with open(os.environ.get("TACTBENCH_TEST_SERVER", "")) as file:
            return json.load(file)
    except FileNotFoundError:
        return {}


class Server:
    # made_in: the cluster is made there, and what runs is a copy.
    def __init__(self, *settings, preload=None, more_environment=None, made_in=None):
        self.folder = tempfile.mkdtemp(prefix="tactbench-postgres-", dir=fast_place())
        os.chmod(self.folder, 0o711)
        self.data = os.path.join(self.folder, "data")
        self.settings, self.process, self.port = list(settings), None, 0
        self.environment = {**environment(), **({"LD_PRELOAD": preload} if preload else {}), **(more_environment or {})}
        pristine = made_in or common().get("pristine", self.data)
        if not os.path.exists(pristine):
            os.chmod(os.path.dirname(pristine), 0o711)
            os.mkdir(pristine)
            shutil.chown(pristine, "postgres", "postgres")
            self.as_postgres([f"{BIN}/initdb", "-D", pristine, "-A", "trust", "-U", "postgres", "--no-sync", "-E", "UTF8",
                              "--locale", "C.UTF-8"])
        if pristine != self.data:
            subprocess.run(["cp", "-a", pristine, self.data], check=True, timeout=LONGEST_S)

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        if self.process is not None:
            self.process.send_signal(signal.SIGQUIT)  # at once, but it takes its shared memory along
            try:
                self.process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                pass
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
                       "-c", "unix_socket_directories=", "-c", "fsync=off", "-c", "logging_collector=off",
                       # A server that is killed leaves it behind: better in its own folder than in the system's.
                       "-c", "dynamic_shared_memory_type=mmap"]
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

    def conninfo(self, database="tactile", user="postgres", **more):
        words = {"host": "127.0.0.1", "port": self.port, "dbname": database, "user": user, **more}
        return " ".join(f"{name}={value}" for name, value in words.items())

    def try_sql(self, text, database="tactile", user="postgres"):
        """Rows as lists of text, or what the server says against it."""
        try:
            return ask(self.conninfo(database, user), text)
        except Refused as refused:
            return str(refused)

    def sql(self, text, database="tactile", user="postgres"):
        rows = self.try_sql(text, database, user)
        if isinstance(rows, str):
            sys.exit(f"SQL: {text}\n{rows}")
        return rows

    def new_role(self, name, more="LOGIN"):
        self.sql(f"CREATE ROLE {name} {more}", "postgres")

    def new_database(self, name, template="template0", more=""):
        self.sql(f"CREATE DATABASE {name} TEMPLATE {template} {more}", "postgres")

    def new_fleet(self, program, name):
        self.new_database(name)
        program.run("fleet", "migrate", "--to", self.conninfo(name))


class SharedServer(Server):
    """The common server. Names of databases are this test's own; roles are all tests'."""

    def __init__(self, name):
        self.name, self.port, self.roles = name, common()["port"], []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for (database,) in self.sql(f"SELECT datname FROM pg_database WHERE datname LIKE '{self.name}\\_%'", "postgres"):
            self.sql(f"DROP DATABASE {database} WITH (FORCE)", "postgres")
        for role in self.roles:
            self.sql(f"DROP ROLE {role}", "postgres")

    def own(self, database):
        return database if database in ("postgres", "template0", MADE) else f"{self.name}_{database}"

    def conninfo(self, database="tactile", user="postgres", **more):
        return super().conninfo(self.own(database), user, **more)

    def new_database(self, name, template="template0", more=""):
        super().new_database(self.own(name), self.own(template), more)

    def new_fleet(self, program, name):
        self.new_database(name, MADE)

    def new_role(self, name, more="LOGIN"):
        super().new_role(name, more)
        self.roles.append(name)


def server_for(name):
    """The common server where it runs, else one of the test's own."""
    return SharedServer(name) if common() else Server()


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
                              timeout=LONGEST_S, env={**environment(), **more.get("env", {})}, check=False)
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
    program.run("fit", 1, "--model", "elam", "--db", store)
    program.run("runs", "tag", 1, "first", "--db", store)
    return os.path.join(program.folder, store)


def content_of(server, database):
    """UUID -> content hash of the newest row, as the fleet says."""
    return dict(server.sql("SELECT uuid, content_sha256 FROM fleet.every_run", database))
