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
    known = "".join(subprocess.run([PROGRAM, *verb, "--help"], capture_output=True, text=True, check=True).stdout for verb in (["nightly"], []))
    used = re.findall(r"(?<= )--[a-z-]+", command)
    assert used and all(re.search(rf"{option}\b", known) for option in used), used


def check_units():
    service = text_of("tactbench-nightly.service")
    start = re.search(r"^ExecStart=tactbench (.*)$", service, re.MULTILINE)
    check_options(start.group(1))
    for key in ("DynamicUser", "PrivateNetwork", "PrivateDevices", "NoNewPrivileges", "MemoryDenyWriteExecute"):
        assert f"\n{key}=yes\n" in service, key
    assert "\nUMask=0077\n" in service
    # What others are to read lies where they can: below /run, which stays, and not in the state of a dynamic user.
    metrics = re.search(r"--metrics (\S+)", start.group(1)).group(1)
    assert metrics == "%t/tactbench-nightly/night.prom" and f"\nExecStopPost=-chmod 0644 {metrics}\n" in service
    assert "\nRuntimeDirectory=tactbench-nightly\nRuntimeDirectoryPreserve=yes\n" in service
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


def check_rules():
    """No rule of udev opens whatever a maker of chips has made: each names one device."""
    with open(os.path.join(FOLDER, "../config/70-tactbench.rules")) as file:
        rules = [line for line in file if line.strip() and line[0] != "#" and "uaccess" in line]
    assert len(rules) == 2, rules
    for rule in rules:
        assert 'ATTRS{idProduct}=="' in rule or 'ATTRS{serial}=="' in rule, rule


def check_actions():
    workflow = yaml.safe_load(text_of("github-actions.example.yml"))
    steps = workflow["jobs"]["nightly"]["steps"]
    command = next(step["run"] for step in steps if "nightly nightly" in step.get("run", ""))
    check_options(command)
    junit = re.search(r"--junit (\S+)", command).group(1)
    published = [step for step in steps if junit in str(step.get("with", ""))]
    assert published and all(step["if"] == "always()" for step in published), "a red night is to be published, too"
    assert set(workflow["permissions"].values()) == {"read"}, workflow["permissions"]
    for step in steps:
        assert re.fullmatch(r"actions/[\w-]+@[0-9a-f]{40}", step.get("uses", "actions/x@" + 40 * "0")), step


note = check_units()
check_rules()
check_actions()
print(note)
