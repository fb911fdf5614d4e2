"""The tests of the fleet as tests of a room. They are scripts that start a PostgreSQL and the program `tactbench`, which here is
the one with the mutants; each script is one test. Which places it reaches all its processes write into the shared file."""
import dataclasses
import json
import os
import subprocess

from . import test_runs
from .measured import Measured, choose, reached_since_chosen

SKIPPED = 77  # the exit code of a script that lacks what it needs: PostgreSQL, Slurm, root
ENVIRONMENT = {"PYTHONDONTWRITEBYTECODE": "1"}


def may_tell(file):
    """Whether these tests are tried against mutants of the source: the fleet's own alone, for they take long."""
    return "fleet" in file


def scripts(folder):
    """{name: command} of the fleet's tests of a build folder, without those that set a server up for others: a script starts
    one of its own where it finds none."""
    done = subprocess.run(["ctest", "--test-dir", folder, "--show-only=json-v1", "-L", "^fleet$"], capture_output=True, text=True,
                          check=False)
    known = json.loads(done.stdout)["tests"] if done.returncode == 0 else []
    fixtures = {"FIXTURES_SETUP", "FIXTURES_CLEANUP"}
    return {test["name"]: test["command"] for test in known
            if "command" in test and not fixtures & {p["name"] for p in test.get("properties", [])}}


@dataclasses.dataclass
class Script(Measured):
    """A script without a mutant: `name` and its one test are the ctest's name."""
    command: list  # with the build's program
    program: str  # of the build

    def run(self, linked, names):
        return run(self.name, self.command, self.program, linked("tactbench"), self.limit(names))


def run(name, command, program, woven_program, limit):
    command = [str(woven_program) if word == program else word for word in command]
    return test_runs.run_script(name, command, limit, ENVIRONMENT)


def measured(folder, woven_program, slot, say):
    """The scripts that start the program and pass without a mutant."""
    program, found = str(folder / "tactbench"), []
    for name, command in scripts(folder).items():
        if program not in command:
            continue
        choose(slot, 0)
        outcome = run(name, command, program, woven_program, test_runs.UNMUTATED)
        why = "" if outcome.passed else "; left out, for it is skipped here" if os.waitstatus_to_exitcode(outcome.code) == SKIPPED \
            else "; left out, for it fails without a mutant"
        say(f"{name} takes {outcome.wall_s:.1f} s, {outcome.cpu_s:.1f} s of them computing{why}")
        if outcome.passed:
            found.append(Script(name, outcome.wall_s, outcome.cpu_s, {name: outcome.wall_s}, {name: reached_since_chosen(slot)},
                                set(), command, program))
    return found
