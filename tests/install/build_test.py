"""What the build promises about compiling again: a second build compiles nothing, and with or without tests the product's
sources are compiled in the same batches by the same commands.

    build_test.py CMAKE SOURCE BUILD
"""
import json
import pathlib
import subprocess
import sys
import tempfile

CMAKE, SOURCE, BUILD = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])


def configured(folder, testing):
    """Compile commands by object, and the text of what the build made to be compiled; the product's alone."""
    subprocess.run([CMAKE, "--preset", "default", f"-DBUILD_TESTING={testing}", "-B", folder], cwd=SOURCE, check=True,
                   stdout=subprocess.DEVNULL)
    commands = {}
    for entry in json.loads((folder / "compile_commands.json").read_text()):
        words = entry["command"].split()
        made = words[words.index("-o") + 1]
        if not made.startswith("tests/"):
            commands[made] = entry["command"]
    return commands, {path: path.read_text() for path in folder.glob("CMakeFiles/*/Unity/*.cxx")}


def main():
    with tempfile.TemporaryDirectory(prefix="tactbench-build-") as folder:
        alone = configured(pathlib.Path(folder), "OFF")
        tested = configured(pathlib.Path(folder), "ON")
        assert len(alone[0]) > 20 and len(alone[1]) > 5, "hardly any product source is compiled"
        assert alone == tested, "the product is compiled otherwise with tests"
    # Run by ctest, so the program is built.
    steps = subprocess.run(["ninja", "-C", BUILD, "-n", "tactbench"], check=True, capture_output=True, text=True).stdout
    assert "Building CXX object" not in steps, f"a second build compiles again:\n{steps}"


if __name__ == "__main__":
    main()
