"""A build folder as the campaign uses it: how each source is compiled, which sources are compiled together with it, and how
the tests of its room are linked.

A source with mutants is compiled in place of its own and put first on the link line. Where the build compiles it in a batch,
the whole batch is compiled again with it, for one object of the archive holds them all, and the compiler may have inlined the
unchanged function into its neighbours. So nothing asks for the archive's object any more, and if anything did, its symbols
would clash and the link would fail. No `-z muldefs`, which would hide just that.
"""
import dataclasses
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import threading

from . import test_runs

ROOMS = ("analysis", "bench", "db", "devices", "sequences")
# What tests link: neither the program's main.cpp nor a module that is loaded when it is asked for.
ROOM_TARGETS = ("tactbench_compensator_objects", *(f"tactbench_{room}{part}" for room in ROOMS for part in ("", "_computing")))
# In the order in which they are tried. Tests of the label unit that start threads lie in an executable of their own. Those of
# the label fleet are scripts, and of all rooms.
FLEET = ("fleet",)
STAGES = (("unit", "threads"), ("wire",), ("slow", "realtime"), FLEET)
COMPILER = re.compile(r"(.*/)?(g\+\+|c\+\+|clang\+\+)(-\d+)?")
DROPPED = re.compile(r"-O.*|-g.*|-flto.*|-Werror.*|-MD|-MMD")
COMPUTING = ("analysis/", "bench/simulation/")  # whose tests would take long without optimization
MEMORY_BYTES = 4 << 30  # of the compiler


class Unusable(Exception):
    """The build folder is not what the campaign needs; says what to do."""


@dataclasses.dataclass
class Recipe:
    """How a source is compiled."""
    words: list  # compiler and options, without source and output
    folder: str
    unit: tuple  # the sources of its object in their order, relative to the source tree


def taken_apart(command, folder):
    words = shlex.split(command)
    first = next(i for i, word in enumerate(words) if COMPILER.fullmatch(word))
    options, skip = [], False
    for word in words[first:]:
        if skip:
            skip = False
        elif word in ("-o", "-c", "-MF", "-MT"):
            skip = True
        elif not DROPPED.fullmatch(word):
            options.append(word)
    return [*options, "-g0", "-w"], folder


class BuildTree:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder).resolve()
        try:
            commands = json.loads((self.folder / "compile_commands.json").read_text())
            cache = (self.folder / "CMakeCache.txt").read_text()
        except OSError as error:
            raise Unusable(f"{folder} is no configured build folder: {error}") from error
        self.source = pathlib.Path(re.search(r"^CMAKE_HOME_DIRECTORY:INTERNAL=(.*)$", cache, re.MULTILINE).group(1))
        if "CMAKE_GENERATOR:INTERNAL=Ninja" not in cache:
            raise Unusable(f"{folder} was not made by the generator Ninja: cmake --preset default")
        self.recipes = {}
        self.paths = None  # how tests/support/paths.cpp is compiled, which knows where the program lies
        for entry in commands:
            self.read(entry)
        cache_words = ["env", f"CCACHE_BASEDIR={self.source}", "CCACHE_NOHASHDIR=1", "ccache"]
        self.launcher = cache_words if shutil.which("ccache") else []
        self.linker = ["-fuse-ld=lld", "-Wl,--threads=1"] if shutil.which("ld.lld") else []
        self.lock = threading.Lock()
        self.made = {}  # unit -> lock of its unchanged object
        self.links = {}

    def read(self, entry):
        file = pathlib.Path(entry["directory"], entry["file"])
        parts = taken_apart(entry["command"], entry["directory"])
        target = re.search(r" -o \S*CMakeFiles/(\w+)\.dir/", entry["command"])
        of_a_room = target and target.group(1) in ROOM_TARGETS
        if file.is_relative_to(self.folder):  # a batch of sources
            if not file.exists():
                return
            included = re.findall(r'^#include "(.*\.cpp)"', file.read_text(), re.MULTILINE)
            sources = [os.path.relpath(self.source / s, self.source) for s in included]
        elif file.is_relative_to(self.source):
            sources = [str(file.relative_to(self.source))]
        else:
            return
        if sources == ["tests/support/paths.cpp"]:
            self.paths = Recipe(*parts, ())
        for source in sources:
            if of_a_room and source.split("/")[0] in ROOMS:
                self.recipes.setdefault(source, Recipe(*parts, tuple(sources)))

    def sources(self, room):
        return sorted(s for s in self.recipes if s.startswith(room + "/"))

    def text(self, source):
        return (self.source / source).read_text("latin-1")

    def link_words(self, target):
        """The link line of an executable; none when the build knows no such target."""
        with self.lock:
            if target not in self.links:
                done = subprocess.run(["ninja", "-C", self.folder, "-t", "commands", target], capture_output=True, text=True,
                                      check=False)
                steps = [s.strip() for line in re.findall(rf"^.* -o (?:\S*/)?{target} .*$", done.stdout, re.MULTILINE)
                         for s in line.split(" && ") if COMPILER.match(s.strip())]
                self.links[target] = shlex.split(steps[-1]) if steps else None
            return self.links[target]

    def executables(self, room, stage):
        """Names of the room's built executables of a stage."""
        names = [f"test_{room}_{kind}" for kind in stage]
        return [name for name in names if self.link_words(name) and self.output(name).exists()]

    def output(self, target):
        words = self.link_words(target)
        return self.folder / words[words.index("-o") + 1]

    def check_built(self, room):
        """Fails when the tests of the room are not built, or a source is newer than they."""
        names = [n for stage in STAGES[:2] for n in self.executables(room, stage)]
        wanted = f"cmake --build {self.folder} --target test_{room}_unit (and test_{room}_wire, where there is one)"
        if f"test_{room}_unit" not in names:
            raise Unusable(f"{room}: its tests are not built: {wanted}")
        built = min(self.output(n).stat().st_mtime for n in names)
        for r in ROOMS:
            for path in (self.source / r).rglob("*"):
                if path.suffix in (".h", ".cpp") and path.stat().st_mtime > built and self.needed(path, room):
                    raise Unusable(f"{path.relative_to(self.source)} is newer than the tests of {room}: {wanted}")

    def needed(self, path, room):
        """Headers, and the sources that the rooms are built of."""
        return path.suffix == ".h" or str(path.relative_to(self.source)) in self.recipes

    def runs_program(self, room):
        """Whether tests of the room start the program itself, which then has to hold the mutant, too."""
        if self.paths is None:
            return False
        texts = [p.read_text("utf-8") for p in (self.source / "tests" / room).rglob("*.cpp")]
        return room == "bench" or any("program_path()" in text for text in texts)

    def compile(self, recipe, source, output, words=(), cached=False):
        """What the compiler said of the file `source` when it made no `output`; none when it did."""
        if test_runs.stopping.is_set():
            raise test_runs.Stopped
        line = [*(self.launcher if cached else []), *recipe.words, *words, "-c", str(source), "-o", str(output)]
        output.parent.mkdir(parents=True, exist_ok=True)
        output.unlink(missing_ok=True)
        done = subprocess.run(["prlimit", f"--as={MEMORY_BYTES}", "--cpu=600", *line], cwd=recipe.folder,
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", check=False)
        return None if done.returncode == 0 and output.exists() else done.stderr or "the compiler was ended"

    def compile_unit(self, unit, copies, output):
        """Compiles the sources of an object, with copies {source: file} in the place of some; says what compile() does. The
        standard library's assertions show a step beyond an array, as the sanitizers of CI do."""
        output.parent.mkdir(parents=True, exist_ok=True)
        file = output.with_suffix(".cpp")
        file.write_text("".join(f'#include "{copies.get(s, self.source / s)}"\n' for s in unit), "utf-8")
        folders = dict.fromkeys(str((self.source / s).parent) for s in unit)
        words = [w for folder in folders for w in ("-iquote", folder)]
        level = "-O1" if unit[0].startswith(COMPUTING) else "-O0"
        return self.compile(self.recipes[unit[0]], file, output, [*words, level, "-D_GLIBCXX_ASSERTIONS"], cached=not copies)

    def unchanged(self, unit, scratch):
        """The object of an unchanged unit, compiled as one with a mutant is, once a campaign."""
        output = scratch / "objects" / (unit[0] + ".o")
        with self.lock:
            own = self.made.setdefault(unit, threading.Lock())
        with own:
            said = None if output.exists() else self.compile_unit(unit, {}, output)
            if said:
                raise Unusable(f"{unit[0]} cannot be compiled with the options of {self.folder}:\n{said[-2000:]}")
        return output

    def link(self, target, objects, output):
        """Links an executable with `objects` in the place of the archives' copies."""
        words = list(self.link_words(target))
        words[words.index("-o") + 1] = str(output)
        first = next(i for i, word in enumerate(words) if word.endswith((".o", ".a")))
        words[first:first] = [str(o) for o in objects]
        done = subprocess.run([*words, *self.linker, "-Wl,-s"], cwd=self.folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise Unusable(f"{target} cannot be linked with {', '.join(map(str, objects))}:\n{done.stderr[-2000:]}")
