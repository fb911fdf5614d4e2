#!/usr/bin/python3
"""docs/validation.md: requirements, the tests that hold them, and of ISO/IEC 17025:2017, 7.8, the page of the report with
each item. Made from the tests' names: fails where one of them is no longer there, where the page is not what is written here, or
where a report made by PROGRAM does not have an item on the page that is named (by chromium and pdftotext; not run without).

    validation.py PROGRAM [--write]
"""

import glob
import html
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAGE = os.path.join(ROOT, "docs", "validation.md")

# What people typed, to be found again on a page.
TYPED = {"laboratory": "Labname", "address": "Labstreet", "city": "Labcity", "country": "DE", "place": "Elsewhere", "accreditation": "D-K-1",
         "customer": "Custname", "customer_address": "Custstreet", "order": "Order77", "received": "2026-01-31", "condition": "Asnew",
         "mounting": "Cottonpad", "medium": "Dryair", "environment": "Twentythree", "deviations": "Nodwell", "remarks": "Remarkable",
         "signer_function": "Chieffunction", "valid_until": "2039-12-31"}
SIGNER = "Signername"

# clause, item in our words, [(page, what is looked for there: a typed word, "=" and a serial number or date, "#" and the id of a
# heading or table whose title is)], tests by their names. No page: why.
REPORT = [
    ("7.8.2.1 a", "what kind of document it is", [(1, "#document")],
     ["a calibration needs uncertainties, a certificate a number, real data and a traceable pressure besides"]),
    ("7.8.2.1 b", "name and address of the laboratory", [(1, "laboratory"), (1, "address"), (2, "laboratory")], ["laboratory: each field is its own"]),
    ("7.8.2.1 c", "where it was made, if elsewhere", [(2, "place")], ["laboratory: each field is its own"]),
    ("7.8.2.1 d", "a number of its own on every page, pages counted, a clear end", [(1, "=number"), (3, "=number"), (6, "=number")],
     ["the report of one input is always the same bytes, well-formed, inert and titled throughout",
      "each result is content of a report: when one changes, so does the number"]),
    ("7.8.2.1 e", "name and address of the customer", [(1, "customer"), (2, "customer"), (2, "customer_address")], ["laboratory: each field is its own"]),
    ("7.8.2.1 f", "the method", [(3, "#how")], ["method: what was set goes in, by the recipe and by its overrides"]),
    ("7.8.2.1 g", "the item, beyond doubt, and its condition", [(1, "=serial"), (2, "=serial"), (2, "condition")],
     ["the scanner is the one that answered, else the one registered then, else now"]),
    ("7.8.2.1 h", "when the item came", [(2, "received")], ["laboratory: each field is its own"]),
    ("7.8.2.1 i", "when it was measured", [(1, "=date"), (2, "=date")], ["dates are those of the calendar, written year, month, day, and days are counted between them"]),
    ("7.8.2.1 j", "when the report was issued", [(1, "=issued"), (6, "=issued")],
     ["a draft becomes a signed report of the same number, and a changed one names what it replaces and why"]),
    ("7.8.2.1 k", "sampling", "nothing is sampled: every taxel is measured", []),
    ("7.8.2.1 l", "results relate to the item alone", [(2, "#against-what")],
     ["the report of one input is always the same bytes, well-formed, inert and titled throughout"]),
    ("7.8.2.1 m", "the results with their units", [(1, "#readings"), (4, "#levels")],
     ["readings by hand: the worst kind of history is quoted, quantiles are values, the worst taxel is of any kind",
      "numbers for people: two digits of U, its decimal place for the value, no sign for zero, units at the end"]),
    ("7.8.2.1 n", "deviations from the method", [(3, "deviations")],
     ["a run's branches by hand: void ones with sequence, repeat, branch and attempt, those of force press",
      "a run's events by hand: which are told, as what, and when"]),
    ("7.8.2.1 o", "who authorised it", [(1, "=signer"), (6, "=signer"), (6, "signer_function")],
     ["a draft becomes a signed report of the same number, and a changed one names what it replaces and why",
      "docs: each fate of a signature is an answer, and openssl agrees"]),
    ("7.8.2.1 p", "results of others", "none is taken in", []),
    ("7.8.2.2", "what the customer stated and the laboratory did not measure", "not marked apart: what is typed in lab.toml stands under its own name", []),
    ("7.8.4.1 a", "uncertainty of the results, in their unit", [(1, "#readings"), (4, "#levels"), (6, "#kinds"), (6, "#budget")],
     ["the report's uncertainty is the one recomputed from the store",
      "U holds 92 to 98.5 % of the readings of the paper's specimen of each kind of history that it is stated for"]),
    ("7.8.4.1 b", "conditions that influence the results", [(2, "environment"), (2, "medium"), (2, "mounting")],
     ["a run's surroundings by hand: lowest, highest and number of readings of each quantity"]),
    ("7.8.4.1 c", "traceability", [(1, "=certificate"), (2, "#chain"), (2, "#instruments")],
     ["a pressure is traceable by an instrument with a certificate, in date or not dated",
      "one reference has one certificate and one due date in every part of the data, and what says FILL-IN has none"]),
    ("7.8.4.1 d", "results before and after adjustment", "page 5, where `--previous` names the earlier models",
     ["as found: judged by the limits of the report with the earlier models, and in doubt where they fail",
      "as found and as left are two results of a DCC with their states"]),
    ("7.8.4.1 e", "conformity", [(1, "=verdict")], ["judge: each requirement has its figure, limit, unit and verdict, in the order of the limits"]),
    ("7.8.4.1 f", "opinions", "none is given", []),
    ("7.8.4.3", "no interval of recalibration but the one agreed", [(1, "valid_until")],
     ["a calibration counts until the date of the laboratory, or so many months after the measurement"]),
    ("7.8.6.1", "the decision rule with its risk", [(6, "#why")],
     ["decision rules at the limit and U to either side of it", "decision rules by their names, and the probabilities that they state"]),
    ("7.8.6.2 a", "which results conformity is stated of", [(1, "=verdict")], ["every held-out run is judged, the worst one decides, and it stays with the fit"]),
    ("7.8.6.2 b", "which requirements are met and which are not", [(6, "#requirements")],
     ["judge: every run that counts is judged in turn, the worst decides, and the closest figures are named"]),
    ("7.8.6.2 c", "by which rule", [(6, "#why")], ["decision rules end with their exit codes, warn, are stored and verified"]),
    ("7.8.8", "what a changed report replaces, and why", "page 1 of the report that replaces another",
     ["report signing: a reason where another is replaced, and none otherwise"]),
]

PROGRAM_ITSELF = [
    ("A run ends in a safe state that is proven, whatever ends it",
     ["a Modbus server that falls silent, dies or never answers ends the run, and nothing proves it safe", "faults: table",
      "dead-man: a sequencer killed or stopped at 60 psi leaves a vented chamber"]),
    ("No command beyond a limit reaches an actuator", ["guard's gate: a command reaches the driver once, the set-point follows, a refused one is not sent",
                                                       "guard: the command limit holds at, below and above, and a number it has to be"]),
    ("A frame that was seen is not lost", ["kill campaign: two hundred power cuts lose nothing, double nothing and change no result"]),
    ("A change of stored data is noticed", ["one changed byte anywhere in the file is noticed, or the content reads back as it was",
                                            "header and frames hash to what another program finds"]),
    ("A resumed run is the run that it would have been", ["a run continued by another process has the hash of one written in one go"]),
    ("A fit is the same on every machine of a class", ["a fit is the same bit for bit on every level"]),
    ("U covers what it says", ["U holds 92 to 98.5 % of the readings of the harsh specimen of each kind of history that it is stated for",
                               "U holds against Monte Carlo where the inverse is linear, and is marked where it is not"]),
    ("A verdict rests on independent data that count", ["void runs, a run's own models and a run named twice are refused wherever runs are named",
                                                        "judge: errors against a reference that is overdue, or does not reach, are inconclusive, the rest is not"]),
    ("A digital certificate says what the report says", ["docs: a digital calibration certificate says what the report's data say",
                                                         "a DCC lists every taxel at every level, and one without a model is NaN in error, U and k"]),
    ("Simulated data are marked", ["banner and running head say simulated exactly when the run is simulated",
                                   "the identifier of a DCC says simulated and draft, and a later one what it replaces"]),
]


def names_of_tests():
    """Name -> source, of test cases and of tests that CMake adds."""
    found = {}
    for path in glob.glob(os.path.join(ROOT, "tests", "**", "*.cpp"), recursive=True):
        with open(path, encoding="utf-8") as file:
            for name in re.findall(r'TEST_CASE\(\s*"((?:[^"\\]|\\.|"\s*")*)"', file.read()):
                found[re.sub(r'"\s*"', "", name)] = os.path.relpath(path, ROOT)
    for path in glob.glob(os.path.join(ROOT, "tests", "**", "CMakeLists.txt"), recursive=True):
        with open(path, encoding="utf-8") as file:
            for name in re.findall(r'add_test\(NAME "([^"$]*)"', file.read()):
                found[name] = os.path.relpath(path, ROOT)
    return found


def tests_in_words(wanted, known):
    missing = [name for name in wanted if name not in known]
    assert not missing, f"no test is called: {missing}"
    return "<br>".join(f"{name} (`{known[name]}`)" for name in wanted) or "–"


def page_text(known):
    lines = ["# Validation: requirements and their tests", "",
             "Made by `tests/docs/validation.py PROGRAM --write` from the tests' names; a test of the documents fails where it is not current.",
             "`ctest -R \"NAME\"` runs one. How tests are divided: [for developers](developers.md).", "", "## The program", "", "| requirement | tests |", "|---|---|"]
    lines += [f"| {words} | {tests_in_words(tests, known)} |" for words, tests in PROGRAM_ITSELF]
    lines += ["", "## The report and ISO/IEC 17025:2017, 7.8", "",
              "The items in our words, counted as in the standard. Page: of the [report](reports.md) of a calibration, at the latest; a part begins earlier where the",
              "one before it is short.", "",
              "| item | what it asks for | page | tests |", "|---|---|---|---|"]
    for clause, words, places, tests in REPORT:
        where = places if isinstance(places, str) else ", ".join(str(page) for page in sorted({page for page, _ in places}))
        lines.append(f"| {clause} | {words} | {where} | {tests_in_words(tests, known)} |")
    return "\n".join(lines) + "\n"


def title_with_id(text, name):
    """Title of the heading, or caption of the table, with this id."""
    if name == "document":
        found = re.search(r"<h1>(.*?)</h1>", text, re.S)
    else:
        found = re.search(rf'<h\d id="{name}">(.*?)</h\d>|<table[^>]* id="{name}"[^>]*><caption>(.*?)</caption>', text, re.S)
    assert found, name
    return html.unescape(re.sub(r"<[^>]*>", " ", next(part for part in found.groups() if part is not None)))


def check_pages(program):
    def call(*words):
        done = subprocess.run([program, *words], capture_output=True, text=True, timeout=300, check=False,
                              env={**os.environ, "TACTBENCH_SHARE": ROOT})
        assert done.returncode in (0, 1, 6), (words, done.stderr)
        return done.stdout
    if not all(shutil.which(name) for name in ("chromium", "pdftotext")):
        print("pages not run: chromium, poppler-utils")
        return
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        with open("lab.toml", "w", encoding="utf-8") as file:
            file.write("schema = 1\n" + "".join(f'{key} = "{word}"\n' for key, word in TYPED.items()))
        call("demo", "-q")
        call("report", "sign", "1", "--by", SIGNER, "--lab", "lab.toml", "--issued-at", "2038-03-04", "--format", "pdf", "-o", "r.pdf", "-q")
        judgement = json.loads(call("report", "1", "--lab", "lab.toml", "-o", "r.html", "--json"))["judgement"]
        [run] = [one for one in json.loads(call("runs", "list", "--json"))["runs"] if one["run"] == 1]
        facts = {"serial": run["sensor"], "date": run["started_utc"][:10], "issued": "2038-03-04", "signer": SIGNER,
                 "certificate": "SIM-CERT-1", "verdict": judgement["overall"],
                 "number": json.loads(call("report", "list", "--json"))["reports"][0]["number"]}
        with open("r.html", encoding="utf-8") as file:
            text = file.read()
        pages = subprocess.run(["pdftotext", "r.pdf", "-"], capture_output=True, text=True, check=True).stdout.split("\f")
        squeezed = [re.sub(r"[\s-]+", "", page).lower() for page in pages]
        for clause, _, places, _ in REPORT:
            for page, what in places if not isinstance(places, str) else []:
                word = facts[what[1:]] if what[0] == "=" else title_with_id(text, what[1:]) if what[0] == "#" else TYPED[what]
                first = page if what == "=number" else 1  # what precedes may be short
                assert any(re.sub(r"[\s-]+", "", word).lower() in one for one in squeezed[first - 1:page]), (clause, page, what, word)


def main():
    program, text = os.path.abspath(sys.argv[1]), page_text(names_of_tests())
    if "--write" in sys.argv:
        with open(PAGE, "w", encoding="utf-8") as file:
            file.write(text)
    with open(PAGE, encoding="utf-8") as file:
        assert file.read() == text, "docs/validation.md is not current: tests/docs/validation.py PROGRAM --write"
    check_pages(program)
    print(f"{len(REPORT)} items of ISO/IEC 17025, {len(PROGRAM_ITSELF)} requirements")


main()
