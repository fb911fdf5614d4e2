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
     ["report title: a calibration needs U, a certificate also accreditation, real data and traceability"]),
    ("7.8.2.1 b", "name and address of the laboratory", [(1, "laboratory"), (1, "address"), (2, "laboratory")], ["laboratory: each field has its own key"]),
    ("7.8.2.1 c", "where it was made, if elsewhere", [(2, "place")], ["laboratory: each field has its own key"]),
    ("7.8.2.1 d", "a number of its own on every page, pages counted, a clear end", [(1, "=number"), (3, "=number"), (6, "=number")],
     ["report: one input always gives the same bytes, well-formed, inert and with titles",
      "report number: changes when any result changes"]),
    ("7.8.2.1 e", "name and address of the customer", [(1, "customer"), (2, "customer"), (2, "customer_address")], ["laboratory: each field has its own key"]),
    ("7.8.2.1 f", "the method", [(3, "#how")], ["method text: states the settings of the recipe and its overrides"]),
    ("7.8.2.1 g", "the item, beyond doubt, and its condition", [(1, "=serial"), (2, "=serial"), (2, "condition")],
     ["scanner serial: is that of the scanner that answered, else the run's, else the sensor's present one"]),
    ("7.8.2.1 h", "when the item came", [(2, "received")], ["laboratory: each field has its own key"]),
    ("7.8.2.1 i", "when it was measured", [(1, "=date"), (2, "=date")], ["dates: only calendar dates as year, month, day are accepted, and days between them are counted"]),
    ("7.8.2.1 j", "when the report was issued", [(1, "=issued"), (6, "=issued")],
     ["report: a signed draft keeps its number, and a changed report names what it replaces and why"]),
    ("7.8.2.1 k", "sampling", "nothing is sampled: every taxel is measured", []),
    ("7.8.2.1 l", "results relate to the item alone", [(2, "#against-what")],
     ["report: one input always gives the same bytes, well-formed, inert and with titles"]),
    ("7.8.2.1 m", "the results with their units", [(1, "#readings"), (4, "#levels")],
     ["reading errors: the worst kind of history is quoted, the worst taxel is over all kinds",
      "report values: are rounded to two digits of U, have no negative zero and end with the unit"]),
    ("7.8.2.1 n", "deviations from the method", [(3, "deviations")],
     ["run branches: void ones are listed with repeat, branch and attempt, those with forces mark a press run",
      "run events: those to be reported are listed with kind, time and text"]),
    ("7.8.2.1 o", "who authorised it", [(1, "=signer"), (6, "=signer"), (6, "signer_function")],
     ["report: a signed draft keeps its number, and a changed report names what it replaces and why",
      "docs: each fate of a signature is an answer, and openssl agrees"]),
    ("7.8.2.1 p", "results of others", "none is taken in", []),
    ("7.8.2.2", "what the customer stated and the laboratory did not measure", "not marked apart: what is typed in lab.toml stands under its own name", []),
    ("7.8.4.1 a", "uncertainty of the results, in their unit", [(1, "#readings"), (4, "#levels"), (6, "#kinds"), (6, "#budget")],
     ["report: its uncertainty equals the one recomputed from the store",
      "U covers 92 to 98.5 % of readings of the paper specimen, for each kind of history that it is stated for"]),
    ("7.8.4.1 b", "conditions that influence the results", [(2, "environment"), (2, "medium"), (2, "mounting")],
     ["run environment: lowest, highest and number of readings are given per quantity"]),
    ("7.8.4.1 c", "traceability", [(1, "=certificate"), (2, "#chain"), (2, "#instruments")],
     ["traceability: pressure needs a separate reference with a certificate that is not overdue",
      "report: a reference has one certificate and due date in all parts, FILL-IN counts as none"]),
    ("7.8.4.1 d", "results before and after adjustment", "page 5, where `--previous` names the earlier models",
     ["as found: earlier models are judged by the limits of the report, and results are in doubt if they fail",
      "DCC: as found and as left are two results with their states"]),
    ("7.8.4.1 e", "conformity", [(1, "=verdict")], ["judge: gives each requirement its value, limit and verdict, in the order of the limits"]),
    ("7.8.4.1 f", "opinions", "none is given", []),
    ("7.8.4.3", "no interval of recalibration but the one agreed", [(1, "valid_until")],
     ["report validity: ends at the laboratory's date, or the stated months after the measurement"]),
    ("7.8.6.1", "the decision rule with its risk", [(6, "#why")],
     ["decision rules: give the expected verdict at the limit and U to either side of it", "decision rules: convert to and from names, and their text states the probabilities"]),
    ("7.8.6.2 a", "which results conformity is stated of", [(1, "=verdict")], ["verdicts: every held-out run is judged, the worst decides, and it is stored with the fit"]),
    ("7.8.6.2 b", "which requirements are met and which are not", [(6, "#requirements")],
     ["judge: every run that counts is judged in order, the worst decides, and the closest values are named"]),
    ("7.8.6.2 c", "by which rule", [(6, "#why")], ["decision rules: give their exit codes and warnings, and are stored and verified"]),
    ("7.8.8", "what a changed report replaces, and why", "page 1 of the report that replaces another",
     ["report signing: needs a reason if it replaces a report, and rejects a reason otherwise"]),
]

PROGRAM_ITSELF = [
    ("A run ends in a safe state that is proven, whatever ends it",
     ["run: an instrument or the chamber that fails ends it, vented if the module answers, with frames kept", "faults: table",
      "dead-man: after the sequencer is killed or stopped at 60 psi the chamber is vented"]),
    ("No command beyond a limit reaches an actuator", ["guard gate: a command reaches the driver once and sets the set-point, a refused one is not sent",
                                                       "guard: accepts pressures from 0 to the command limit, and rejects values that are not finite"]),
    ("A frame that was seen is not lost", ["kill campaign: two hundred power cuts lose nothing, duplicate nothing and change no result"]),
    ("A change of stored data is noticed", ["content check: one changed byte anywhere in the file is detected, or does not change the content",
                                            "content hash: header and frames have the hashes that another program computed"]),
    ("A resumed run is the run that it would have been", ["content hash: a run continued by another process has the hash of one written in one go"]),
    ("A fit is the same on every machine of a class", ["ELAM lanes: match the scalar model, with equal bits whatever slopes are asked for and whichever the lane"]),
    ("U covers what it says", ["U covers 92 to 98.5 % of readings of the harsh specimen, for each kind of history that it is stated for",
                               "U of a reading: agrees with Monte Carlo if the inverse is linear, and is marked if it is not"]),
    ("A verdict rests on independent data that count", ["verdicts: void runs, runs of the models and runs named twice are rejected by every verb",
                                                        "judge: errors are inconclusive if the reference is overdue or out of its range, other values are not"]),
    ("A digital certificate says what the report says", ["docs: a digital calibration certificate says what the report's data say",
                                                         "DCC: every taxel is listed at every level, and is NaN in error, U and k without a model"]),
    ("Simulated data are marked", ["report: banner and page header say simulated exactly if a run is simulated",
                                   "DCC: the identifier states simulated and draft, and a later report states which one it replaces"]),
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
             "Made by `tests/docs/validation.py PROGRAM --write` from the tests' names;",
             "a test of the documents fails when this page is out of date.",
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
