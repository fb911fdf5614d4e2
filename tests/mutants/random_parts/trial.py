"""Tries mutants of one room: links the room's tests with the mutant and runs them, the quickest first, until one fails.

A mutant counts as killed only when the test that failed does so again alone, and passes with the unchanged source compiled
and linked the same way. So neither a flaky test nor one that the way of building breaks can kill.
"""
import dataclasses
import threading

from . import build_tree, test_runs
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

# Times that a test has to fail again. What waits on sockets or the real clock fails now and then on a busy machine alone.
AGAIN, AGAIN_WITH_WAITS = 1, 4


@dataclasses.dataclass
class Verdict:
    state: str  # killed, survived or unbuilt
    by: str  # the test, or how it died
    seconds: float = 0.0


@dataclasses.dataclass
class Measured:
    """An executable of tests without a mutant."""
    name: str
    limit: test_runs.Limit
    wall_s: float
    broken: tuple  # tests that fail without a mutant: left out


class Room:
    def __init__(self, tree, name, scratch, say):
        self.tree, self.name, self.scratch, self.say = tree, name, scratch, say
        self.program = tree.runs_program(name)
        self.lock = threading.Lock()
        self.measured = {}  # stage -> executables, the quickest first
        self.sound = {}  # (group, executable, test) -> whether it passes unmutated
        tree.check_built(name)

    def object_of(self, text, source, folder):
        """The object of a source with another text; none when it does not build."""
        original = self.tree.source / source
        file = folder / "mutant.cpp"
        file.write_text(f'#line 1 "{original}"\n{text}', "latin-1")
        output = folder / "mutant.o"
        output.unlink(missing_ok=True)
        # The assertions show a step beyond an array, as the sanitizers of CI do.
        words = ["-iquote", original.parent, "-D_GLIBCXX_ASSERTIONS"]
        return output if self.tree.compile(self.tree.recipes[source], file, output, words) else None

    def neighbours(self, source):
        return [self.tree.unchanged(s, self.scratch) for s in self.tree.recipes[source].group]

    def linked(self, target, objects, folder):
        """The executable with these objects; where the tests start the program, with a program of the same."""
        if self.program:
            self.tree.link("tactbench", objects, folder / "tactbench")
            objects = [*objects, self.paths(folder)]
        output = folder / target
        self.tree.link(target, objects, output)
        return output

    def paths(self, folder):
        """The object that tells the tests where the program lies: in `folder`."""
        output = folder / "paths.o"
        if not output.exists():
            recipe = self.tree.paths
            words = [w for w in recipe.words if not w.startswith("-DTACTBENCH_PROGRAM=")]
            words.append(f'-DTACTBENCH_PROGRAM="{folder / "tactbench"}"')
            source = self.tree.source / "tests/support/paths.cpp"
            if not self.tree.compile(dataclasses.replace(recipe, words=words), source, output):
                raise build_tree.Unusable("tests/support/paths.cpp cannot be compiled")
        return output

    def executables(self, stage, folder):
        """Measures the executables of a stage once, without a mutant, linked as with one."""
        with self.lock:
            if stage not in self.measured:
                source = SELF_CHECKS[self.name][0]
                objects = [self.tree.unchanged(source, self.scratch), *self.neighbours(source)]
                found = [self.measure(name, objects, folder) for name in self.tree.executables(self.name, stage)]
                self.measured[stage] = sorted(found, key=lambda m: m.wall_s)
                if not found and stage != build_tree.STAGES[1]:
                    self.say(f"{self.name}: no tests of the label {stage[0]} are built")
            return self.measured[stage]

    def measure(self, name, objects, folder):
        executable = self.linked(name, objects, folder)
        outcome = test_runs.run(executable, ["~[.]"], test_runs.UNMUTATED)
        executable.unlink()
        self.say(f"{self.name}: {name} takes {outcome.wall_s:.1f} s, {outcome.cpu_s:.1f} s of them computing" +
                 "".join(f"; left out, for it fails without a mutant: {test}" for test in outcome.failed))
        if not outcome.passed and not outcome.failed:
            raise build_tree.Unusable(f"{name} fails without a mutant and names no test")
        return Measured(name, outcome.limit(), outcome.wall_s, tuple(outcome.failed))

    def is_sound(self, source, measured, test, folder):
        """Whether a test passes with the unchanged source linked in the mutant's way."""
        key = (frozenset((source, *self.tree.recipes[source].group)), measured.name, test)
        if key not in self.sound:
            objects = [self.tree.unchanged(source, self.scratch), *self.neighbours(source)]
            executable = self.linked(measured.name, objects, folder)
            self.sound[key] = test_runs.run(executable, [test_runs.spec(test)], measured.limit).passed
            executable.unlink()
            if not self.sound[key]:
                self.say(f"{measured.name}: fails without a mutant, too, and kills none in {source}: {test}")
        return self.sound[key]

    def killer(self, source, measured, objects, folder):
        """What kills the mutant in one executable; none when nothing does."""
        executable = self.linked(measured.name, objects, folder)
        without = list(measured.broken)
        try:
            while True:
                words = ["-a", "~[.]", *("~" + test_runs.spec(test) for test in without)]
                outcome = test_runs.run(executable, words, measured.limit)
                if outcome.passed:
                    return None
                if outcome.timed_out:
                    return f"timeout in {outcome.failed[-1] if outcome.failed else measured.name}"
                if not outcome.failed:
                    return f"{measured.name} died"
                test = outcome.failed[-1]
                times = AGAIN if measured.name.endswith("_unit") else AGAIN_WITH_WAITS
                again = not any(test_runs.run(executable, [test_runs.spec(test)], measured.limit).passed
                                for _ in range(times))
                executable.unlink()
                if again and self.is_sound(source, measured, test, folder):
                    return test
                without.append(test)
                executable = self.linked(measured.name, objects, folder)
        finally:
            executable.unlink(missing_ok=True)

    def try_text(self, source, text, folder, stages):
        """What becomes of a text in the place of the source."""
        own = self.object_of(text, source, folder)
        if own is None:
            return Verdict("unbuilt", "")
        objects = [own, *self.neighbours(source)]
        for stage in stages:
            for measured in self.executables(stage, folder):
                by = self.killer(source, measured, objects, folder)
                if by:
                    return Verdict("killed", by)
        return Verdict("survived", "")

    def try_change(self, change, folder, stages=build_tree.STAGES):
        return self.try_text(change.file, changed(self.tree.text(change.file), change), folder, stages)

    def self_check(self, folder):
        """Fails unless a mutant that throws where the tests surely go is killed."""
        source, function = SELF_CHECKS[self.name]
        text = self.tree.text(source)
        if text.count(function) != 1:
            raise build_tree.Unusable(f"{source} does not hold this once, which the self-check breaks: {function}")
        verdict = self.try_text(source, text.replace(function, function + " throw 0;"), folder, build_tree.STAGES[:1])
        if verdict.state != "killed":
            raise build_tree.Unusable(f"{self.name}: a throw in {source} is not killed: the mutants do not run")
