#!/usr/bin/python3
"""The schemas of docs/schema hold for what PROGRAM writes: reports and exports of a calibration, of a pressed object and of a
table.

    schemas.py PROGRAM
"""

import copy
import json
import os
import subprocess
import sys
import tempfile

import jsonschema

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(sys.argv[1])


def call(*words):
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, timeout=300, check=False,
                          env={**os.environ, "TACTBENCH_SHARE": ROOT})
    assert done.returncode in (0, 1, 6), (words, done.returncode, done.stderr)


def loaded(name):
    with open(name, encoding="utf-8") as file:
        return json.load(file)


def validator(name):
    schema = loaded(os.path.join(ROOT, "docs", "schema", name + ".schema.json"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def check(kind, name):
    document, schema = loaded(name), validator(kind)
    errors = [f"{name}: {'/'.join(map(str, error.absolute_path))}: {error.message[:200]}" for error in schema.iter_errors(document)]
    assert not errors, "\n".join(errors[:5])
    for key in list(document):  # a document that lacks a member, or has another one, is not valid
        less = copy.copy(document)
        del less[key]
        assert not schema.is_valid(less) or key not in schema.schema["required"], key
    assert not schema.is_valid({**document, "unknown": 1})


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    call("init", "--operator", "test")
    call("calibrate", "S-1", "--minutes", "12", "-q")
    call("run", "ring", "--sensor", "S-1", "--yes", "-q")
    for run in ("1", "3"):
        call("report", run, "--format", "json", "-o", f"report-{run}.json", "-q")
        check("report", f"report-{run}.json")
    for run in ("1", "2", "3"):
        call("runs", "export", run, "--format", "json", "-o", f"run-{run}.json", "-q")
        check("run", f"run-{run}.json")
    with open("loop.csv", "w", encoding="utf-8") as table:
        loop = [(x, x / 20) for x in range(61)] + [(x, x / 20 + x * (60 - x) / 2000) for x in range(60, -1, -1)]
        table.write("input,output\n" + "".join(f"{x},{y}\n" for x, y in 3 * loop))
    call("runs", "import", "loop.csv", "-q")
    call("fit", "4", "-q")
    call("report", "4", "--format", "json", "-o", "table.json", "-q")
    check("table-report", "table.json")
