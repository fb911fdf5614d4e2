"""What the build promises about compiling again: tests change no product source's command, another checkout compiles the
same, and a new file changes one group.

    build_test.py CMAKE SOURCE
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

CMAKE, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])


def copy_of_sources(to):
    listed = subprocess.run(["git", "-C", SOURCE, "ls-files", "-z"], check=True, capture_output=True, text=True).stdout
    for name in filter(None, listed.split("\0")):
        if (SOURCE / name).is_file():
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(SOURCE / name, to / name)
    return to


def configured(checkout, testing):
    """Compile commands by object, with the checkout's own path as ROOT, and the groups' text by name; the product's alone."""
    subprocess.run([CMAKE, "--preset", "default", f"-DBUILD_TESTING={testing}"], cwd=checkout, check=True,
                   stdout=subprocess.DEVNULL)
    commands = {}
    for entry in json.loads((checkout / "build/compile_commands.json").read_text()):
        words = entry["command"].split()
        made = words[words.index("-o") + 1]
        if not made.startswith("tests/"):
            commands[made] = entry["command"].replace(str(checkout), "ROOT")
    groups = {path.name: path.read_text() for path in (checkout / "build/groups").iterdir() if "_tests_" not in path.name}
    return commands, groups


def main():
    with tempfile.TemporaryDirectory(prefix="tactbench-build-") as folder:
        first = copy_of_sources(pathlib.Path(folder) / "first")
        alone, groups = configured(first, "OFF")
        tested, groups_tested = configured(first, "ON")
        assert len(alone) > 20, "hardly any product source is compiled"
        for name, command in alone.items():
            assert tested.get(name) == command, f"{name} is compiled otherwise with tests:\n{command}\n{tested.get(name)}"
        assert groups == groups_tested, "the groups change with tests"

        second = copy_of_sources(pathlib.Path(folder) / "another" / "second")
        elsewhere, groups_elsewhere = configured(second, "OFF")
        assert groups == groups_elsewhere, "the groups' text depends on where the checkout lies"
        assert alone == elsewhere, "another checkout has other options"
        for name, command in alone.items():
            named = [word for word in command.split() if word.startswith("-D") and "ROOT" in word]
            assert not named, f"{name}: the compiler cache misses it in every other checkout, for {named}"
        if shutil.which("ccache"):
            rules = (first / "build/CMakeFiles/rules.ninja").read_text() + (first / "build/build.ninja").read_text()
            assert f"CCACHE_BASEDIR={first} CCACHE_NOHASHDIR=1" in rules, "the compiler cache is not told the checkout"

        (first / "analysis/statistics/figures/another_figure.cpp").write_text("// new\n")
        _, groups_after = configured(first, "ON")
        changed = sorted(name for name in groups_after if groups_after[name] != groups.get(name))
        assert changed == ["analysis.cpp"], f"one new file changed the groups {changed}"
    print("tests, checkouts and new files leave the product's commands as they are")


if __name__ == "__main__":
    main()
