#!/usr/bin/python3
"""The page of layouts, docs/reference-formats.md: views of the store, a run as CSV, JSON and HDF5, the model document.

    formats.py PROGRAM            compares the page with what it would be now, and ends with 1 where it differs
    formats.py PROGRAM --write    writes it

Columns, keys and members are those of files that PROGRAM has just written. What a name is stands in the page alone, once for all
layouts, for a name means the same in all of them: --write keeps it, and leaves a `?` for a new name, which is a failure.
HDF5 is what the package for Python writes (python3-h5py).
"""

import json
import os
import re
import sqlite3
import subprocess
import sys
import tempfile

import h5py

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAGE = os.path.join(ROOT, "docs", "reference-formats.md")


def committed_page():
    with open(PAGE, encoding="utf-8") as file:
        return file.read()


def meanings():
    """What the page says of each name."""
    names = committed_page().split("\n## Names\n", 1)[1].split("\n## ", 1)[0]
    return dict(re.findall(r"^\| `([^`]+)` \| (.*) \| [^|]* \|$", names, re.M))


RECIPE = """schema = 1
name = "small"
unit = "psi"
turning_points = [0, 60, 20, 60, 0]
step = 20
repeats = 1
"""
PRESS = """schema = 1
name = "touch"
kind = "press"
repeats = 1
dwell_s = 0.5
[press]
object = "ring"
forces_n = [2]
positions_mm = [[30, 30]]
"""


def make_files(program, folder):
    def run(*words):
        done = subprocess.run([program, *words], cwd=folder, capture_output=True, text=True, timeout=600)
        if done.returncode:
            sys.exit(f"tactbench {' '.join(words)}: {done.stderr}")
    for name, text in (("small.toml", RECIPE), ("touch.toml", PRESS)):
        with open(os.path.join(folder, name), "w") as file:
            file.write(text)
    run("init")
    run("sensors", "add", "S-1")
    common = ["--bench", "bench.toml", "--sensor", "S-1", "--operator", "me", "-q", "--yes", "--no-seating"]
    run("run", "small.toml", *common)
    run("run", "touch.toml", *common)
    run("fit", "1", "--model", "elam", "-o", "model.json")
    for kind in ("csv", "json"):
        run("runs", "export", "2", "--format", kind, "-o", "run." + kind)


def view_columns(folder):
    store = sqlite3.connect(f"file:{folder}/runs.db?mode=ro", uri=True)
    views = [row[0] for row in store.execute("SELECT name FROM sqlite_master WHERE type = 'view' ORDER BY name")]
    return {view: [column[1] for column in store.execute(f"PRAGMA table_info({view})")] for view in views}


def csv_columns(folder):
    with open(os.path.join(folder, "run.csv")) as file:
        lines = file.read().splitlines()
    head = [line for line in lines if line.startswith("#")]
    columns = []
    for name in lines[len(head)].split(","):
        name = re.sub(r"_r\d+_c\d+$", "_rR_cC", name)
        if name not in columns:
            columns.append(name)
    return head, columns


def json_tree(value, path=""):
    """Path of each key, lists by their first item; what a tree of another's words holds is left to it."""
    closed = ("detail", "calibration", "options", "validity", "patterns", "metadata")
    if isinstance(value, list):
        value = value[0] if value else None
        path += "[]"
    if not isinstance(value, dict):
        return []
    out = []
    for key, inner in value.items():
        here = f"{path}.{key}" if path else key
        out.append(here)
        if key not in closed:
            out += json_tree(inner, here)
    return out


def written_hdf5(program, folder):
    os.environ.setdefault("TACTBENCH_COMPENSATOR", os.path.join(os.path.dirname(program), "libtactbench_compensator.so.1"))
    sys.path[:0] = [os.path.join(ROOT, "analysis", "python"), os.path.join(ROOT, "analysis", "compensate", "python")]
    import tactbench
    tactbench.to_nexus(os.path.join(folder, "runs.db"), 2, os.path.join(folder, "run.hdf5"))
    return os.path.join(folder, "run.hdf5")


def hdf5_tree(path):
    """[path, type, shape] of each group, data set and attribute, by name."""
    shapes = {0: "one", 1: "a row each", 2: "rows × members", 4: "frame × scan × row × column"}
    out, first = [], {}  # first: the name under which an object came

    def take(group):
        first[h5py.h5o.get_info(group.id).addr] = group.name
        out.append([group.name, "group", ""])
        out.extend([f"{group.name} @{name}", "attribute", ""] for name in sorted(group.attrs))
        for item in group.values():
            known = first.setdefault(h5py.h5o.get_info(item.id).addr, item.name)
            if known != item.name:
                out.append([item.name, f"is `{without_numbers(known)}`", ""])
            elif isinstance(item, h5py.Group):
                take(item)
            else:
                out.append([item.name, "text" if item.dtype.kind == "O" else item.dtype.name, shapes[item.ndim]])

    with h5py.File(path) as file:
        for name in sorted(file, key=lambda name: name == "entry"):  # which has second names of the others
            take(file[name])
        out.extend([f"/ @{name}", "attribute", ""] for name in sorted(file.attrs))
    return out


def without_numbers(path):
    path = re.sub(r"(/entry/instrument/)\w+_\d+", r"\1ROLE_N", path)
    return re.sub(r"/\d+(?=/|$| )", "/N", path)


def page(program, folder):
    make_files(program, folder)
    places = {}

    def stands(name, where):
        places.setdefault(name, [])
        if where not in places[name]:
            places[name].append(where)
    body = ""
    for view, columns in view_columns(folder).items():
        body += f"- `{view}`: " + ", ".join(f"`{column}`" for column in columns) + "\n"
        for column in columns:
            stands(column, f"`{view}`")
    head, columns = csv_columns(folder)
    csv = ("`runs export N -o run.csv` writes lines that begin with `#`, then one line of names, then a line a scan. What was not\n"
           "measured is empty. The lines with `#`: " +
           ", ".join(f"`{line[2:].split(':')[0]}`" for line in head) + ";\n`metadata KEY` stands for each key of metadata. The columns: " +
           ", ".join(f"`{column}`" for column in columns) + ".\n")
    for column in columns:
        stands(column, "CSV")
    trees = ""
    for title, file in (("A run: `runs export N --format json -o run.json`", "run.json"),
                        ("ELAM as a document: `fit --model elam -o model.json`, `model export`", "model.json")):
        with open(os.path.join(folder, file)) as text:
            paths = json_tree(json.load(text))
        short = "JSON" if file == "run.json" else "model"
        trees += f"\n### {title}\n" + ", ".join(f"`{path}`" for path in paths) + "\n"
        for path in paths:
            name = re.split(r"[.\]]", path.rstrip("[]"))[-1]
            stands(name, short)
    seen = []
    for path, kind, shape in hdf5_tree(written_hdf5(program, folder)):
        entry = (without_numbers(path), kind, shape)
        if entry not in seen:
            seen.append(entry)
    hdf5 = "| member | type | shape |\n|---|---|---|\n"
    attributes = {}
    for path, kind, shape in seen:
        if kind == "attribute":
            holder, name = path.split(" @")
            attributes.setdefault(holder, []).append(name)
        else:
            hdf5 += f"| `{path}` | {kind} | {shape} |\n"
            name = path.split("/")[-1]
        if name != "N":
            stands(name, "HDF5")
    hdf5 += "\nAttributes: " + "; ".join(f"of `{holder}`: " + ", ".join(f"`{name}`" for name in names)
                                         for holder, names in attributes.items()) + ".\n"
    known = meanings()
    names = "| name | is | stands in |\n|---|---|---|\n"
    for name in sorted(places, key=str.lower):
        names += f"| `{name}` | {known.get(name, '?')} | {', '.join(places[name])} |\n"
    return ("# Layouts\n\nMade by `tests/docs/formats.py` from files that the program has written. A name means the same wherever it "
            "stands; its ending is its unit\n(`_psi`, `_n` N, `_nmm` N mm, `_mm`, `_s`, `_ns`, `_us` µs, `_v` V, `_v2` V², `_fs` shares of full scale). "
            "[The store](store.md) has examples.\n\n"
            "## Names\n" + names +
            "\n## Views of the store\nRead-only, for SQL: `sqlite3 -readonly runs.db \"SELECT ... FROM v_runs\"`. Metadata are tags with a `=`: "
            "`film=B12 lot=A7`.\n\n" + body +
            "\n## A run as CSV\n" + csv +
            "\n## JSON\nEvery verb prints one document with `--json`, which begins with `schema` (`tactbench.VERB`) and `version`; an error has the "
            "schema `tactbench.error`,\nwith `id`, `exit_code`, `cause`, `message`, `where`, `remedy` and `rig_state`. A `[]` stands for each item of a list.\n" + trees +
            "\n## A run as HDF5\n`tactbench.to_nexus(store, run, file)` of the [package for Python](python.md). Numbers that are not known are NaN; truth is "
            "0 or 1;\n`N` counts from 0.\n\n" + hdf5)


program, *options = sys.argv[1:]
with tempfile.TemporaryDirectory() as scratch:
    made = page(os.path.abspath(program), scratch)
if options == ["--write"]:
    with open(PAGE, "w", encoding="utf-8") as file:
        file.write(made)
    sys.exit(0)
if committed_page() != made:
    sys.exit("docs/reference-formats.md is not what the program writes: tests/docs/formats.py build/tactbench --write")
if "| ? |" in made:
    sys.exit("docs/reference-formats.md: a name without a meaning")
print("the page of layouts is true")
