"""Installs the build into an empty folder and uses what lies there: the program with its recipes, the library from
CMake, pkg-config and Python. Arguments: cmake, build folder."""

import json
import os
import shutil
import subprocess
import sys
import tempfile

CMAKE, BUILD = sys.argv[1:]
HERE = os.path.dirname(os.path.abspath(__file__))
RUNTIME = tempfile.TemporaryDirectory()  # commands to other runs of this machine do not reach ours


# A taxel of ELAM on straight lines.
MODEL = {"schema": "tactbench.model", "version": 1, "output": {"falling": False, "scans": 1}, "sensor": {"rows": 1, "columns": 1},
         "taxels": [{"taxel": 0, "status": "fitted", "zero": 0, "gain": 1, "noise": 0.001, "loop_low": 0, "figures": {"full_scale": 3},
                     "model": {"model": "elam", "x": [0, 20, 40, 60], "ascending": [0, 1, 2, 3], "descending": [0, 1, 2, 3],
                               "parameters": {"alpha_d": 0.5, "beta_d": 0.5, "alpha_a1": 0, "alpha_a0": 0.5, "beta_a": 0.5},
                               "options": {"memory": False, "exact_outer": True, "splits": 1}}}]}


def run(*words, folder, given=None, **environment):
    clean = {"PATH": os.environ["PATH"], "HOME": folder, "TACTBENCH_RUNTIME_DIR": RUNTIME.name, **environment}
    done = subprocess.run(words, cwd=folder, env=clean, input=given, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, f"{words}: {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def check_files(prefix):
    for name in ("bin/tactbench", "share/tactbench/sequences/nightly.toml", "share/tactbench/bench/config/limits.toml",
                 "share/tactbench/devices/profiles/generic.toml", "lib/libtactbench_compensator.a",
                 "lib/libtactbench_compensator.so.1", "include/tactbench/analysis/compensate/compensator_c.h",
                 "lib/cmake/tactbench/tactbench-config.cmake", "share/pkgconfig/tactbench-compensator.pc",
                 "lib/python3/dist-packages/tactbench_compensator.py", "lib/python3/dist-packages/tactbench/store.py",
                 "lib/udev/rules.d/70-tactbench.rules",
                 "lib/systemd/system/tactbench-nightly.service", "lib/systemd/system/tactbench-nightly.timer",
                 "lib/sysusers.d/tactbench.conf", "lib/tmpfiles.d/tactbench.conf",
                 "share/man/man1/tactbench.1.gz", "share/bash-completion/completions/tactbench",
                 "share/doc/tactbench/LICENSE"):
        assert os.path.getsize(os.path.join(prefix, name)) > 0, name


def check_program(prefix, folder):
    """A recipe changed in the installed folder changes the plan: it is that folder that the program reads."""
    program = os.path.join(prefix, "bin/tactbench")
    recipe = os.path.join(prefix, "share/tactbench/sequences/production.toml")
    run(program, "plan", "production", folder=folder)
    with open(recipe) as file:
        text = file.read()
    with open(recipe, "w") as file:
        file.write(text + "\nbroken_by_the_test = 1\n")
    broken = subprocess.run([program, "plan", "production"], cwd=folder, capture_output=True, text=True)
    assert broken.returncode == 2 and recipe in broken.stderr and "broken_by_the_test" in broken.stderr, broken.stderr
    with open(recipe, "w") as file:
        file.write(text)
    run(program, "init", folder=folder)
    run(program, "sensors", "add", "S-1", "--type", "sensor.toml", folder=folder)
    done = run(program, "run", "zero-check", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "test", "-q",
               folder=folder)
    assert "run 1: completed, 60 frames" in done, done
    assert "verified" in run(program, "verify", "1", folder=folder)


def check_frames(program, folder, **environment):
    lines = run(program, "model.json", folder=folder, given="0 1.0\n0.1 2.0\n0.1 1.5\n0.1 9.0\n", **environment).splitlines()
    frames = [line.split() for line in lines]
    assert [(float(psi), int(status)) for psi, _, status in frames] == [(20, 1), (40, 1), (30, 1), (30, 4)], lines


def check_library(prefix, folder):
    source, build = os.path.join(HERE, "consumer"), os.path.join(folder, "consumer")
    run(CMAKE, "-S", source, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", folder=folder)
    run(CMAKE, "--build", build, folder=folder)
    with open(os.path.join(folder, "model.json"), "w") as file:
        json.dump(MODEL, file)
    for program in ("consumer", "consumer_c"):
        check_frames(os.path.join(build, program), folder)
    lib = os.path.join(prefix, "lib")
    flags = run("pkg-config", "--cflags", "--libs", "tactbench-compensator", folder=folder,
                PKG_CONFIG_PATH=os.path.join(prefix, "share/pkgconfig")).split()
    run("cc", "-std=c99", "-pedantic-errors", "-Wall", "-Wextra", "-Werror", os.path.join(source, "main.c"), "-o", "by_pkg_config",
        *flags, folder=folder)
    check_frames(os.path.join(folder, "by_pkg_config"), folder, LD_LIBRARY_PATH=lib)
    python = ("from tactbench_compensator import Compensator\n"
              "c = Compensator(open('model.json').read(), at_rest=True)\n"
              "print('%.2f %d' % (c.volts([1.0]).pressure[0], c.volts([3.0], 0.1).status[0]))")
    assert run("/usr/bin/python3", "-c", python, folder=folder, LD_LIBRARY_PATH=lib, PYTHONDONTWRITEBYTECODE="1",
               PYTHONPATH=os.path.join(prefix, "lib/python3/dist-packages")) == "20.00 1\n"
    python = "from tactbench import Compensator, Store; print(len(Store('runs.db').runs()), Compensator.load.__name__)"
    assert run("/usr/bin/python3", "-c", python, folder=folder, LD_LIBRARY_PATH=lib, PYTHONDONTWRITEBYTECODE="1",
               PYTHONPATH=os.path.join(prefix, "lib/python3/dist-packages")) == "1 load\n"


with tempfile.TemporaryDirectory() as top:
    prefix, folder = os.path.join(top, "prefix"), os.path.join(top, "elsewhere")
    os.mkdir(folder)
    run(CMAKE, "--install", BUILD, "--prefix", prefix, folder=folder)
    check_files(prefix)
    check_program(prefix, folder)
    check_library(prefix, folder)
    moved = os.path.join(top, "moved")  # nothing in it knows where it was installed
    shutil.move(prefix, moved)
    run(os.path.join(moved, "bin/tactbench"), "plan", "ring", folder=folder)
print("installed, used, moved")
