#!/usr/bin/python3
"""The pages of reference that are made of what the program and its sources know: docs/reference-*.md.

    reference.py PROGRAM            compares the pages with what they would be now, and ends with 1 where one differs
    reference.py PROGRAM --write    writes them

reference-keys.md and reference-errors.md are printed by the program, from the tables by which it reads its files and takes the
exit code of an error. reference-verbs.md is made of the verbs' own --help.
"""

import difflib
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def read(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def printed(program, verb):
    return subprocess.run([program, verb], capture_output=True, text=True, check=True).stdout


def help_of(program, path):
    return subprocess.run([program, *path, "--help-all"], capture_output=True, text=True, check=True,
                          env={"PATH": os.environ["PATH"], "TACTBENCH_SHARE": ROOT, "COLUMNS": "100"}).stdout


def verbs_page(program):
    page = ("# Verbs\n\nMade from `tactbench VERB --help` by `tests/docs/reference.py`. What all verbs have in "
            "common, and exit codes,\nstand in `tactbench --help` and in [rules](rules.md#exit-codes).\n")

    def add(path):
        nonlocal page
        lines = help_of(program, path).rstrip().split("\n")
        subverbs = re.findall(r"^  ([a-z][a-z-]*)  +\S", "\n".join(lines), re.M)
        if path:
            usage = next(i for i, line in enumerate(lines) if line.startswith("Usage: "))
            about = ". ".join([lines[0], " ".join(lines[1:usage])] if usage > 1 else lines[:1]).strip().rstrip(".")
            kept = [line for line in lines[usage + 1:] if not line.startswith(("For every verb:", "Rarely needed options:"))]
            page += f"\n## {' '.join(path)}\n{about[:1].upper()}{about[1:]}.\n\n```text\n{lines[usage][7:]}\n" + "\n".join(kept).rstrip() + "\n```\n"
        for verb in subverbs:
            add([*path, verb])

    add([])
    return page


program, *options = sys.argv[1:]
pages = {"docs/reference-keys.md": printed(program, "reference-keys"), "docs/reference-errors.md": printed(program, "reference-errors"),
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
