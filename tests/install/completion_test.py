"""What bash offers after a press of TAB, the manual page before man and mandoc, and that the commands of README and docs have
the verbs and options that the program has. Arguments: the program, the completion script, the manual page, the documents."""

import functools
import os
import shlex
import shutil
import subprocess
import sys
import tempfile

PROGRAM, SCRIPT, MANUAL, *DOCUMENTS = sys.argv[1:]


def said(*words, **more):
    done = subprocess.run(words, capture_output=True, text=True, timeout=600, **more)
    assert done.returncode == 0 and not done.stderr, (words, done)
    return done.stdout


@functools.cache
def bash(*words):
    """What bash offers for the last of `words`, as it does after a press of TAB."""
    script = f'source {SCRIPT}; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _tactbench; printf "%s\\n" "${{COMPREPLY[@]}}"'
    return said("bash", "-c", script, "bash", PROGRAM, *words, cwd=folder).splitlines()


def check_bash():
    for typed, offered in {
        ("ru",): {"run", "runs"},
        ("runs", "e"): {"export"},
        ("runs", "export", "1", "--format", "=", "cs"): {"csv"},  # as bash cuts --format=cs
        ("runs", "export", "1", "-o", "my"): {"my table.csv"},
        ("plan", "desc"): {"descending"},
        ("nightly", "nig"): {"nightly"},
        ("demo", "--seed", ""): {""},  # a number: nothing to offer
        ("demo", "--specimen", ""): {"paper", "harsh", "foam"},
        ("run", "descending", "--operator", "runs", "--sen"): {"--sensor", "--sensor-seed"},
    }.items():
        assert set(bash(*typed)) == offered, (typed, bash(*typed))
    assert "dead-man" not in bash("") and "--version" in bash("--")
    if shutil.which("shellcheck"):
        said("shellcheck", "--shell=bash", SCRIPT)


def check_manual():
    """Each verb stands on the page, and man and mandoc find nothing wrong with it."""
    page = said("gzip", "-dc", MANUAL)
    path = os.path.join(folder, "tactbench.1")
    with open(path, "w") as file:
        file.write(page)
    verbs = bash("")
    assert len(verbs) > 20, verbs
    for verb in verbs:
        assert ".TP\n" + verb.replace("-", "\\-") + "\n" in page, verb
    if shutil.which("mandoc"):
        said("mandoc", "-Tlint", "-W", "error", path)
    if shutil.which("man"):
        said("man", "--warnings", "-E", "UTF-8", "-l", "-Tutf8", path, env={**os.environ, "LC_ALL": "C.UTF-8", "MANWIDTH": "100"})


def command_lines(text):
    """Lines of the blocks of commands: indented by four, or in a fence named sh or bash; one that ends in a backslash with the next."""
    fence = ""
    for line in text.replace("\\\n", " ").splitlines():
        if line.startswith("```"):
            fence = "" if fence else line
        elif fence in ("```sh", "```bash") or not fence and line.startswith("    "):
            yield line


def commands_of(text):
    """The words after each `tactbench` of the blocks of commands."""
    for line in command_lines(text):
        if "tactbench " not in line or line.lstrip().startswith("from "):
            continue
        lexer = shlex.shlex(line, posix=True, punctuation_chars=";|()<>")
        lexer.whitespace_split = True
        words = list(lexer)  # without the remark after #
        starts = [i for i, word in enumerate(words) if word == "tactbench" or word.endswith("/tactbench")]
        for start in starts:
            command = []
            for word in words[start + 1:]:
                if set(word) <= set(";|()<>"):
                    break
                command.append(word)
            if command:
                yield command


def check_documents():
    count, commands = 0, []
    for name in DOCUMENTS:
        with open(name) as file:
            commands += commands_of(file.read())
    for command in commands:
        assert command[0] in bash(command[0]), command
        for i, word in enumerate(command):
            if word == "--":  # what follows is another command's
                break
            if word.startswith("-"):
                assert word.split("=")[0] in bash(*command[:i], "-"), (command, word)
                count += 1
    assert len(commands) > 120 and count > 200, (len(commands), count)


with tempfile.TemporaryDirectory() as folder:
    with open(os.path.join(folder, "my table.csv"), "w"):
        pass
    check_bash()
    check_manual()
    check_documents()
print("completion, manual page and the documents' commands are well")
