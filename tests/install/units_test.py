"""The systemd units before systemd-analyze, the GitHub Actions example as YAML, and both against the program's own
words. Arguments: the program, folder of the files."""

import os
import re
import shutil
import subprocess
import sys
import tempfile

import yaml

PROGRAM, FOLDER = sys.argv[1:]


def text_of(name):
    with open(os.path.join(FOLDER, name)) as file:
        return file.read()


def check_options(command):
    """Every option of a command line in a file is one that the program has."""
    known = subprocess.run([PROGRAM, "nightly", "--help"], capture_output=True, text=True, check=True).stdout
    used = re.findall(r"(?<= )--[a-z-]+", command)
    assert used and all(re.search(rf"{option}\b", known) for option in used), used


def check_units():
    service = text_of("tactbench-nightly.service")
    start = re.search(r"^ExecStart=tactbench (.*)$", service, re.MULTILINE)
    check_options(start.group(1))
    for key in ("DynamicUser", "PrivateNetwork", "PrivateDevices", "NoNewPrivileges", "MemoryDenyWriteExecute"):
        assert f"\n{key}=yes\n" in service, key
    if not shutil.which("systemd-analyze"):
        return "systemd-analyze is not installed"
    with tempfile.TemporaryDirectory() as folder:
        # The program of this build in the place of the installed one, which systemd looks for on its own path.
        with open(os.path.join(folder, "tactbench-nightly.service"), "w") as file:
            file.write(service.replace("ExecStart=tactbench ", f"ExecStart={PROGRAM} "))
        shutil.copy(os.path.join(FOLDER, "tactbench-nightly.timer"), folder)
        units = [os.path.join(folder, f"tactbench-nightly.{kind}") for kind in ("service", "timer")]
        done = subprocess.run(["systemd-analyze", "verify", "--man=no", *units], capture_output=True, text=True)
        ours = [line for line in done.stderr.splitlines() if "tactbench" in line]
        assert done.returncode == 0 and not ours, done.stderr
    return "systemd-analyze is content"


def check_actions():
    workflow = yaml.safe_load(text_of("github-actions.example.yml"))
    steps = workflow["jobs"]["nightly"]["steps"]
    command = next(step["run"] for step in steps if "nightly nightly" in step.get("run", ""))
    check_options(command)
    junit = re.search(r"--junit (\S+)", command).group(1)
    published = [step for step in steps if junit in str(step.get("with", ""))]
    assert published and all(step["if"] == "always()" for step in published), "a red night is to be published, too"


note = check_units()
check_actions()
print(note)
