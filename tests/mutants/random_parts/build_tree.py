"""A build folder as the campaign uses it: how each source is compiled, which sources are compiled together with it, and how
the tests of its room are linked.

A source of a mutant is compiled alone and put first on the link line. Where the build compiles it in a group, one object of
the archive holds all sources of the group, and the compiler may have inlined the unchanged function into its neighbours.
So the neighbours are compiled alone, too, and stand beside the mutant: nothing asks for the archive's object any more, and
if anything did, its symbols would clash and the link would fail. No `-z muldefs`, which would hide just that.
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
# In the order in which they are tried. Tests of the label unit that start threads lie in an executable of their own.
STAGES = (("unit", "threads"), ("wire",), ("slow", "realtime"))
COMPILER = re.compile(r"(.*/)?(g\+\+|c\+\+|clang\+\+)(-\d+)?")
DROPPED = re.compile(r"-O.*|-g.*|-flto.*|-Werror.*|-MD|-MMD")
MEMORY_BYTES = 4 << 30  # of the compiler


class Unusable(Exception):
    """The build folder is not what the campaign needs; says what to do."""


@dataclasses.dataclass
class Recipe:
    """How a source is compiled."""
    words: list  # compiler and options, without source and output
    folder: str
    group: tuple  # the other sources of its object, relative to the source tree


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
    return [*options, "-O1", "-g0", "-w"], folder


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
        self.made = {}  # source -> lock of its unchanged object
        self.links = {}

    def read(self, entry):
        file = pathlib.Path(entry["directory"], entry["file"])
        parts = taken_apart(entry["command"], entry["directory"])
        if file.is_relative_to(self.folder):  # a group
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
            if source.split("/")[0] in ROOMS and source != "bench/main.cpp":
                others = tuple(s for s in sources if s != source)
                self.recipes.setdefault(source, Recipe(*parts, others))

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
        """Whether the compiler made `output` of the file `source`."""
        if test_runs.stopping.is_set():
            raise test_runs.Stopped
        line = [*(self.launcher if cached else []), *recipe.words, *words, "-c", str(source), "-o", str(output)]
        output.parent.mkdir(parents=True, exist_ok=True)
        done = subprocess.run(["prlimit", f"--as={MEMORY_BYTES}", "--cpu=300", *line], cwd=recipe.folder,
                              stdin=subprocess.DEVNULL, capture_output=True, check=False)
        return done.returncode == 0 and output.exists()

    def unchanged(self, source, scratch):
        """The object of a source as it is, compiled alone, once a campaign."""
        output = scratch / "objects" / (source + ".o")
        with self.lock:
            own = self.made.setdefault(source, threading.Lock())
        with own:
            recipe = self.recipes[source]
            if not output.exists() and not self.compile(recipe, self.source / source, output, cached=True):
                raise Unusable(f"{source} cannot be compiled alone with the options of {self.folder}")
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
