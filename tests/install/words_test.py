"""The completion scripts in the shells themselves, where these are installed (bash always), and the manual pages before
man and mandoc; the commands of README and docs have the verbs and options that the program has. Arguments: the program,
install.cmake, the documents."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

PROGRAM, INSTALL, *DOCUMENTS = sys.argv[1:]


def said(*words, **more):
    done = subprocess.run(words, capture_output=True, text=True, timeout=600, **more)
    assert done.returncode == 0 and not done.stderr, (words, done)
    return done.stdout


def bash(*words):
    """What bash offers for the last of `words`, as it does after a press of TAB."""
    script = f'source {scripts["bash"]}; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _tactbench; printf "%s\\n" "${{COMPREPLY[@]}}"'
    return said("bash", "-c", script, "bash", "tactbench", *words, cwd=folder).split()


def check_bash():
    assert bash("ru") == ["run", "runs"], bash("ru")
    assert {"plan", "nightly", "completion", "--version"} <= set(bash("") + bash("--"))
    assert "dead-man" not in bash("") and "manual-page" not in bash("")
    assert bash("runs", "e") == ["export"]
    assert {"csv", "json"} <= set(bash("runs", "export", "1", "--format", ""))
    assert bash("runs", "export", "1", "--format", "=", "cs") == ["csv"]  # as bash cuts --format=cs
    assert bash("runs", "export", "1", "--format", "=") == bash("runs", "export", "1", "--format", "")
    assert bash("runs", "export", "1", "--out") == ["--output"]
    assert bash("runs", "export", "1", "-o", "my") == ["my", "table.csv"]  # one name, cut at its blank by this test
    assert bash("plan", "desc") == ["descending"]
    assert bash("plan", "--bench", "simu") == ["simulated.toml"]
    assert set(bash("completion", "")) == {"bash", "fish", "zsh"}
    assert bash("demo", "--seed", "") == []  # a number: nothing to offer
    assert set(bash("demo", "--specimen", "")) == {"paper", "harsh"}
    assert bash("nightly", "nig") == ["nightly"]
    after_a_verbs_name = bash("run", "descending", "--operator", "runs", "--sen")
    assert set(after_a_verbs_name) == {"--sensor", "--sensor-seed"}, after_a_verbs_name


def check_every_option():
    """Each option that --help names is offered, for each verb."""
    verbs = [word for word in bash("") if not word.startswith("-")]
    assert len(verbs) > 20, verbs
    for verb in verbs:
        help_text = said(PROGRAM, verb, "--help")
        named = {word.strip(",") for line in help_text.splitlines() for word in line.split()[:1] if word.startswith("-")}
        named |= {part for word in named for part in word.split(",")}
        named = {word for word in named if "," not in word}
        assert named <= set(bash(verb, "-")), (verb, named - set(bash(verb, "-")))


def check_others():
    if shutil.which("zsh"):
        said("zsh", "-n", scripts["zsh"])
    if shutil.which("fish"):
        said("fish", "--no-execute", scripts["fish"])
        offered = said("fish", "-c", f'source {scripts["fish"]}; complete -C "tactbench runs export 1 --format "',
                       env={**os.environ, "HOME": folder})
        assert {line.split("\t")[0] for line in offered.splitlines()} >= {"csv", "json"}, offered
    if shutil.which("shellcheck"):
        said("shellcheck", "--shell=bash", scripts["bash"])


def check_manual():
    page = said(PROGRAM, "manual-page")
    path = os.path.join(folder, "tactbench.1")
    with open(path, "w") as file:
        file.write(page)
    for text in (".TH TACTBENCH 1", ".SS runs export", ".SH EXIT STATUS", ".SH FILES", "TACTBENCH_SHARE",
                 "\\fB\\-\\-stop\\-on\\-red\\fR", "one of csv, json"):
        assert text in page, text
    # Nothing is said of each verb anew: neither exit codes nor options that many verbs have alike.
    for text in ("Exit codes: 0 pass", "First steps:", "one JSON document on standard output, also for errors", "no progress line"):
        assert page.count(text) <= 1, (text, page.count(text))
    assert ".SH COMMON OPTIONS" in page and page.count("run store, one SQLite file per bench (otherwise by TACTBENCH_DB or tactbench.toml) (default") == 1
    sentences = [line for line in page.splitlines() if len(line) > 60 and not line.startswith((".", "Common options: "))]
    often = {line for line in sentences if sentences.count(line) > 5}
    assert not often, often
    for verb in bash(""):
        assert verb.startswith("-") or f".SS {verb}".replace("-", "\\-") in page, verb
    lint(path)


def lint(path):
    """What man shows of a page, where man is installed."""
    if shutil.which("mandoc"):
        said("mandoc", "-Tlint", "-W", "warning", path)
    if not shutil.which("man"):
        return None
    shown = said("man", "--warnings", "-E", "UTF-8", "-l", "-Tutf8", path, env={**os.environ, "LC_ALL": "C.UTF-8", "MANWIDTH": "100"})
    return re.sub(r".\x08|\x1b\[[0-9;]*m", "", shown)


def check_key_manuals():
    """Section 5: each kind of file has its page, and on it every key of the page of reference with its meaning."""
    installed = re.search(r"set\(KEY_PAGES ([^)]*)\)", open(INSTALL).read()).group(1).split()
    pages = said(PROGRAM, "manual-page", "all").split()
    assert installed == pages and len(pages) == 8, (installed, pages)
    reference = re.findall(r"^## (.*?)\n.*?^\|---.*?\n(.*?)(?=^## |\Z)", said(PROGRAM, "reference-keys"), re.M | re.S)
    assert len(reference) == len(pages), [title for title, _ in reference]
    keys = 0
    for name, (title, rows) in zip(pages, reference):
        path = os.path.join(folder, name + ".5")
        page = said(PROGRAM, "manual-page", name)
        with open(path, "w") as file:
            file.write(page)
        shown = lint(path)
        entries = re.findall(r"^\.TP\n\\fB(.*?)\\fR \(.*\)\n(.+)", page, re.M)
        listed = re.findall(r"^\| `([^`]+)` \| (.+?) \| ", rows, re.M)
        assert len(entries) == len(listed) > 5, (name, title, len(entries), len(listed))
        for (entry, text), (key, meaning) in zip(entries, listed):
            assert entry == key.split(".")[-1] and len(text) > 8, (name, entry, key)
            # The first words stand on the page as man shows it.
            assert shown is None or " ".join(meaning.split()[:2]) in " ".join(shown.split()), (name, key, meaning)
        keys += len(entries)
    assert keys > 350, keys


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
        if "tactbench " not in line:
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
    scripts = {}
    for shell in ("bash", "zsh", "fish"):
        scripts[shell] = os.path.join(folder, shell)
        with open(scripts[shell], "w") as file:
            file.write(said(PROGRAM, "completion", shell))
    with open(os.path.join(folder, "my table.csv"), "w"):
        pass
    check_bash()
    check_every_option()
    check_others()
    check_manual()
    check_key_manuals()
    check_documents()
print("completion, manual page and the documents' commands are well")
