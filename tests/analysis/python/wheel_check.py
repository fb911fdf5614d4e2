"""wheel_check.py PROGRAM WHEEL OBJDUMP: the wheel in a clean environment without network: installed, used, taken away; and
what it asks of the system's libraries."""

import json
import os
import re
import subprocess
import sys
import tempfile
import zipfile

program, wheel, objdump = sys.argv[1:]
# What docs/python.md promises.
NEWEST = {"GLIBC": (2, 28), "GLIBCXX": (3, 4, 25), "CXXABI": (1, 3, 11), "GCC": (3, 0)}
LIBRARIES = {"libstdc++.so.6", "libm.so.6", "libgcc_s.so.1", "libc.so.6"}

USER = """
import array, sqlite3, sys
import tactbench
from tactbench import Compensator, MissingPackage, Store, VALID
assert sys.prefix in tactbench.__file__, tactbench.__file__
assert [run["recipes"] for run in Store("runs.db").runs()] == ["descending", "random-reversal"]
stream = Compensator.load("runs.db", 1, at_rest=True)
assert stream.about["model"] == "dynamic"
errors, before = [], None
for row in Store("runs.db").query("SELECT counts, scans, reference_psi, time_ns FROM frames WHERE frame > 2000000000 ORDER BY frame"):
    seconds = 0 if before is None else (row["time_ns"] - before) * 1e-9
    before = row["time_ns"]
    counts = array.array("H", row["counts"])
    size = len(counts) // row["scans"]
    frame = stream.volts([sum(counts[i::size]) / row["scans"] * stream.about["volts_per_count"] for i in range(size)], seconds)
    errors += [abs(psi - row["reference_psi"]) for psi, status in zip(frame.pressure, frame.status) if status & VALID]
try:
    Store("runs.db").frames(1)
except MissingPackage as error:
    assert "pip install xarray" in str(error), error
else:
    raise AssertionError("the environment is not clean")
print(len(errors), sum(errors) / len(errors))
"""


def run(*words, folder, **environment):
    clean = {"PATH": os.environ["PATH"], "HOME": folder, "TACTBENCH_RUNTIME_DIR": folder, **environment}
    done = subprocess.run(words, cwd=folder, env=clean, capture_output=True, text=True)
    assert done.returncode == 0, f"{words}: {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def check_symbols(folder):
    with zipfile.ZipFile(wheel) as archive:
        library = archive.extract("tactbench/libtactbench_compensator.so.1", folder)
    symbols = run(objdump, "-T", library, folder=folder)
    found = {}
    for name, version in re.findall(r"\b(GLIBC|GLIBCXX|CXXABI|GCC)_([0-9.]+)\b", symbols):
        found[name] = max(found.get(name, (0,)), tuple(map(int, version.split("."))))
    assert {"GLIBC", "GLIBCXX"} <= set(found), symbols
    for name, version in found.items():
        assert version <= NEWEST[name], f"{name}_{'.'.join(map(str, version))} is newer than the wheel promises"
    needed = set(re.findall(r"NEEDED\s+(\S+)", run(objdump, "-p", library, folder=folder)))
    assert needed <= LIBRARIES, needed
    ours = re.findall(r"^\S+ g\s.*\s(\S+)$", symbols, re.M)
    assert "tb_compensator_load" in ours and all(name.startswith("tb_") for name in ours), ours
    return found


def check_installed(folder):
    for words in (["init"], ["sensors", "add", "MY-1", "--type", "sensor.toml"],
                  ["run", "descending", "--bench", "bench.toml", "--sensor", "MY-1", "--operator", "test", "-q"],
                  ["run", "random-reversal", "--bench", "bench.toml", "--sensor", "MY-1", "--operator", "test", "-q", "--seed", "2"]):
        run(program, *words, folder=folder)
    run(program, "fit", "1", "-q", folder=folder)
    judged = json.loads(run(program, "judge", "1", "2", "--json", folder=folder))
    expected = next(of["mean_error_psi"] for of in judged["evaluations"] if of["run"] == 2)  # of the program's compensator
    run("/usr/bin/python3", "-m", "venv", "environment", folder=folder)
    pip = [os.path.join(folder, "environment/bin/python"), "-m", "pip", "--disable-pip-version-check"]
    run(*pip, "install", "--no-index", wheel, folder=folder)
    with open(os.path.join(folder, "user.py"), "w") as file:
        file.write(USER)
    count, error = run(os.path.join(folder, "environment/bin/python"), "-I", "user.py", folder=folder).split()
    assert int(count) > 100_000 and abs(float(error) - expected) < 0.02, (count, error, expected)
    run(*pip, "uninstall", "--yes", "tactbench", folder=folder)
    left = [path for path, _, files in os.walk(os.path.join(folder, "environment/lib")) if "/tactbench" in path and files]
    assert not left, left


with tempfile.TemporaryDirectory() as top:
    print("needs", {name: ".".join(map(str, version)) for name, version in check_symbols(top).items()})
    check_installed(top)
print("installed, used, taken away")
