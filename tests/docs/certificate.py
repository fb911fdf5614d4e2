#!/usr/bin/python3
"""A report as a digital calibration certificate: what a reader that knows only the schema finds in it is what the
report's data say, and what the schema does not check holds: lengths of lists, units, references, languages.

    certificate.py PROGRAM

Validation takes the schema's folder, with a catalogue, from TACTBENCH_DCC_SCHEMA; without it that part is not run.
"""

import json
import math
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ET

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(sys.argv[1])
SCHEMA = os.environ.get("TACTBENCH_DCC_SCHEMA", "")
D, S = "{https://ptb.de/dcc}", "{https://ptb.de/si}"
KPA = 6.894757293168361  # of a psi
UNITS = {r"\kilo\pascal", r"\one", r"\degreecelsius"}
LARGEST, SLOWEST_S = 450_000, 0.050  # for each kind of history
LAB = """schema = 1
laboratory = "Test & Measure <Ltd>"
city = "Sample Town"
country = "DE"
customer = " Robots "
customer_address = "1 Sample Street"
"""


def call(*words, codes=(0, 1, 6)):
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, timeout=300, check=False,
                          env={**os.environ, "TACTBENCH_SHARE": ROOT})
    assert done.returncode in codes, (words, done.returncode, done.stderr)
    return done


def numbers(element, name):
    return [float(word) for found in element.iter(S + name) for word in found.text.split(" ")]


def kind_of(result):
    return result.findtext(f"{D}name/{D}content").split("Kind of history: ")[1]


def readings(tree):
    """(kind, direction, kPa) -> (names of taxels, error, U, k), by the schema alone."""
    found = {}
    for result in tree.iter(D + "measurementResult"):
        if result.get("refType") != "tb_kind":
            continue
        for top in result.findall(f"{D}results/{D}result/{D}data/{D}list"):
            names = top.findtext(f"{D}quantity/{D}charsXMLList").split(" ")
            for level in top.findall(D + "list"):
                quantities = {one.get("refType"): one for one in level.findall(D + "quantity")}
                kpa = float(quantities["basic_referenceValue"].findtext(f"{S}real/{S}value"))
                error = quantities["basic_measurementError"].find(S + "realListXMLList")
                lists = [numbers(error, one) for one in ("valueXMLList", "valueExpandedMUXMLList", "coverageFactorXMLList")]
                assert {len(names)} == {len(one) for one in lists}
                assert len(numbers(error, "coverageProbabilityXMLList")) == len(error.findtext(S + "unitXMLList").split()) == 1
                found[kind_of(result), top.findtext(f"{D}name/{D}content"), kpa] = (names, *lists)
    return found


def check_beyond_the_schema(tree):
    units = {word for one in tree.iter() if one.tag in (S + "unit", S + "unitXMLList") for word in one.text.split()}
    assert units <= UNITS, units - UNITS
    ids = [one.get("id") for one in tree.iter() if one.get("id")]
    assert len(ids) == len(set(ids))
    assert {word for one in tree.iter() for word in (one.get("refId") or "").split()} <= set(ids)
    prefixes = {one.text for one in tree.iter(D + "namespace")} | {"basic"}
    assert {word.split("_")[0] for one in tree.iter() for word in (one.get("refType") or "").split()} <= prefixes
    declared = {one.text for one in tree.iter(D + "usedLangCodeISO639_1")}
    assert {one.get("lang") for one in tree.iter(D + "content") if one.get("lang")} == declared
    assert all(one.text and one.text.strip() == one.text for one in tree.iter(D + "content"))
    core = tree.find(f".//{D}coreData")
    assert core.findtext(D + "beginPerformanceDate") <= core.findtext(D + "endPerformanceDate")
    for result in tree.iter(D + "measurementResult"):
        methods = [one.get("refType") for one in result.iter(D + "usedMethod")]
        assert "basic_calibrationMethod" in methods and result.find(D + "influenceConditions") is not None
        assert ("basic_uncertainty" in methods) == (result.get("refType") == "tb_kind")


def check_against_data(tree, data):
    """Every kind, level and direction is there; ten drawn taxels and levels agree; no figure is invented or lost."""
    found = readings(tree)
    kinds = [one for one in data["sections"]["uncertainty"]["reading"]["conditions"] if one["valid"]]
    assert {one["name"] for one in kinds} == {kind for kind, _, _ in found}
    assert len(found) == sum(len(one["pressure_psi"]) for one in kinds)
    draw = random.Random(20)
    missing = 0
    for kind in kinds:
        assert kind["factor"] >= 1.0
        for level, (psi, branch) in enumerate(zip(kind["pressure_psi"], kind["branch"])):
            direction = {"up": "increasing", "down": "decreasing"}[branch]
            key = min((key for key in found if key[:2] == (kind["name"], direction)), key=lambda one: abs(one[2] - psi * KPA))
            names, error, expanded, factor = found[key]
            assert math.isclose(key[2], psi * KPA, rel_tol=1e-5, abs_tol=1e-6)
            for taxel in draw.sample(range(len(names)), 10):
                columns = data["results"]["model"]["columns"]
                assert names[taxel] == f"{taxel // columns},{taxel % columns}"
                known = [kind[one][level * len(names) + taxel] for one in ("taxel_error_psi", "taxel_expanded_psi")]
                if None in known:
                    assert all(math.isnan(one[taxel]) for one in (error, expanded, factor))
                    continue
                assert math.isclose(error[taxel], known[0] * KPA, rel_tol=2e-4), (kind["name"], psi, branch, taxel)
                assert math.isclose(expanded[taxel], known[1] * KPA, rel_tol=1e-3)
                assert math.isclose(factor[taxel], kind["factor"], abs_tol=5e-4)
            excluded = {index for index, one in enumerate(data["results"]["model"]["taxels"]) if one["status"] != "fitted"}
            for one in (error, expanded, factor):
                assert excluded <= {index for index, value in enumerate(one) if math.isnan(value)}
            missing += len(excluded)
    return len(kinds), missing


def check_verdicts(tree, data):
    words = {"pass": "pass", "conditional pass": "conditionalPass", "conditional fail": "conditionalFail", "fail": "fail"}
    stated = [one.findtext(D + "conformity") for one in tree.iter(D + "metaData")]
    judged = [words.get(one["verdict"]) if not data["results"]["judgement"]["not_judged"] else None
              for one in data["results"]["verdicts"]]
    assert stated == judged
    for one in [*tree.iter(D + "metaData"), tree.find(f".//{D}statement[@refType='basic_conformity']")]:
        assert one.find(D + "conformity") is not None or one.find(f"{D}declaration/{D}content") is not None


def check_pdf():
    """The PDF has both files in it, byte for byte, is the same each time, and its code leads to the report."""
    if not all(shutil.which(name) for name in ("chromium", "pdfdetach", "pdftoppm", "zbarimg")):
        print("not run: chromium, poppler-utils, zbar-tools")
        return
    for name in ("one.pdf", "two.pdf"):
        call("report", "1", "--lab", "lab.toml", "--format", "pdf", "-o", name, "-q")
    with open("one.pdf", "rb") as one, open("two.pdf", "rb") as other:
        text = one.read()
        assert text == other.read()
    assert text.count(b"/AFRelationship /Data") == 2 and b"pdfaid" not in text
    os.mkdir("attached")
    subprocess.run(["pdfdetach", "-saveall", "-o", "attached", "one.pdf"], check=True)
    assert sorted(os.listdir("attached")) == ["certificate.xml", "report.json"]
    for inside, outside in (("certificate.xml", "first.xml"), ("report.json", "r.json")):
        with open(os.path.join("attached", inside), "rb") as one, open(outside, "rb") as other:
            assert one.read() == other.read(), inside
    subprocess.run(["pdftoppm", "-r", "200", "-f", "1", "-l", "1", "-png", "-singlefile", "one.pdf", "page"], check=True)
    read = subprocess.run(["zbarimg", "-q", "--raw", "page.png"], capture_output=True, text=True, check=True).stdout.splitlines()
    with open("r.json", encoding="utf-8") as file:
        told = json.load(file)
    assert told["number"] in read[0] and read[1].endswith(told["content_sha256"])
    # What a laboratory file lacks for a certificate is said, and the PDF is made.
    assert "city" in call("report", "1", "--lab", "bare.toml", "--format", "pdf", "-o", "bare.pdf", "-q").stderr


def validate(name, kinds):
    if not SCHEMA:
        print("not run: TACTBENCH_DCC_SCHEMA names no folder of the schema")
        return
    catalog = {**os.environ, "XML_CATALOG_FILES": os.path.join(SCHEMA, "catalog.xml")}
    words = ["xmllint", "--nonet", "--noout", "--schema", os.path.join(SCHEMA, "dcc.xsd"), name]
    begin = time.clock_gettime(time.CLOCK_MONOTONIC), os.times()
    done = subprocess.run(words, capture_output=True, text=True, check=False, env=catalog)
    assert done.returncode == 0, done.stderr[:2000]
    used = sum(os.times()[2:4]) - sum(begin[1][2:4])
    assert used <= SLOWEST_S * max(1, kinds) + 0.01, used  # 0.01: what a clock tick is
    print(f"valid; {used:.2f} s of processor time, {kinds} kinds of history")


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    with open("lab.toml", "w", encoding="utf-8") as file:
        file.write(LAB)
    with open("bare.toml", "w", encoding="utf-8") as file:
        file.write("schema = 1\n")
    call("demo", "-q")
    refused = call("report", "1", "--lab", "bare.toml", "--format", "dcc", codes=(2,)).stderr
    assert all(key in refused for key in ("TB-REPORT-DCC", "country", "city", "customer_address")), refused
    call("report", "1", "--format", "dcc", "--compare", "2", codes=(2,))
    for name in ("first", "second"):
        call("report", "1", "--lab", "lab.toml", "--format", "dcc", "-o", name + ".xml", "-q")
    with open("first.xml", "rb") as one, open("second.xml", "rb") as other:
        assert one.read() == other.read()
    call("report", "1", "--lab", "lab.toml", "--format", "json", "-o", "r.json", "-q")
    with open("r.json", encoding="utf-8") as file:
        report = json.load(file)
    root = ET.parse("first.xml").getroot()
    assert root.findtext(f".//{D}uniqueIdentifier") == "SIMULATED-DRAFT-" + report["number"]
    assert root.find(f".//{D}statement[@refType='tb_simulated']") is not None
    check_beyond_the_schema(root)
    check_verdicts(root, report)
    count, _ = check_against_data(root, report)
    assert count >= 1
    size = os.path.getsize("first.xml")
    assert size <= LARGEST * count, size
    validate("first.xml", count)
    print(f"{size} bytes")
    check_pdf()
    # Signed it has a file of its own, the signer in it, and is no draft.
    call("report", "sign", "1", "--lab", "lab.toml", "--format", "dcc", "--by", "C. Chief", "-q")
    signed = os.path.join("reports", f"run-{report['number']}.xml")
    root = ET.parse(signed).getroot()
    assert root.findtext(f".//{D}uniqueIdentifier") == "SIMULATED-" + report["number"]
    assert root.findtext(f".//{D}respPerson/{D}person/{D}name/{D}content") == "C. Chief"
    assert root.find(f".//{D}issueDate") is not None
    call("report", "verify", signed, codes=(0,))
    validate(signed, count)
