#!/usr/bin/python3
"""What the random campaign draws in a small source, and what it leaves alone. No argument."""
import contextlib
import json
import pathlib
import subprocess
import sys
import tempfile

import random_campaign
from random_parts import build_tree, changes, equivalents, fleet_tests, measured, syntax, trial, weave

OPTIONS = ["-xc++", "-w", "-std=c++20"]
SOURCE = '''// a < b && c + 1 in a comment; note(4);
#include <array>
#include <string>
#define LIMIT (3 + 4)
static_assert(sizeof(int) >= 4 && true);
enum class Word { kOne = 1, kTwo = 2 };
void note(int count);
template <typename T, int N = 5>
struct Box {
  bool operator<(const Box& other) const { return value < other.value; }
  T value = 0;
};
double half(double x, int times = 7) { return x * 0.5; }
std::string twice(const std::string& text, char* p) {
  const std::string raw = R"(1 < 2 && 3)" + text;
  return text + " 2 < 3 \\" && " + '<' + raw + *(p + 1);
}
int count(Box<int, 6> box, const int* first, const int* last) {
  std::array<double, 8> a{};
  int sum[9] = {};
  note(10);
  auto&& all = a;
  for (int i = 11; i != 12; ++i) sum[i] += 13;
  switch (box.value) {
    case 14:
      return std::max(15, box->value);
    default:
      break;
  }
  if (const int n = 16; n > 17 || !first) return last - first;
  if (const int* q = first) return *q;
  while (first != last && true) ++first;
  return 1'000 << 18 & 0x1f;
}
'''.replace("box->value", "(&box)->value").replace("#include <string>", "#include <string>\n#include <algorithm>")
DRAWN = '''11 comparison < -> <=
12 number 0 -> 1
14 arithmetic * -> /
14 number 0.5 -> 0.6
17 arithmetic + -> -
17 number 1 -> 2
22 call note(10) -> nothing
22 number 10 -> 11
24 number 11 -> 12
24 comparison != -> ==
24 number 12 -> 13
24 arithmetic += -> -=
24 number 13 -> 14
27 extreme max -> min
27 number 15 -> 16
31 condition n > 17 || !first -> !(n > 17 || !first)
31 number 16 -> 17
31 comparison > -> >=
31 number 17 -> 18
31 logic || -> &&
31 not ! -> !!
33 condition first != last && true -> !(first != last && true)
33 comparison != -> ==
33 logic && -> ||
33 truth true -> false
34 number 1'000 -> 1001
34 number 18 -> 19
34 number 0x1f -> 0x20'''.split("\n")


JUDGE = syntax.Syntax()


def check_positions(folder):
    """The changes that clang confirms are those of the list: none in comments, texts, directives, templates, default
    arguments, enumerators, case labels, lengths of arrays, static_assert, sums of strings, differences of pointers."""
    path = folder / "small.cpp"
    path.write_text(SOURCE)
    found = [c for c in changes.changes_of("small.cpp", SOURCE) if JUDGE.accepts(c, str(path), OPTIONS)]
    assert not JUDGE.unreadable, JUDGE.unreadable
    drawn = [f"{c.line} {c.kind} {changes.shown(c)}" for c in found]
    assert drawn == DRAWN, "\n".join(sorted(set(drawn) ^ set(DRAWN)))
    for change in found:  # nothing but the place changes
        text = changes.changed(SOURCE, change)
        assert text[:change.begin] == SOURCE[:change.begin] and text.endswith(SOURCE[change.end:]), change
        assert text != SOURCE, change
    ids = [c.id for c in found]
    assert len(set(ids)) == len(ids), ids


WOVEN = """extern "C" int puts(const char*);
int half(int x) { return x / 2; }
int calls = 0;
void count() { ++calls; }
const int kThree = 3;
int main() {
  constexpr double kHalf = 0.5;
  int sum = 0;
  for (int i = 0; i < kThree; ++i) {
    count();
    if (i > 0 && !(half(i + 4) == 2)) sum += i;
  }
  return 10 * calls + sum + (kHalf < 0.55 ? 0 : 100);
}
"""


def check_woven(folder):
    """Woven into one program, each choice makes of it what the changed text is, and none leaves it as it was."""
    path = folder / "woven.cpp"
    path.write_text(WOVEN)
    found = [c for c in changes.changes_of("woven.cpp", WOVEN) if JUDGE.accepts(c, str(path), OPTIONS)]
    weaves = {i: JUDGE.weave(c, str(path), OPTIONS) for i, c in enumerate(found, 1)}
    assert all(weaves.values()), weaves
    kept = {c.old for c, w in zip(found, weaves.values()) if w.once}
    assert kept == {"0", "3", "0.5"}, kept  # of calls, kThree and kHalf: worked out once a process
    copy, control = folder / "copy.cpp", folder / "control"
    copy.write_text(weave.woven(WOVEN, weaves, path))
    parts = pathlib.Path(weave.__file__).parent
    subprocess.run(["c++", "-std=c++20", f"-I{parts.parents[2]}", f'-DTACTBENCH_MUTANT_CONTROL="{control}"', copy, parts / "woven_control.cpp", "-o",
                    folder / "woven"], check=True)

    def result_of(number):
        measured.choose(folder, number)
        return subprocess.run([folder / "woven"], check=False).returncode
    assert result_of(0) == 32, result_of(0)
    for number, change in enumerate(found, 1):
        plain = folder / f"plain{number}.cpp"
        plain.write_text(changes.changed(WOVEN, change))
        subprocess.run(["c++", "-std=c++20", plain, "-o", folder / "plain"], check=True)
        assert result_of(number) == subprocess.run([folder / "plain"], check=False).returncode, changes.shown(change)
    assert result_of(0) == 32
    missed = set(weaves) - measured.reached_since_chosen(folder)
    assert [found[number - 1].old for number in missed] == ["100"], missed  # which the condition before it leaves out
    measured.choose(folder, 0)
    assert not measured.reached_since_chosen(folder)


TESTS = """
set(python /usr/bin/python3 -c "exit(__import__('subprocess').call(__import__('sys').argv[1]) != 32)")
add_test("common starts" ${python} FOLDER/tactbench)
set_tests_properties("common starts" PROPERTIES LABELS fleet FIXTURES_SETUP common)
add_test("runs" ${python} FOLDER/tactbench)
add_test("skips" /bin/sh -c "exit 77" FOLDER/tactbench)
add_test("fails" /bin/false FOLDER/tactbench)
add_test("starts nothing" /bin/true)
set_tests_properties("runs" "skips" "fails" "starts nothing" PROPERTIES LABELS fleet FIXTURES_REQUIRED common)
add_test("of another label" ${python} FOLDER/tactbench)
"""


def check_fleet(folder):
    """Of the scripts those count that pass with the woven program; what they reach is known, and a mutant fails in them."""
    build = folder / "fleet"
    build.mkdir()
    (build / "CTestTestfile.cmake").write_text(TESTS.replace("FOLDER", str(build)))
    assert list(fleet_tests.scripts(build)) == ["runs", "skips", "fails", "starts nothing"], fleet_tests.scripts(build)
    said = []
    script, = fleet_tests.measured(build, folder / "woven", folder, said.append)
    assert ["left out" in line for line in said] == [False, True, True] and "skipped" in said[1], said
    assert script.name == "runs" and set(script.reached) == set(script.seconds) == {"runs"} and script.reached["runs"], script
    for number in (0, *script.reached["runs"]):
        measured.choose(folder, number)
        as_it_was = subprocess.call([folder / "woven"]) == 32
        assert as_it_was or number != 0
        outcome = script.run(lambda name: folder / "woven", ["runs"])
        assert (outcome.passed, outcome.failed, outcome.ran) == (as_it_was, [] if as_it_was else ["runs"], 1), number
    assert fleet_tests.may_tell("bench/cli/fleet/push.cpp") and not fleet_tests.may_tell("db/run_store.cpp")
    assert fleet_tests.scripts(folder / "no build folder") == {}


def build_folder(folder):
    """A build folder that knows one group of two sources of the room db, and a module, which is not the room's."""
    (folder / "db").mkdir()
    (folder / "build").mkdir()
    for name in ("one", "two"):
        (folder / "db" / f"{name}.cpp").write_text(SOURCE)
    (folder / "build" / "group.cpp").write_text('#include "db/one.cpp"\n#include "db/two.cpp"\n')
    (folder / "build" / "CMakeCache.txt").write_text(
        f"CMAKE_HOME_DIRECTORY:INTERNAL={folder}\nCMAKE_GENERATOR:INTERNAL=Ninja\n")
    (folder / "db" / "module.cpp").write_text(SOURCE)
    commands = []
    for target, source in (("tactbench_db", "build/group.cpp"), ("tactbench_module", "db/module.cpp")):
        out = f"CMakeFiles/{target}.dir/group.o"
        commands.append({"directory": f"{folder}/build", "file": f"{folder}/{source}",
                         "command": f"/usr/bin/c++ -I{folder} -O3 -g -std=c++20 -Werror -o {out} -c {folder}/{source}"})
    (folder / "build" / "compile_commands.json").write_text(json.dumps(commands))
    return build_tree.BuildTree(folder / "build")


def check_draw(tree):
    """One seed draws the same each time, another seed another thing; a longer draw begins with the shorter one."""
    assert tree.sources("db") == ["db/one.cpp", "db/two.cpp"]
    recipe = tree.recipes["db/one.cpp"]
    assert recipe.unit == ("db/one.cpp", "db/two.cpp")
    assert not {"-O3", "-g", "-Werror", "-o", "CMakeFiles/tactbench_db.dir/group.o"} & set(recipe.words), recipe.words
    def ids(seed):
        return [c.id for c in random_campaign.drawn(tree, JUDGE, "db", seed)]
    assert ids(1) == ids(1)
    assert ids(1) != ids(2)
    assert sorted(ids(1)) == sorted(ids(2))
    assert len(ids(1)) == 2 * len(DRAWN)
    assert random_campaign.by_id(tree, ids(1)[0]).id == ids(1)[0]


@contextlib.contextmanager
def refused(kind):
    try:
        yield
    except kind:
        return
    raise AssertionError(f"must be refused as {kind.__name__}")


def check_equivalents(tree, folder):
    """An entry is found by file, line and change, wherever the line stands; one that fits nothing is an error."""
    path = folder / "equivalents.json"
    change = next(c for c in changes.changes_of("db/one.cpp", SOURCE) if c.line == 17 and c.old == "1")
    entry = json.loads(equivalents.entry_of(change, SOURCE))
    path.write_text(json.dumps([{**entry, "reason": "as a test"}]))
    assert equivalents.reasons(path, tree.text) == {change.id: "as a test"}
    moved = equivalents.reasons(path, lambda source: "// one line more\n" + SOURCE)
    assert list(moved) == [change.id.replace(":17:", ":18:")], moved
    for wrong in ({"line": "return 3;"}, {"file": "db/none.cpp"}, {"change": "1 -> 7"}, {"reason": " "}, {"nth": 2},
                  {"line": "}"}):
        path.write_text(json.dumps([{**entry, "reason": "as a test", **wrong}]))
        with refused(equivalents.Wrong):
            equivalents.reasons(path, tree.text)


def check_kept():
    """Each change that is kept as equivalent still has its one place in the sources."""
    here = pathlib.Path(__file__).resolve().parent
    reasons = equivalents.reasons(here / "random_equivalents.json", lambda name: (here.parents[1] / name).read_text("latin-1"))
    assert reasons


def check_self_checks():
    """The function that a room's self-check breaks is in its source, once."""
    top = pathlib.Path(__file__).resolve().parents[2]
    assert set(trial.SELF_CHECKS) == set(build_tree.ROOMS)
    for room, (source, function) in trial.SELF_CHECKS.items():
        assert (top / source).read_text("utf-8").count(function) == 1, (room, source, function)


def check_table():
    """What is judged equivalent is not killable, and what did not build counts for nothing."""
    def result(state, reason=""):
        change = changes.Change("db/one.cpp", 0, 1, "number", "constant", "1", "2", 1, 1, 0)
        return random_campaign.Result(change, trial.Verdict(state, ""), reason)
    results = [result("killed")] * 3 + [result("survived")] + [result("survived", "why")] * 2 + [result("unbuilt")]
    assert random_campaign.figures(results) == (7, 6, 3, 1, 2, 0.75)
    assert "| db | 7 | 6 | 3 | 1 | 2 | 75 % |" in random_campaign.table(results, ["db"])


with tempfile.TemporaryDirectory(prefix="tactbench-mutants-") as name:
    check_positions(pathlib.Path(name))
    check_woven(pathlib.Path(name))
    check_fleet(pathlib.Path(name))
    built = build_folder(pathlib.Path(name))
    check_draw(built)
    check_equivalents(built, pathlib.Path(name))
    check_kept()
    check_self_checks()
    check_table()
sys.exit(0)
