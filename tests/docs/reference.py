#!/usr/bin/python3
"""The pages of reference that are made of what the program and its sources know: docs/reference-*.md.

    reference.py PROGRAM            compares the pages with what they would be now, and ends with 1 where one differs
    reference.py PROGRAM --write    writes them

reference-keys.md is printed by the program, from what its parsers ask for; that every key that a parser names in the sources
stands in it is checked here. reference-verbs.md is made of the verbs' own --help. reference-errors.md is made of the places
in the sources where an identifier is thrown, with the exit codes of tests/bench/common/exit_codes.cpp, which a test holds.
"""

import difflib
import glob
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LITERAL = re.compile(r'"((?:[^"\\]|\\.)*)"')
CODES = {"CriterionFailed": "1", "Usage": "2", "Device": "3", "Stopped": "4", "Store": "5", "Inconclusive": "6", "Unsafe": "7",
         "Internal": "70", "Interrupted": "130", "Terminated": "143"}
MOST_SITES = 3  # shown of an id
# Cause and cure where the place that throws takes them from elsewhere; used for the cells that the sources leave empty, and
# an entry that no cell needs is a failure.
UNSAID = {
    "TB-ANALYSIS-MODEL": ("", "fit data with loops or inner branches that this model needs, or another model"),
    "TB-BRANCH-BROKEN": ("the pressure stepped back within a branch, in every attempt", ""),
    "TB-CALIBRATION-STOPPED": ("somebody ended calibrate-reference", ""),
    "TB-CHAMBER-STALE": ("the last reading of feedback or reference is older than [limits] stale_s; more load was refused",
                         "check module and line: readings come too late or not at all"),
    "TB-DAQMX-ERROR": ("the NI-DAQmx driver refused; its number, name and text", "what the driver's text says; NI MAX or `nilsdev` lists cards"),
    "TB-DEADMAN-BLIND": ("the dead-man cannot reach the module, twice in a row",
                         "check that the module accepts a second connection and that no other program uses it; start again or resume"),
    "TB-DEADMAN-ENDED": ("the dead-man's process has ended", "find out what ended it (system log, memory); start again or resume"),
    "TB-DEADMAN-FIRED": ("the dead-man vented: the program was silent for too long, or a panic was commanded",
                         "find out what delayed the program; `tactbench devices reset` if the bench is tripped; start again or resume"),
    "TB-DEADMAN-SILENT": ("the dead-man does not answer",
                          "its process is stopped, or the computer is overloaded: find out why; start again or resume"),
    "TB-DEVICE-NAME": ("an instrument reports a model, serial number or firmware that is no text or too long", ""),
    "TB-FLEET-CONNINFO": ("", "write it as psql takes it, \"host=db.lab dbname=tactile user=bench_a\", or \"service=NAME\""),
    "TB-FLEET-FOLDER": ("the folder of a night's parts cannot be made, holds files of others, or parts of another night",
                        "name another folder with --folder, or end that other night with the command that began it"),
    "TB-FLEET-WHERE": ("", "write a condition in SQL over the columns of fleet.every_run"),
    "TB-FORCE-STALE": ("the last reading of force is older than [limits] stale_s; the motion was refused",
                       "check the force sensor and its line: readings come too late or not at all"),
    "TB-HTTP-ANSWER": ("the force sensor's page is too long, or no answer of HTTP", "check [force] host and http_port; or give a saved page as page_file"),
    "TB-HTTP-OPEN": ("", "check [force] host and http_port, the cable, and that the sensor has power"),
    "TB-HTTP-TIMEOUT": ("the force sensor's page did not come in time", "check the line and that the sensor has power; or give a saved page as page_file"),
    "TB-MERGE-SHARD": ("of a night in parts, one is missing or is there twice",
                       "carry the missing part out: tactbench nightly SUITE --shard K/N --db FILE; merge each night by itself"),
    "TB-MODBUS-PROTOCOL": ("an answer does not belong to the request", ""),
    "TB-PAGE-CERTIFICATE": ("a file cannot be used for TLS: it cannot be read, is not in PEM, holds something else, has a passphrase, or the "
                            "key is not the certificate's",
                            "name a certificate and its private key, both in PEM, that belong together"),
    "TB-RECIPE-DEVICES": ("", "describe the device in the bench file, or choose a recipe that does without it"),
    "TB-REPORT-PDF": ("no PDF could be made: no browser or typesetter is there, or it failed; its own words",
                      "apt-get install chromium, or weasyprint; `--format html` needs neither"),
    "TB-RUN-PANIC": ("somebody commanded a panic, or an abort, while the run was live",
                     "inspect the rig before the next run; the frames so far are kept"),
    "TB-RUN-SILENT": ("the run's process does not answer commands", ""),
    "TB-RUN-VOID": ("a run that is named was declared void: by whom, why", ""),
    "TB-RUN-WORD": ("the run does not take the command in its present state, which it names", ""),
    "TB-SCANNER-LOST": ("", "plug the scanner in again, or start its program; then resume the run"),
    "TB-UDP-LOST": ("the network refuses the force sensor's address", "check [force] host, the cable and the network's settings"),
}


def read(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def sources(*rooms):
    for room in rooms:
        for path in sorted(glob.glob(os.path.join(ROOT, room, "**", "*"), recursive=True)):
            if path.endswith((".cpp", ".h")):
                yield os.path.relpath(path, ROOT)


# --- keys

READS = (r"\.(?:number|number_in|zero_or_in|integer|boolean|text|name|date_text|texts|word|numbers|numbers_or_one|number_lists|"
         r"span)\(\s*\"([a-z_0-9]+)\"")
HELPED = r"(?:word_of|read_date|read_span|three|grid_axis|read|address|function_of|read_quantity_place|read_stated_calibration)\((?:\w+, )?\"([a-z_0-9]+)\"(?:, \"([a-z_0-9]+)\")?"


def keys_page(program):
    page = subprocess.run([program, "reference-keys"], capture_output=True, text=True, check=True).stdout
    known = {key.split(".")[-1] for key in re.findall(r"^\| `([^`]+)`", page, re.M)}
    asked = set()
    for path in sources("bench/config", "bench/nightly", "sequences"):
        if path.startswith("sequences/toml/") or not path.endswith(".cpp"):
            continue
        text = read(path)
        asked |= {key for pattern in (READS, HELPED) for found in re.findall(pattern, text)
                  for key in ([found] if isinstance(found, str) else found) if key}
    missing = sorted(asked - known)
    if missing:
        sys.exit(f"docs/reference-keys.md lacks keys that a parser reads: {', '.join(missing)}; "
                 "bench/cli/words/key_samples.cpp has to read a file in which they stand, bench/cli/words/meanings to say what they are for")
    if len(asked) < 150:
        sys.exit(f"only {len(asked)} keys were found in the sources: the parsers' calls have other names now")
    return page


# --- errors

def closing(text, at):
    """Where the bracket that `at` lies in closes."""
    depth = 0
    while at < len(text):
        if text[at] == '"':
            at = LITERAL.match(text, at).end()
            continue
        if text[at] in "([{":
            depth += 1
        elif text[at] in ")]}":
            if depth == 0:
                return at
            depth -= 1
        elif text[at] == ";" and depth == 0:
            return at
        at += 1
    return at


def arguments(text):
    parts, start, at, depth = [], 0, 0, 0
    while at < len(text):
        if text[at] == '"':
            at = LITERAL.match(text, at).end()
            continue
        depth += {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}.get(text[at], 0)
        if text[at] == "," and depth == 0:
            parts.append(text[start:at])
            start = at + 1
        at += 1
    return parts + [text[start:]]


def words(argument):
    """What an argument says: its literals, what is filled in as "…", alternatives with " / "."""
    argument = re.sub(r'"\s*\n?\s*"', "", argument)
    said = [text for text in LITERAL.findall(argument) if len(text) > 3]
    said = [re.sub(r"\{[^{}]*\}", "…", text.replace('\\"', '"').replace("\\n", " ")).strip() for text in said]
    return " / ".join(dict.fromkeys(text for text in said if re.search("[a-z]{3}", text)))


def sites(text):
    """(id, message, remedy) of each place; "" where the place takes it from elsewhere."""
    text = re.sub(r"//[^\n\"]*$", "", text, flags=re.M)
    for found in re.finditer(r'"(TB-[A-Z0-9-]*[A-Z0-9])"', text):
        rest = text[found.end():closing(text, found.end())]
        if not rest.startswith(","):
            yield found.group(1), "", ""
            continue
        said = [words(argument) for argument in arguments(rest[1:])]
        remedy = said.pop() if len(said) > 1 else ""  # the last argument of every error
        yield found.group(1), next((each for each in said if " " in each), ""), remedy


def errors_page():
    table = re.search(r"kIdsOfCode = \{(.*?)\n\};", read("tests/bench/common/exit_codes.cpp"), re.S).group(1)
    codes = {}
    for code, ids in re.findall(r"ExitCode::k(\w+),\s*((?:\"[^\"]*\"\s*)+)", table):
        for name in " ".join(LITERAL.findall(ids)).split():
            codes.setdefault("TB-" + name, []).append(CODES[code])
    found = {}
    for path in sources("devices", "db", "sequences", "analysis", "bench"):
        for name, message, remedy in sites(read(path)):
            if name in codes and (message, remedy) not in found.setdefault(name, []):
                found[name].append((message, remedy))
    page = ("# Errors\n\n"
            "Made from the sources by `tests/docs/reference.py`: each identifier, the exit code of the program that ends with it "
            "([all exit\ncodes](rules.md#exit-codes)), what it says and what it advises, where that stands at the place that throws. `…` is filled "
            "in at the\ntime: names, numbers, files. An error prints, beside these, where it arose and in what state it left the rig.\n\n"
            "| id | exit code | says | try |\n|---|---|---|---|\n")
    for name in sorted(codes):
        pairs = [pair for pair in found.get(name, []) if pair[0] or pair[1]]
        pairs.sort(key=lambda pair: not (pair[0] and pair[1]))
        pairs = pairs[:MOST_SITES] or [("", "")]
        for i, (message, remedy) in enumerate(pairs):
            told = UNSAID.get(name, ("", ""))
            if i == 0 and name in UNSAID:
                if not (told[0] and not message or told[1] and not remedy):
                    sys.exit(f"{sys.argv[0]}: UNSAID has {name}, and the sources say it themselves now")
                message, remedy = told[0] or message, remedy or told[1]
            cells = [f"`{name}`" if i == 0 else "", ", ".join(codes[name]) if i == 0 else "", message, remedy]
            page += "| " + " | ".join(each.replace("|", "\\|") for each in cells) + " |\n"
    return page


# --- verbs

def help_of(program, path):
    return subprocess.run([program, *path, "--help"], capture_output=True, text=True, check=True,
                          env={"PATH": os.environ["PATH"], "TACTBENCH_SHARE": ROOT, "COLUMNS": "100"}).stdout


def verbs_page(program):
    page = ("# Verbs\n\nMade from `tactbench VERB --help` by `tests/docs/reference.py`. Every verb also takes `--help`; what all verbs have in "
            "common, exit codes\nand first steps, stands in `tactbench --help` and in [rules](rules.md#exit-codes).\n")

    def add(path):
        nonlocal page
        text = re.split(r"\n\s*\n?Exit codes: 0 pass, ", help_of(program, path))[0]
        lines = text.rstrip().split("\n")
        subverbs = []
        if "Subcommands:" in lines:
            at = lines.index("Subcommands:")
            subverbs = re.findall(r"^  (\S+)", "\n".join(lines[at + 1:]), re.M)
        if path:
            usage = next(i for i, line in enumerate(lines) if line.startswith("Usage: "))
            about = " ".join(lines[:usage]).strip()
            kept = [line for line in lines[usage + 1:] if "--help" not in line]
            kept = [line for i, line in enumerate(kept) if line != "Options:" or kept[i + 1:i + 2] not in ([""], [])]
            page += f"\n## {' '.join(path)}\n{about[:1].upper()}{about[1:]}.\n\n```text\n{lines[usage][7:]}\n" + "\n".join(kept).rstrip() + "\n```\n"
        for verb in subverbs:
            add([*path, verb])

    add([])
    return page


program, *options = sys.argv[1:]
pages = {"docs/reference-keys.md": keys_page(program), "docs/reference-errors.md": errors_page(),
         "docs/reference-verbs.md": verbs_page(program)}
differs = []
for name, page in pages.items():
    if options == ["--write"]:
        with open(os.path.join(ROOT, name), "w", encoding="utf-8") as file:
            file.write(page)
        continue
    committed = read(name) if os.path.exists(os.path.join(ROOT, name)) else ""
    if committed != page:
        differs.append(name)
        print("".join(difflib.unified_diff(committed.splitlines(True), page.splitlines(True), name, "as it would be now", n=0))[:4000])
if differs:
    sys.exit(f"{', '.join(differs)}: not what the program says now; run tests/docs/reference.py PROGRAM --write, and read what changed")
