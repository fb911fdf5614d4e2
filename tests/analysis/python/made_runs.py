"""Shared by the checks of the Python package: a folder of its own for runs that the program makes (PROGRAM LIBRARY)."""

import json
import os
import subprocess
import sys
import tempfile

program, library = sys.argv[1:]
folder = tempfile.mkdtemp()
os.environ.update(TACTBENCH_RUNTIME_DIR=folder, TACTBENCH_COMPENSATOR=library)
for name in ("TACTBENCH_BENCH", "TACTBENCH_DB"):
    os.environ.pop(name, None)  # the developer's

import tactbench  # noqa: E402


def call(*words, codes=(0,)):
    done = subprocess.run([program, *words], cwd=folder, capture_output=True, text=True)
    assert done.returncode in codes, f"{words}: {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def exported(run):
    """A run as the program writes it."""
    call("runs", "export", str(run), "--format", "json", "-o", f"{run}.json")
    with open(f"{run}.json") as file:
        return json.load(file)


def refused(word, act, kind=tactbench.TactbenchError):
    try:
        act()
    except kind as error:
        assert word in str(error), f"'{error}' does not say '{word}'"
        return
    raise AssertionError(f"not refused: {word}")
