#!/usr/bin/env python3
"""Which sentences of the product stand in its tests, and so could not be bettered without changing a test.

    tests/phrases.py [--limit PERCENT] [--list]

A phrase is a run of four or more words in a string of the product, between placeholders and line ends. It stands in a test when a
string there holds all of it. Exit code 1 when more than PERCENT of the phrases do.
"""
import argparse
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
LITERAL = re.compile(r'^#include[^\n]*|R"([a-z]*)\((?P<raw>.*?)\)\1"|"(?P<plain>(?:[^"\\\n]|\\.)*)"|//[^\n]*|\'(?:[^\'\\\n]|\\.)\'', re.S | re.M)
BREAK = re.compile(r"\\n|\n|\{[^{}]*\}|<[^>]*>|[|;:]")
WORD = re.compile(r"[A-Za-z][A-Za-z'’-]*")
WORDS = 4


def texts(path):
    """The strings of a C++ or Python source; those that stand beside each other are one."""
    source, found, end = path.read_text(errors="replace"), [], -1
    for match in LITERAL.finditer(source):
        text = match["raw"] if match["raw"] is not None else match["plain"]
        if text is None:
            continue
        if found and not source[end:match.start()].strip():
            found[-1] += text
        else:
            found.append(text)
        end = match.end()
    return found


def files(*patterns):
    listed = subprocess.run(["git", "ls-files", "-z", *patterns], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return [ROOT / name for name in listed.split("\0") if name and (ROOT / name).is_file()]


def words_of(text):
    """The runs of words in a text, each run as one string."""
    return [" ".join(words) for part in BREAK.split(text) if len(words := WORD.findall(part.lower())) >= WORDS]


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--limit", type=float)
    arguments.add_argument("--list", action="store_true")
    options = arguments.parse_args()
    product = files(*[f"{room}/*.{end}" for room in ("analysis", "bench", "db", "devices", "sequences") for end in ("cpp", "h")])
    phrases = {phrase for path in product for text in texts(path) for phrase in words_of(text)}
    held = {path: "\n".join(f" {run} " for text in texts(path) for run in words_of(text))
            for path in files("tests/*.cpp", "tests/*.h", "tests/*.py", "tests/*.mjs")}
    everything = "\n".join(held.values())
    standing = sorted(phrase for phrase in phrases if f" {phrase} " in everything)
    if options.list:
        for phrase in standing:
            print(f"{next(path for path in held if f' {phrase} ' in held[path]).relative_to(ROOT)}: {phrase}")
    share = 100 * len(standing) / len(phrases)
    print(f"{len(standing)} of the product's {len(phrases)} phrases stand in tests: {share:.1f} %")
    return 1 if options.limit is not None and share > options.limit else 0


if __name__ == "__main__":
    raise SystemExit(main())
