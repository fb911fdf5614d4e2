"""quickstart_test.py QUICKSTART: what ./quickstart prints and how it ends, with stand-ins for apt, CMake and the program, which are
not what is tried here."""

import os
import pty
import re
import shutil
import subprocess
import sys
import tempfile

QUICKSTART = sys.argv[1]
STANDINS = {
    "sudo": 'exec "$@"',
    "dpkg-query": '[ "${@: -1}" = catch2 ] || [ -n "${ALL_MISSING:-}" ] && exit 1; echo "install ok installed"',
    "apt-get": 'for i in $(seq 200); do echo "Selecting package $i"; done; [ -z "${APT_FAILS:-}" ] || { echo "E: no network" >&2; exit 100; }',
    "cmake": """
case "$*" in
  *--build*)
    echo "$*" >>commands
    for i in 0 1 2 3 4 5 6 7 8; do echo "@$i@8@$((i * 10)).500@ Building CXX object $i.o"; done
    if [ -n "${COMPILER_FAILS:-}" ]; then echo "FAILED: 8.o"; echo "bench/x.cpp:3:1: error: no such thing"; exit 1; fi ;;
esac""",
    "ctest": 'echo "ctest $*"',
}


def written(path, text):
    with open(path, "w") as file:
        file.write("#!/bin/bash\n" + text + "\n")
    os.chmod(path, 0o755)


def run(*words, terminal=False, **more):
    environment = {**os.environ, "PATH": os.path.join(top, "bin") + ":" + os.environ["PATH"], "HOME": top, **more}
    if not terminal:
        done = subprocess.run([os.path.join(top, "clone/quickstart"), *words], env=environment, capture_output=True, text=True)
        return done.returncode, done.stdout, done.stderr
    ours, its = pty.openpty()
    process = subprocess.Popen([os.path.join(top, "clone/quickstart"), *words], env=environment, stdout=its, stderr=its)
    os.close(its)
    text = b""
    while True:
        try:
            part = os.read(ours, 65536)
        except OSError:  # its other end is closed
            break
        if not part:
            break
        text += part
    os.close(ours)
    return process.wait(), text.decode(), ""


top = tempfile.mkdtemp()
try:
    clone = os.path.join(top, "clone")
    os.makedirs(os.path.join(clone, "build"))
    os.mkdir(os.path.join(top, "bin"))
    shutil.copy(QUICKSTART, os.path.join(clone, "quickstart"))
    for name, text in STANDINS.items():
        written(os.path.join(top, "bin", name), text)
    written(os.path.join(clone, "build/tactbench"), 'echo "demo $*"; exit "${DEMO_CODE:-0}"')

    code, out, err = run()
    assert (code, err) == (0, ""), (code, err)
    assert "Installing" not in out and "Selecting" not in out, out
    assert re.search(r"^Compiling with \d+ at once: about \d+ minutes the first time", out, re.M), out
    percents = [int(number) for number in re.findall(r"^Compiling: (\d+) %, step", out, re.M)]
    assert percents == sorted(percents) and percents[0] == 0 and percents[-1] == 100 and len(percents) >= 5, out
    assert "step 4 of 8, 0:40" in out, out
    assert "@" not in out and "Building CXX" not in out, out
    assert "\ndemo demo\n" in out and "Open reports/run-1.html" in out, out
    assert len(re.findall(r"^  build/tactbench ", out[out.index("Open reports"):], re.M)) == 3, out

    code, out, _ = run("demo", "-q", DEMO_CODE="3")
    assert code == 3 and "demo demo -q" in out and "Open reports" not in out, (code, out)

    code, out, err = run(ALL_MISSING="1")
    assert code == 0 and re.search(r"^Installing \d+ Debian packages, about 1 minute: g\+\+ ", out, re.M), out
    assert "Selecting" not in out + err, out
    with open(os.path.join(clone, "build/quickstart.log")) as file:
        assert "Selecting package 200" in file.read()

    code, out, err = run(ALL_MISSING="1", APT_FAILS="1")
    assert code == 1 and "E: no network" in err and "build/quickstart.log" in err and err.count("\n") < 20, (code, err)
    assert "Compiling" not in out, out

    code, out, err = run(COMPILER_FAILS="1")
    assert code == 1 and "bench/x.cpp:3:1: error: no such thing" in out and "demo" not in out, (code, out)

    code, out, err = run("test", "-L", "unit")
    assert code == 0 and "Installing 1 Debian packages" in out and out.endswith("ctest --preset default -L unit\n"), out
    with open(os.path.join(clone, "commands")) as file:
        assert "--target tactbench" in file.readline()

    code, out, err = run(terminal=True)
    assert code == 0 and "\r\033[KCompiling: 50 %, step 4 of 8, 0:40" in out, out

    code, out, err = run("link")
    link = os.path.join(top, ".local/bin/tactbench")
    assert code == 0 and os.readlink(link) == os.path.join(clone, "build/tactbench") and "is not in PATH" in out, out
    os.remove(link)
    written(link, "true")
    code, out, err = run("link")
    assert code == 2 and "is no link" in err, (code, err)

    code, out, err = run("tset")
    assert code == 2 and "'tset' is not one of: demo" in err, (code, err)
finally:
    shutil.rmtree(top)
print("quickstart says what it does")
