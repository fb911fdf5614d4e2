"""Installs the build into an empty folder and uses what lies there: the program with its recipes, the library from
CMake, pkg-config and Python. Arguments: cmake, build folder."""

import os
import shutil
import subprocess
import sys
import tempfile

CMAKE, BUILD = sys.argv[1:]
HERE = os.path.dirname(os.path.abspath(__file__))
RUNTIME = tempfile.TemporaryDirectory()  # commands to other runs of this machine do not reach ours


def run(*words, folder, **environment):
    clean = {"PATH": os.environ["PATH"], "HOME": folder, "TACTBENCH_RUNTIME_DIR": RUNTIME.name, **environment}
    done = subprocess.run(words, cwd=folder, env=clean, capture_output=True, text=True, timeout=900)
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


def check_library(prefix, folder):
    source, build = os.path.join(HERE, "consumer"), os.path.join(folder, "consumer")
    run(CMAKE, "-S", source, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", folder=folder)
    run(CMAKE, "--build", build, folder=folder)
    assert run(os.path.join(build, "consumer"), folder=folder) == "20.000 1\n"
    assert run(os.path.join(build, "consumer_c"), folder=folder) == "1 1\n"
    lib = os.path.join(prefix, "lib")
    flags = run("pkg-config", "--cflags", "--libs", "tactbench-compensator", folder=folder,
                PKG_CONFIG_PATH=os.path.join(prefix, "share/pkgconfig")).split()
    run("cc", os.path.join(source, "main.c"), "-o", "by_pkg_config", *flags, folder=folder)
    assert run(os.path.join(folder, "by_pkg_config"), folder=folder, LD_LIBRARY_PATH=lib) == "1 1\n"
    python = ("from tactbench_compensator import Compensator, Taxel\n"
              "c = Compensator([0, 20, 40, 60], [Taxel([0, 1, 2, 3], [0, 1.5, 2.5, 3])], 5 / 65536, at_rest=True,\n"
              "               exact_outer=True)\n"
              "print('%.2f' % c.counts([13107]).pressure[0])")
    assert run("/usr/bin/python3", "-c", python, folder=folder, LD_LIBRARY_PATH=lib, PYTHONDONTWRITEBYTECODE="1",
               PYTHONPATH=os.path.join(prefix, "lib/python3/dist-packages")) == "20.00\n"
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
