"""Texts that people read use the field's words: neither the private ones that reviews found, nor a label that is wrong.
Looked through are the string literals of all sources but the tests', the shipped TOML files, quickstart and the documents.
Argument: the root of the sources."""

import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])

# A pattern, and what to write in its place.
REFUSED = [
    (r"\btell(s|ing)? (nothing|it|you|what|which|how|of)\b", "show, report, state"),
    (r"\btold (of|to|from|apart)\b", "called with, commanded, distinguished"),
    (r"\bdoes not say\b|\bsays? nothing\b", "does not record, is empty"),
    (r"\bas typed\b", "the operator's entry"),
    (r"\bnot well\b", "with findings, excluded"),
    (r"\bwhat was looked for\b", "criteria"),
    (r"\bwhere the time went\b", "time by activity"),
    (r"\bgone? on with\b|\bgoes on with\b", "continue"),
    (r"\b(is|was) worth\b(?! it)", "value of, how well"),
    (r"\bonce more\b", "again, repeat"),
    (r"\bvoid runs, too\b", "also void runs"),
    (r"\bequalized by the inverse\b", "nothing: an opinion"),
    (r"\bunfit\b", "not modelled"),
    (r"\|up [-−] down\|", "hysteresis"),
    (r"\bdistance of loading and unloading\b", "hysteresis"),
    (r"\b(zero return|equilibration map|usable range)\b", "zero deviation, map of relative sensitivity, measuring interval"),
    (r"\bmismatch\b", "non-uniformity"),
    (r"\bstd/FS\b", "s in % FS"),
    (r"\b(all|no) criteria\b", "requirements"),
    (r"ompensation error[^\n]{0,60}Eq\. \(?49", "Eq. (49) is the direct model's mean error in volt"),
]

# Where a pattern's words are names of keys, of files or of data, or not of this kind.
KEYS = {"zero return"}
ALLOWED = [
    re.compile(r"\[\[mismatch\]\]|\bunfit_taxels\b|`[^`]*\b(mismatch|unfit|zero return|raw|usable)\b[^`]*`"),
]


def literals(text):
    """String literals of a C++ source, neighbours joined as the compiler joins them, with their lines."""
    text = re.sub(r"(?m)^\s*#include.*$", "", text)
    token = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\((.*?)\)\1"|"((?:[^"\\\n]|\\.)*)"|\'(?:[^\'\\]|\\.)*\'', re.DOTALL)
    joined, line, end = None, 0, 0
    for match in token.finditer(text):
        if match.group(0)[0] in "/'":
            continue
        value = match.group(2) if match.group(2) is not None else match.group(3)
        between = text[end:match.start()]
        if joined is not None and not between.strip():
            joined += value
        else:
            if joined is not None:
                yield line, joined
            joined, line = value, text.count("\n", 0, match.start()) + 1
        end = match.end()
    if joined is not None:
        yield line, joined


def texts():
    for room in ("analysis", "bench", "devices", "db", "sequences"):
        for path in sorted((ROOT / room).rglob("*")):
            if path.suffix in (".cpp", ".h"):
                for line, text in literals(path.read_text()):
                    if " " in text and text not in KEYS:  # a word alone is a key or a name
                        yield path, line, text
            elif path.suffix == ".toml":
                for number, text in enumerate(path.read_text().splitlines(), 1):
                    if "#" in text:
                        yield path, number, text[text.index("#"):]
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        for number, text in enumerate(path.read_text().splitlines(), 1):
            yield path, number, text


def main():
    patterns = [(re.compile(pattern, re.IGNORECASE), better) for pattern, better in REFUSED]
    count, complaints = 0, []
    for path, line, text in texts():
        count += 1
        for allowed in ALLOWED:
            text = allowed.sub("", text)
        for pattern, better in patterns:
            found = pattern.search(text)
            if found:
                complaints.append(f"{path.relative_to(ROOT)}:{line}: '{found.group(0)}': write {better}")
    assert count > 5000, f"only {count} texts were found"
    # The test sees what it looks for.
    assert all(re.search(p, s, re.IGNORECASE) for p, s in ((REFUSED[0][0], "run 3 tells nothing of creep"),
                                                          (REFUSED[-1][0], "Compensation error |p - p_ref|, Eq. (49)")))
    if complaints:
        sys.exit("\n".join(complaints))
    print(f"{count} texts, none with a refused word")


main()
