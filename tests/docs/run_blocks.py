#!/usr/bin/python3
"""Runs the blocks of README, tutorial and how-tos in order, as a reader would, and compares what the documents promise; and
checks that the links of all documents lead somewhere.

    run_blocks.py PROGRAM [DOCUMENT...]

Each document has a temporary folder and a shell of its own, in which PROGRAM is first in PATH, $CLONE is this checkout and
$CLONE/build is PROGRAM's folder. A block ```sh is run line by line; every command must end with 0, or with N where its line
ends in `# exit code N`. Comments in the Markdown, each before a block:

    <!-- not run: REASON -->                        the block is not run
    <!-- not run: REASON; instead: COMMAND -->      COMMAND is run in its place
    <!-- needs: PROGRAMS -->                        the block is run where all of these are installed
    <!-- output -->                                 the lines that the block of commands before it prints, all of them;
                                                    `...` stands for any characters, alone on a line for any lines
    <!-- example -->                                text that nothing promises
    <!-- file: NAME -->   <!-- add to: NAME -->     the block is written to the file, or added to it
    <!-- same as: PATH -->                          the block is this file of the repository
    <!-- another terminal, ready at: TEXT -->       runs beside the following blocks until the document's end; the next block
                                                    starts when TEXT has been printed
    <!-- folder of: NAME.md -->                     at the top: goes on in the folder of a document run before
"""

import glob
import os
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LONGEST_S = 600  # of a command; ends what hangs
MARK = "TACTBENCH_DOCUMENT_RUN"


class Failure(Exception):
    """What a document says and what is so."""


class Block:
    def __init__(self, line, language, lines, comment):
        self.line, self.language, self.lines, self.comment = line, language, lines, comment

    def value(self, name):
        """What stands after `name: ` in the block's comment; None: there is no such comment."""
        found = re.fullmatch(re.escape(name) + r"(?:: (.*))?", self.comment, re.S)
        return (found.group(1) or "") if found else None


def blocks_of(text):
    """The fenced blocks, each with the comment right before it; and the comments that stand alone."""
    blocks, alone, comment, lines = [], [], "", text.splitlines()
    i = 0
    while i < len(lines):
        fence = re.fullmatch(r"```(\w*)", lines[i])
        remark = re.fullmatch(r"<!-- (.*) -->", lines[i])
        if fence:
            end = next((j for j in range(i + 1, len(lines)) if lines[j] == "```"), None)
            if end is None:
                raise Failure(f"line {i + 1}: the block does not end")
            blocks.append(Block(i + 1, fence.group(1), lines[i + 1:end], comment))
            comment, i = "", end
        elif remark:
            if comment:
                alone.append(comment)
            comment = remark.group(1)
        elif lines[i].strip():
            if comment:
                alone.append(comment)
            comment = ""
        i += 1
    return blocks, alone + ([comment] if comment else [])


def commands_of(lines):
    """Commands with the exit code that each promises; a line that ends in a backslash goes on."""
    command = ""
    for line in lines:
        command += line
        if line.endswith("\\"):
            command += "\n"
            continue
        if command.strip() and not command.lstrip().startswith("#"):
            promised = re.search(r"#.*\bexit code (\d+)\s*$", line)
            yield command, int(promised.group(1)) if promised else 0
        command = ""
    if command:
        raise Failure("the last line ends in a backslash")


def same(promised, printed):
    """Whether the promised lines are those that were printed."""
    if not promised:
        return not printed
    if promised[0].strip() == "...":
        return any(same(promised[1:], printed[i:]) for i in range(len(printed) + 1))
    if not printed:
        return False
    pattern = ".*".join(re.escape(part) for part in promised[0].rstrip().split("..."))
    return re.fullmatch(pattern, printed[0]) is not None and same(promised[1:], printed[1:])


def shown(output):
    """As a terminal shows it: a line that is written over is seen as last written, blanks at its end are not."""
    lines = [re.sub(r"\x1b\[[0-9;]*[A-Za-z]", "", line).rstrip("\r").split("\r")[-1].rstrip() for line in output.split("\n")]
    while lines and not lines[-1]:
        lines.pop()
    return lines


def marked(mark):
    """Processes that this test has started, by the mark in their environment."""
    for name in os.listdir("/proc"):
        if name.isdigit() and int(name) != os.getpid():
            try:
                with open(f"/proc/{name}/environ", "rb") as file:
                    if f"{MARK}={mark}".encode() in file.read().split(b"\0"):
                        yield int(name)
            except OSError:
                pass


def stop_all(mark):
    """Ends what still runs of a document; what that was."""
    ended_by = time.monotonic() + 10
    while time.monotonic() < ended_by and any(marked(mark)):
        time.sleep(0.05)
    left = []
    for number in marked(mark):
        try:
            with open(f"/proc/{number}/cmdline") as file:
                left.append(file.read().replace("\0", " ").strip())
            os.kill(number, signal.SIGKILL)
        except OSError:
            pass
    return left


def folder_of(text):
    """The document in whose folder this one goes on; None: it has a folder of its own."""
    before = re.search(r"^<!-- folder of: (.*) -->$", text, re.M)
    return before.group(1) if before else None


class Shell:
    """One bash for a document, which keeps its folder and variables from block to block."""

    def __init__(self, folder, environment):
        self.folder, self.environment = folder, environment
        self.scratch = tempfile.mkdtemp(dir=environment["HOME"])
        acknowledged, write_end = os.pipe()
        self.acknowledged = os.fdopen(acknowledged)
        self.process = subprocess.Popen(["bash", "--noprofile", "--norc"], cwd=folder, env=environment, stdin=subprocess.PIPE,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, text=True, pass_fds=[write_end],
                                        start_new_session=True)
        os.close(write_end)
        self.acknowledge_to, self.beside = write_end, []

    def run(self, command):
        """Its exit code and what it printed."""
        words, output = os.path.join(self.scratch, "command"), os.path.join(self.scratch, "output")
        with open(words, "w") as file:
            file.write(command + "\n")
        self.process.stdin.write(f'eval "$(cat {words})" >{output} 2>&1 </dev/null {self.acknowledge_to}>&-\n'
                                 f'echo "$? $PWD" >&{self.acknowledge_to}\n')
        self.process.stdin.flush()
        if not select.select([self.acknowledged], [], [], LONGEST_S)[0]:
            raise Failure(f"takes longer than {LONGEST_S} s: {command}")
        answer = self.acknowledged.readline()
        if not answer:
            raise Failure(f"ended the shell: {command}")
        code, self.folder = answer.rstrip("\n").split(" ", 1)
        with open(output, errors="replace", newline="") as file:
            return int(code), file.read()

    def start(self, command, ready):
        path = os.path.join(self.scratch, f"beside-{len(self.beside)}")
        with open(path, "w") as file:
            words = ["setpriv", "--pdeathsig", "TERM", "bash", "-c", "exec " + command]  # ends with this test, however that ends
            self.beside.append(subprocess.Popen(words, cwd=self.folder, env=self.environment, stdin=subprocess.DEVNULL, stdout=file,
                                                stderr=subprocess.STDOUT, start_new_session=True))
        for _ in range(LONGEST_S * 10):
            with open(path, errors="replace") as file:
                printed = file.read()
            if ready in printed:
                return
            if self.beside[-1].poll() is not None:
                break
            time.sleep(0.1)
        raise Failure(f"'{ready}' was not printed by: {command}\n{printed}")

    def close(self):
        for process in self.beside:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for process in self.beside:
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.process.stdin.close()
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.acknowledged.close()


def write_block(block, shell):
    """A block that is a file, or part of one. Whether it was."""
    text = "\n".join(block.lines) + "\n"
    for name, mode in (("file", "w"), ("add to", "a")):
        target = block.value(name)
        if target is not None:
            with open(os.path.join(shell.folder, target), mode) as file:
                file.write(text)
            return True
    source = block.value("same as")
    if source is not None:
        with open(os.path.join(ROOT, source)) as file:
            if file.read() != text:
                raise Failure(f"is not the same as {source}")
        return True
    return False


def run_block(block, shell):
    """Runs a block of commands; what it printed, None if it was not run."""
    commands, not_run = block.lines, block.value("not run")
    if not all(shutil.which(name) for name in (block.value("needs") or "").split()):
        return None
    ready = block.value("another terminal, ready at")
    if ready is not None:
        [(command, _)] = commands_of(commands)
        shell.start(command, ready)
        return None
    if not_run is not None:
        if "; instead: " not in not_run:
            return None
        commands = [not_run.split("; instead: ", 1)[1]]
    printed = ""
    for command, promised in commands_of(commands):
        code, output = shell.run(command)
        printed += output
        if code != promised:
            raise Failure(f"exit code {code} instead of {promised}: {command}\n{output}")
    return shown(printed)


def run_document(text, shell):
    """The number of blocks of commands that were run, and of promised lines."""
    blocks, alone = blocks_of(text)
    for comment in alone:
        if not comment.startswith("folder of: "):
            raise Failure(f"no block follows <!-- {comment} -->")
    printed, count, promises = None, 0, 0
    for block in blocks:
        try:
            if block.value("output") is not None:
                if printed is None:
                    raise Failure("is promised by a block that is not run")
                if not same(block.lines, printed):
                    raise Failure("promised:\n" + "\n".join(block.lines) + "\nprinted:\n" + "\n".join(printed))
                promises += len(block.lines)
            elif block.language == "sh":
                if block.comment and not re.match("not run: |needs: |another terminal, ready at: ", block.comment):
                    raise Failure(f"means nothing here: <!-- {block.comment} -->")
                printed = run_block(block, shell)
                count += printed is not None
            elif not write_block(block, shell) and block.language == "text" and block.value("example") is None:
                raise Failure("is neither <!-- output --> nor <!-- example -->")
        except Failure as failure:
            raise Failure(f"line {block.line}: {failure}") from None
    return count, promises


class Stage:
    """The folders in which documents are run: a home, a checkout whose build is the program's folder, and one for each."""

    def __init__(self, program):
        self.top = tempfile.mkdtemp(prefix="tb-docs-")
        for name in ("home", "clone", "bin"):
            os.mkdir(os.path.join(self.top, name), 0o700)
        for name in os.listdir(ROOT):
            if name != "build" and not name.startswith("."):
                os.symlink(os.path.join(ROOT, name), os.path.join(self.top, "clone", name))
        os.symlink(os.path.dirname(program), os.path.join(self.top, "clone/build"))
        os.symlink(program, os.path.join(self.top, "bin/tactbench"))
        self.environment = {
            "PATH": os.path.join(self.top, "bin") + ":/usr/local/bin:/usr/bin:/bin", "HOME": os.path.join(self.top, "home"),
            "CLONE": os.path.join(self.top, "clone"), "TERM": "dumb", "LC_ALL": "C.UTF-8", "TZ": "UTC",
            "PYTHONDONTWRITEBYTECODE": "1"}
        if "TACTBENCH_SHARE" in os.environ:
            self.environment["TACTBENCH_SHARE"] = os.environ["TACTBENCH_SHARE"]

    def run(self, name, text):
        """Runs the document; raises Failure, also when something is left running."""
        folder = os.path.join(self.top, (folder_of(text) or name).removesuffix(".md"))
        live_runs = folder + ".run"  # a bench is locked there, not on the machine
        for path in (folder, live_runs):
            os.makedirs(path, mode=0o700, exist_ok=True)
        shell = Shell(folder, {**self.environment, "TACTBENCH_RUNTIME_DIR": live_runs, MARK: folder})
        try:
            result = run_document(text, shell)
        finally:
            shell.close()
            left = stop_all(folder)
        if left:
            raise Failure(f"left running: {left}")
        return result

    def close(self):
        shutil.rmtree(self.top, ignore_errors=True)


def headings(path):
    """The anchors of a document's headings, as GitHub forms them."""
    with open(path) as file:
        lines = re.sub(r"^```.*?^```", "", file.read(), flags=re.M | re.S).splitlines()
    return {re.sub(r"[^\w\- ]", "", line.lstrip("# ").lower()).replace(" ", "-") for line in lines if line.startswith("#")}


def broken_links(path):
    """Links of a document to files or headings that are not there."""
    with open(path) as file:
        for target in re.findall(r"\]\(([^)\s]+)\)", file.read()):
            if re.match(r"https?:", target):
                continue
            name, _, anchor = target.partition("#")
            there = os.path.normpath(os.path.join(os.path.dirname(path), name)) if name else path
            if not os.path.exists(there) or anchor and anchor not in headings(there):
                yield f"{os.path.basename(path)}: links to {target}, which is not there"


def check_itself(stage):
    """What must be found is found."""
    right = "```sh\necho one; echo two\nfalse  # exit code 1\n```\n<!-- output -->\n```text\no...e\n...\n```\n"
    stage.run("right.md", right)
    for name, text in (("a wrong line", right.replace("o...e", "o...f")), ("a line too many", right.replace("o...e", "one\ntwo\nthree")),
                       ("a missing line", right.replace("o...e\n...", "one")), ("a wrong command", right.replace("echo one", "eco one")),
                       ("a failed command", right.replace("  # exit code 1", "")), ("a lost comment", right + "<!-- output -->\n"),
                       ("a wrong exit code", right.replace("code 1", "code 2")), ("no promise", right.replace("<!-- output -->\n", "")),
                       ("a process left", "```sh\nsleep 100 &\n```\n")):
        try:
            stage.run("wrong.md", text)
        except Failure:
            continue
        raise SystemExit(f"run_blocks.py does not find {name}")


def run_all(stage, documents, failed):
    for name, text in documents:
        started = time.monotonic()
        try:
            count, promises = stage.run(name, text)
            print(f"{name}: {count} blocks run, {promises} lines as promised, {time.monotonic() - started:.1f} s", flush=True)
        except Exception as failure:  # a fault of the test's own fails the document as well
            print(f"{name}: {failure if isinstance(failure, Failure) else traceback.format_exc()}", flush=True)
            failed.append(name)


def main():
    program = os.path.abspath(sys.argv[1])
    paths = sys.argv[2:] or [os.path.join(ROOT, "README.md"), os.path.join(ROOT, "docs/tutorial.md"),
                             os.path.join(ROOT, "docs/hysteresis-and-elam.md"), *sorted(glob.glob(os.path.join(ROOT, "docs/how-to-*.md")))]
    documents = []
    for path in paths:
        with open(path) as file:
            documents.append((os.path.basename(path), file.read()))
    # Two at a time: those that share a folder one after the other, the others beside them.
    shared = {folder_of(text) for _, text in documents}
    in_order = [each for each in documents if each[0] in shared or folder_of(each[1])]
    stage, failed = Stage(program), []
    for path in sorted({*paths, *glob.glob(os.path.join(ROOT, "docs/*.md"))}):
        failed += broken_links(path)
    print(*failed, sep="\n", end="\n" * bool(failed))
    try:
        check_itself(stage)
        others = threading.Thread(target=run_all, args=(stage, [each for each in documents if each not in in_order], failed))
        others.start()
        run_all(stage, in_order, failed)
        others.join()
    finally:
        stage.close()
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
