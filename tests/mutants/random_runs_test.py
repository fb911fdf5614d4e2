#!/usr/bin/python3
"""How the random campaign runs the tests: within bounds, and each mutant as the one that was chosen. No argument."""
import pathlib
import sys
import tempfile

from random_parts import measured, test_runs, woven_room


def check_runs(folder):
    """Whatever runs on is ended in time; files, processes and temporary folders go with it."""
    script = folder / "endless"
    script.write_text("#!/bin/sh\nsetsid sleep 600 &\necho \"$TMPDIR $!\" > \"$0.said\"\nwhile :; do :; done\n")
    script.chmod(0o755)
    outcome = test_runs.run(script, [], test_runs.Limit(0.5, 600))  # by processor time, however long that takes on a busy machine
    assert outcome.timed_out and not outcome.passed and outcome.wall_s < 600, outcome
    temporary = pathlib.Path((folder / "endless.said").read_text().split()[0])
    assert temporary.name.startswith("tbm-") and not temporary.exists(), temporary
    left = [p for p in pathlib.Path("/proc").iterdir() if p.name.isdigit() and str(script).encode() in read(p / "cmdline")]
    assert not left, left
    report = ('<TestCase name="good &lt; one"><OverallResult success="true"/></TestCase>'
              '<TestCase name="bad, [one]"><OverallResult success="false"/></TestCase><TestCase name="last one">')
    assert test_runs.failed_tests(report, True) == ["bad, [one]", "last one"]
    assert test_runs.spec("bad, [one]") == '"bad\\, \\[one]"'


def read(path):
    try:
        return path.read_bytes()
    except OSError:
        return b""


class Linker:
    """Of a build folder what a slot asks for; each executable that it links fails as mutant 3 alone."""
    paths = None

    def runs_program(self, room):
        return False

    def compile(self, recipe, source, output, words):
        output.write_text("")
        self.control = words[0].split('"')[1]

    def link(self, target, objects, output):
        output.write_text(f'#!/bin/sh\ntest "$(od -An -td4 -N4 "{self.control}" | tr -d " ")" != 3\n')
        output.chmod(0o755)


def check_slots(folder):
    """A mutant is tried as itself, also as the first for which a slot links its executable."""
    room = woven_room.WovenRoom(Linker(), "db", folder, print)
    executable = measured.Measured("test_db_unit", 1.0, 1.0, {"one": 1.0}, {"one": {2, 3}}, set())
    for order in ((3, 2), (2, 3)):
        slot = folder / f"slot{order[0]}"
        slot.mkdir()
        for number in order:
            outcome = woven_room.Woven(room, slot, number).run(executable, ["one"])
            assert outcome.passed == (number != 3), (order, number)


with tempfile.TemporaryDirectory(prefix="tactbench-mutants-") as name:
    check_runs(pathlib.Path(name))
    check_slots(pathlib.Path(name))
sys.exit(0)
