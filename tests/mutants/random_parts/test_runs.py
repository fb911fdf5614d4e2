"""Runs a test executable (Catch2 v2) within bounds of time, memory and files, in a folder that goes with it, and tells which
tests failed. Whatever the tests started and left behind is ended: by the mark in its environment, for it may have left the
process group."""
import dataclasses
import html
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import uuid

MARK = "TACTBENCH_MUTANT_TRIAL"  # in the environment of what one run of tests starts
CAMPAIGN = "TACTBENCH_MUTANT_CAMPAIGN"  # in that of all that the campaign starts
MEMORY_BYTES = 6 << 30  # of address space, a process; the unchanged tests keep within it
FILE_BYTES = 1 << 30
REPORT = "tests.xml"  # of Catch2, in the folder of the run
LONGEST_OUTPUT = 8 << 20  # bytes of the executable's report that are read, from its end


@dataclasses.dataclass
class Limit:
    wall_s: float
    cpu_s: float


class Stopped(Exception):
    """The campaign was told to end."""


stopping = threading.Event()
UNMUTATED = Limit(1800, 1800)


@dataclasses.dataclass
class Outcome:
    passed: bool
    timed_out: bool
    failed: list  # names of the tests that failed; the one that it died in is the last
    ran: int  # tests that were begun
    wall_s: float
    cpu_s: float
    code: int = 0  # as wait4() tells it


def spec(name):
    """A test's name as a word of Catch2's command line that matches it alone."""
    return '"' + re.sub(r'([\\,\["])', r"\\\1", name) + '"'


def failed_tests(report, died):
    cases = re.split(r"<TestCase ", report)[1:]
    failed = []
    for i, case in enumerate(cases):
        name = html.unescape(re.match(r'name="([^"]*)"', case).group(1)) if case.startswith('name="') else "?"
        if '<OverallResult success="false"' in case or (died and i + 1 == len(cases) and "<OverallResult " not in case):
            failed.append(name)
    return failed


def end_all(mark, value):
    """Ends every process whose environment says mark=value."""
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit() and int(entry.name) != os.getpid():
            try:
                if f"{mark}={value}".encode() in (entry / "environ").read_bytes().split(b"\0"):
                    os.kill(int(entry.name), signal.SIGKILL)
            except OSError:
                pass  # it has ended, or is another user's


def end_below(folder):
    """Ends every process that works below the folder: PostgreSQL's own overwrite their environment."""
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if pathlib.Path(os.readlink(entry / "cwd")).is_relative_to(folder):
                    os.kill(int(entry.name), signal.SIGKILL)
            except OSError:
                pass  # it has ended


def begin_campaign():
    """From here on SIGINT and SIGTERM end what was started, and let each thread clean up behind itself."""
    os.environ[CAMPAIGN] = uuid.uuid4().hex

    def stop(number, _):
        stopping.set()
        end_all(CAMPAIGN, os.environ[CAMPAIGN])
        raise SystemExit(128 + number)
    signal.signal(signal.SIGINT, stop)
    signal.signal(signal.SIGTERM, stop)


def run(executable, words, limit, more=None):
    """The outcome of the executable with more words, e.g. names of tests; `more`: what else its environment holds."""
    status, timed_out, text, wall_s, cpu_s = bounded([str(executable), *words, "-r", "xml", "-o", REPORT], limit, more or {})
    return Outcome(status == 0, timed_out, failed_tests(text, status != 0), text.count("<TestCase "), wall_s, cpu_s, status)


def run_script(name, command, limit, more):
    """The outcome of a script that is one test, of this name."""
    status, timed_out, _, wall_s, cpu_s = bounded(command, limit, more)
    return Outcome(status == 0, timed_out, [name] if status != 0 else [], 1, wall_s, cpu_s, status)


def bounded(command, limit, more):
    """Carries out a command in a folder that goes with it: status, whether it took too long, its report, and its times."""
    if stopping.is_set():
        raise Stopped
    mark = uuid.uuid4().hex
    folder = tempfile.mkdtemp(prefix="tbm-")  # short: paths of sockets lie in it
    os.chmod(folder, 0o755)  # as /tmp is for tests that give up root's rights
    places = {name: folder for name in ("TMPDIR", "HOME", "XDG_STATE_HOME", "TACTBENCH_TEST_PLACE")}
    bounds = [f"--as={MEMORY_BYTES}", f"--fsize={FILE_BYTES}", "--core=0", f"--cpu={int(limit.cpu_s) + 1}"]
    report = pathlib.Path(folder, REPORT)
    begun = time.monotonic()
    try:
        with open(os.path.join(folder, "said"), "wb") as said:
            process = subprocess.Popen(["prlimit", *bounds, *command], cwd=folder, env={**os.environ, **more, **places, MARK: mark},
                                       stdin=subprocess.DEVNULL, stdout=said, stderr=said, start_new_session=True)
        status, usage = waited(process, begun + limit.wall_s)
        timed_out = status is None
        if timed_out:
            os.killpg(process.pid, signal.SIGKILL)
            _, status, usage = os.wait4(process.pid, 0)
        process.returncode = status  # it was waited for here, not by subprocess
        if stopping.is_set():
            raise Stopped  # whatever became of it says nothing about a mutant
        end_all(MARK, mark)
        text = report.read_bytes()[-LONGEST_OUTPUT:].decode("utf-8", "replace") if report.exists() else ""
    finally:
        end_below(folder)
        shutil.rmtree(folder, ignore_errors=True)
    timed_out |= os.WIFSIGNALED(status) and os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL)
    return status, timed_out, text, time.monotonic() - begun, usage.ru_utime + usage.ru_stime


def waited(process, deadline):
    """Status and use of a process that ends before the deadline; none otherwise. The pause is short beside any test."""
    while time.monotonic() < deadline:
        pid, status, usage = os.wait4(process.pid, os.WNOHANG)
        if pid:
            return status, usage
        time.sleep(0.02)
    return None, None
