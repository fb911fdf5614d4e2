"""The executables of a room's tests with all its mutants woven in, and what is known of their tests without one."""
import dataclasses
import pathlib
import re
import shutil
import threading

from . import build_tree, fleet_tests, test_runs, weave
from .measured import Measured, choose

HERE = pathlib.Path(__file__).resolve().parent
SELF_CHECK = 1  # number of the mutant that has to be killed
ERROR = re.compile(r"^(/[^:\n]*\.cpp):(\d+):(?:\d+:)? (?:fatal )?error", re.MULTILINE)
ATTEMPTS = 8  # to compile a unit, each without what failed
PROGRAM = "tactbench"


class WovenRoom:
    def __init__(self, tree, name, scratch, say):
        self.tree, self.name, self.scratch, self.say = tree, name, scratch, say
        self.program = tree.runs_program(name)
        self.folder = scratch / name
        self.lock = threading.Lock()
        self.objects = []
        self.numbers = {}  # id of a change -> its number in the executables
        self.once = set()  # numbers of what is worked out once a process
        self.measured = {}  # stage -> executables, the quickest first

    def build(self, changes, weaves, self_check):
        """Compiles each unit with the changes that can be woven in; `self_check` is (source, its function that shall throw)."""
        numbered = {}
        for number, change in enumerate(changes, SELF_CHECK + 1):
            if weaves.get(change.id):
                numbered.setdefault(self.tree.recipes[change.file].unit, {})[number] = weaves[change.id]
        numbered.setdefault(self.tree.recipes[self_check[0]].unit, {})
        for i, (unit, chosen) in enumerate(numbered.items()):
            output = self.folder / f"unit{i}.o"
            self.compile(unit, chosen, self_check, output)
            self.objects.append(output)
            for number, woven in chosen.items():
                self.numbers[woven.change.id] = number
                if woven.once:
                    self.once.add(number)
        alone = sum(change.id not in self.numbers for change in changes)
        self.say(f"{self.name}: {len(self.numbers)} mutants woven into {len(self.objects)} objects, {alone} to be built alone")

    def compile(self, unit, chosen, self_check, output):
        """Compiles a unit; takes out of `chosen` what cannot be woven."""
        for _ in range(ATTEMPTS):
            copies = {source: self.copy(source, chosen, self_check) for source in unit
                      if source == self_check[0] or any(w.change.file == source for w in chosen.values())}
            said = self.tree.compile_unit(unit, copies, output)
            if said is None:
                return
            if not chosen:
                break
            for number in self.at_fault(said, chosen):
                del chosen[number]
        raise build_tree.Unusable(f"{unit[0]} and its unit cannot be compiled with their mutants:\n{said[-2000:]}")

    def copy(self, source, chosen, self_check):
        """A copy of the source with its choices."""
        text, path = self.tree.text(source), self.tree.source / source
        while True:
            own = {number: w for number, w in chosen.items() if w.change.file == source}
            try:
                out = weave.woven(text, own, path)
                break
            except weave.Unwoven:  # found one by one: rare, and cheap to try
                for number, w in own.items():
                    if not weavable(text, {number: w}, path) or number == max(own):
                        del chosen[number]
                        break
        if source == self_check[0]:
            out = out.replace(self_check[1], f"{self_check[1]} if ({weave.ON}({SELF_CHECK})) throw 0;")
        file = self.folder / "copies" / source
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(out, "latin-1")
        return file

    def at_fault(self, said, chosen):
        """Numbers of the choices that the compiler's errors point at; of the whole source, when they stand elsewhere."""
        places = {(path, int(line)) for path, line in ERROR.findall(said)}
        files = {path for path, _ in places}
        def where(woven):
            return str(self.tree.source / woven.change.file)
        text = {w.change.file: self.tree.text(w.change.file) for w in chosen.values()}
        lines = {n: range(text[w.change.file].count("\n", 0, w.begin) + 1, text[w.change.file].count("\n", 0, w.end) + 2)
                 for n, w in chosen.items()}
        for guilty in ([n for n, w in chosen.items() if any((where(w), line) in places for line in lines[n])],
                       [n for n, w in chosen.items() if where(w) in files and w.constant >= 0],
                       [n for n, w in chosen.items() if where(w) in files]):
            if guilty:
                return guilty
        return list(chosen)

    def executables(self, stage, slot):
        """Measures the executables of a stage once, without a mutant."""
        with self.lock:
            if stage not in self.measured:
                found = [self.measure(name, slot) for name in self.tree.executables(self.name, stage)] \
                    if stage != build_tree.FLEET else \
                    fleet_tests.measured(self.tree.folder, self.linked(PROGRAM, slot), slot, self.say)
                self.measured[stage] = sorted(found, key=lambda m: m.wall_s)
                if not found and stage != build_tree.STAGES[1]:
                    self.say(f"{self.name}: no tests of the label {stage[0]} are built")
            return self.measured[stage]

    def measure(self, name, slot):
        executable = self.linked(name, slot)
        log = slot / "reached"
        log.unlink(missing_ok=True)
        choose(slot, 0)
        outcome = test_runs.run(executable, ["~[.]"], test_runs.UNMUTATED, {"TACTBENCH_MUTANTS_REACHED": str(log)})
        lines = [line.split("\t", 2) for line in log.read_text("utf-8").splitlines()] if log.exists() else []
        self.say(f"{self.name}: {name} takes {outcome.wall_s:.1f} s, {outcome.cpu_s:.1f} s of them computing" +
                 "".join(f"; left out, for it fails without a mutant: {test}" for test in outcome.failed))
        if not lines or (not outcome.passed and not outcome.failed):
            raise build_tree.Unusable(f"{name} fails without a mutant and names no test")
        numbers = [(float(seconds), {int(n) for n in ids.split(",") if n}, test) for seconds, ids, test in lines]
        kept = [entry for entry in numbers[1:] if entry[2] not in outcome.failed]
        return Measured(name, outcome.wall_s, outcome.cpu_s, {test: seconds for seconds, _, test in kept},
                        {test: ids for _, ids, test in kept}, numbers[0][1])

    def control(self, slot):
        """The object that tells a program its number, and the listener of tests, made once a slot."""
        recipe, control, listener = self.tree.paths, slot / "control.o", slot / "listener.o"
        if not listener.exists():
            for output, source in ((control, "woven_control.cpp"), (listener, "woven_listener.cpp")):
                words = [f'-DTACTBENCH_MUTANT_CONTROL="{slot / "control"}"']
                said = self.tree.compile(recipe, HERE / source, output, words)
                if said:
                    raise build_tree.Unusable(f"{source} cannot be compiled:\n{said[-2000:]}")
        return control, listener

    def linked(self, target, slot):
        """The woven executable, linked once a slot."""
        folder = slot / self.name
        if not (folder / target).exists():
            folder.mkdir(exist_ok=True)
            control, listener = self.control(slot)
            self.link(target, [*self.objects, control], [listener], folder)
        return folder / target

    def link(self, target, objects, more, folder):
        """Links an executable; where the tests start the program, a program of the same objects, too."""
        if (self.program or target == PROGRAM) and not (folder / PROGRAM).exists():
            self.tree.link(PROGRAM, objects, folder / PROGRAM)
            for module in self.tree.folder.glob("tactbench_*.so"):  # which it looks for beside itself
                (folder / module.name).symlink_to(module)
        if target != PROGRAM:
            more = [*more, self.paths(folder)] if self.program else more
            self.tree.link(target, [*objects, *more], folder / target)

    def paths(self, folder):
        """The object that tells the tests where the program lies: in `folder`."""
        output = folder / "paths.o"
        if not output.exists():
            recipe = self.tree.paths
            words = [w for w in recipe.words if not w.startswith("-DTACTBENCH_PROGRAM=")]
            words.append(f'-DTACTBENCH_PROGRAM="{folder / PROGRAM}"')
            source = self.tree.source / "tests/support/paths.cpp"
            if self.tree.compile(dataclasses.replace(recipe, words=words), source, output):
                raise build_tree.Unusable("tests/support/paths.cpp cannot be compiled")
        return output


def weavable(text, chosen, path):
    try:
        weave.woven(text, chosen, path)
    except weave.Unwoven:
        return False
    return True


class Woven:
    """A mutant of the woven executables."""
    unit = None

    def __init__(self, room, slot, number):
        self.room, self.slot, self.number = room, slot, number

    def reaching(self, measured):
        """Tests that could tell the mutant from the source. What was worked out once, before or in a test, all may see."""
        if self.number in self.room.once or self.number in measured.before:
            return list(measured.seconds)
        return [test for test, numbers in measured.reached.items() if self.number in numbers]

    def run(self, measured, names):
        choose(self.slot, self.number)
        try:
            return self.run_unmutated(measured, names)
        finally:
            choose(self.slot, 0)

    def run_unmutated(self, measured, names):
        """Outside of run(), where no mutant is chosen."""
        return measured.run(lambda name: self.room.linked(name, self.slot), names)


class Alone:
    """A mutant that cannot be chosen while a program runs: its unit is compiled with it. All tests of a stage are tried."""

    def __init__(self, room, slot, source):
        self.room, self.slot, self.source = room, slot, source
        self.unit = room.tree.recipes[source].unit

    def build(self, text):
        """Whether the text in the place of the source can be compiled."""
        for name in ("alone", "sound"):
            shutil.rmtree(self.slot / name, ignore_errors=True)
            (self.slot / name).mkdir()
        file = self.slot / "alone" / "mutant.cpp"
        file.write_text(f'#line 1 "{self.room.tree.source / self.source}"\n{text}', "latin-1")
        return self.room.tree.compile_unit(self.unit, {self.source: file}, self.slot / "alone" / "unit.o") is None

    def reaching(self, measured):
        return list(measured.seconds)

    def run_of(self, folder, unit_object, measured, names):
        def linked(name):
            if not (folder / name).exists():
                self.room.link(name, [unit_object()], [], folder)
            return folder / name
        return measured.run(linked, names)

    def run(self, measured, names):
        return self.run_of(self.slot / "alone", lambda: self.slot / "alone" / "unit.o", measured, names)

    def run_unmutated(self, measured, names):
        return self.run_of(self.slot / "sound", lambda: self.room.tree.unchanged(self.unit, self.room.scratch), measured, names)
