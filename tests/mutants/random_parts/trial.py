"""Tries the mutants of one room. All of them are woven into one set of executables (weave.py, woven_room.py), which are first
run without a mutant: so it is known which tests reach which place. A mutant is then tried against the tests that reach its
place, the quickest first, until one fails; no other test can tell it from the source.

A mutant counts as killed only when the test that failed does so again alone, and passes without the mutant in the same
executable. So neither a flaky test nor one that the way of building breaks can kill.
"""
import dataclasses

from . import build_tree, fleet_tests, woven_room
from .changes import changed

# For each room a function of internal linkage that its unit tests surely enter: its first statement becomes a throw. The
# room's results count only when that is killed.
SELF_CHECKS = {
    "analysis": ("analysis/statistics/control/control_band.cpp", "bool every_finite(std::span<const double> values) {"),
    "bench": ("bench/simulation/specimen_film.cpp", "int index_of(const SpecimenOptions& options, int row, int column) {"),
    "db": ("db/run_store.cpp", "SensorRecord sensor_of(const sqlite::Statement& row) {"),
    "devices": ("devices/force/rdt_record.cpp",
                "std::uint32_t get(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t size) {"),
    "sequences": ("sequences/compile.cpp", "double of_repeat(const std::vector<double>& values, int repeat) {"),
}


@dataclasses.dataclass
class Verdict:
    state: str  # killed, survived or unbuilt
    by: str  # the test, or how it died
    reached: int = 0  # tests that reach the place; of a survivor all of them were tried


class Room:
    def __init__(self, tree, name, scratch, say):
        self.tree, self.name, self.say = tree, name, say
        self.woven = woven_room.WovenRoom(tree, name, scratch, say)
        self.sound = {}  # (executable, test), for a mutant that is built alone its unit, too -> whether it passes unmutated
        tree.check_built(name)

    def build(self, changes, weaves, slot):
        """Weaves the changes in, and checks that mutants of the room run and are killed. `weaves`: id -> Weave or none."""
        source, function = SELF_CHECKS[self.name]
        if self.tree.text(source).count(function) != 1:
            raise build_tree.Unusable(f"{source} does not hold this once, which the self-check breaks: {function}")
        self.woven.build(changes, weaves, (source, function))
        verdict = self.try_subject(woven_room.Woven(self.woven, slot, woven_room.SELF_CHECK), build_tree.STAGES[:1])
        if verdict.state != "killed":
            raise build_tree.Unusable(f"{self.name}: a throw in {source} is not killed: the mutants do not run")

    def is_sound(self, subject, measured, test):
        """Whether a test passes without the mutant in an executable that is linked in the same way."""
        key = (subject.unit, measured.name, test)
        if key not in self.sound:
            self.sound[key] = subject.run_unmutated(measured, [test]).passed
            if not self.sound[key]:
                self.say(f"{measured.name}: fails without a mutant, too, and kills none: {test}")
        return self.sound[key]

    def killer(self, subject, measured, names):
        """What of the tests of these names kills the mutant; none when nothing does."""
        left = list(names)
        while left:
            outcome = subject.run(measured, left)
            if outcome.passed and outcome.ran == len(left):
                return None
            if outcome.passed:
                raise build_tree.Unusable(f"{measured.name} ran {outcome.ran} of {len(left)} tests that were named")
            if outcome.timed_out:
                return f"timeout in {outcome.failed[-1] if outcome.failed else measured.name}"
            if not outcome.failed:
                return f"{measured.name} died"
            test = outcome.failed[-1]
            again = not any(subject.run(measured, [test]).passed for _ in range(times_again(measured.name)))
            if again and self.is_sound(subject, measured, test):
                return test
            if test not in left:
                raise build_tree.Unusable(f"{measured.name} names a failed test that was not asked for: {test}")
            left.remove(test)
        return None

    def try_subject(self, subject, stages):
        """What becomes of a mutant that is built."""
        reached = 0
        for stage in stages:
            for measured in self.woven.executables(stage, subject.slot):
                names = subject.reaching(measured)
                reached += len(names)
                for batch in measured.batches(names):
                    by = self.killer(subject, measured, batch)
                    if by:
                        return Verdict("killed", by, reached)
        return Verdict("survived", "", reached)

    def try_change(self, change, slot, stages=build_tree.STAGES):
        if not fleet_tests.may_tell(change.file):
            stages = [stage for stage in stages if stage != build_tree.FLEET]
        number = self.woven.numbers.get(change.id)
        if number is not None:
            return self.try_subject(woven_room.Woven(self.woven, slot, number), stages)
        subject = woven_room.Alone(self.woven, slot, change.file)
        if not subject.build(changed(self.tree.text(change.file), change)):
            return Verdict("unbuilt", "")
        return self.try_subject(subject, stages)


def times_again(name):
    """Times that a test has to fail again. What waits on sockets or the real clock fails now and then on a busy machine alone."""
    return 1 if name.endswith(("_unit", "_threads")) else 4
