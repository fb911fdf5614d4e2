#!/usr/bin/python3
"""The page of layouts, docs/reference-formats.md: views of the store, a run as CSV, JSON and HDF5, the model document.

    formats.py PROGRAM            compares the page with what it would be now, and ends with 1 where it differs
    formats.py PROGRAM --write    writes it

Columns, keys and members are those of files that PROGRAM has just written; MEANING says of each name what it is, once for all
layouts, for a name means the same in all of them. A name without a meaning is a failure, and so is a meaning without a name.
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

MEANING = {
    "NX_class": "class of the group, by NeXus", "axes": "by NeXus: dimensions of the signal", "begun_utc": "when the night began",
    "channel": "dimension: raw channels of the force sensor", "check": "dimension: checks of the run",
    "column": "dimension: columns of the array", "component": "dimension: components of a wrench", "data": "by NeXus: `/frames` by another name",
    "default": "by NeXus: the group that a viewer opens first", "description": "of a device that is no sensor: maker and model",
    "direction": "dimension: x, y, z", "end_time": "when the run ended (UTC)", "entry": "by NeXus: the run, by other names",
    "entry_identifier_uuid": "UUID of the run", "event": "dimension: events of the run", "first_run": "first run of the scenario in this store",
    "frames_pruned": "frames that `db prune` removed", "instrument": "by NeXus: the bench and its devices", "judgement": "dimension: verdicts of the run",
    "label": "scenario and seed", "measurement": "quantity that a sensor measures", "night": "number of the night in this store",
    "poll": "dimension: readings of pressure between frames", "program": "version of the program", "program_name": "tactbench",
    "pruned_utc": "when `db prune` removed the frames; empty: they are there", "result_json": "the scenario's figures as measured",
    "residual_psi": "what the taxel's model leaves, rms", "row": "dimension: rows of the array", "sample": "by NeXus: the tactile sensor",
    "ROLE_N": "a device by its role, with its number among the run's devices", "serial_number": "of a device", "shard": "part of the night, from 1",
    "shards": "number of parts of the night; 1: the whole night", "signal": "by NeXus: the data set that a viewer shows", "start_time": "when the run began (UTC)",
    "suite": "name of the suite of scenarios", "target": "by NeXus: the first name of a group with two", "title": "the run in a line",
    "user": "by NeXus: the operator",
    "alpha_a0": "ELAM's parameter (Eq. 21)", "alpha_a1": "ELAM's parameter (Eq. 21), in one over the input's unit",
    "alpha_d": "ELAM's parameter (Eq. 14)", "beta_a": "ELAM's parameter (Eq. 22)", "beta_d": "ELAM's parameter (Eq. 15)",
    "ascending": "outputs of the rising external branch, over `x`", "descending": "outputs of the falling external branch, over `x`",
    "dead_band": "change of the output that compensation does not follow", "figures": "of the fit",
    "full_scale": "range of the outputs that were fitted", "gain": "factor of an adjusted model; 1 else",
    "j": "sum of squares of the fit, in the output's unit squared", "loop_low": "lowest output of the external loop",
    "max_error": "largest residual", "mean_error": "mean residual", "noise": "standard deviation of a sample; 0: not known",
    "parameters": "by name", "parent": "of an adjusted model: the one before", "samples": "that were fitted", "starts": "of the search",
    "undetermined": "parameters that the data leave open", "x": "inputs of the external loop", "zero": "offset of an adjusted model; 0 else",
    "adjustment": "of an adjusted model: what was moved", "at_bound": "parameters of the fit that ended at a bound",
    "attempt": "of the branch: 0 the first, 1 the first repetition",
    "bench": "id of the bench", "bench_id": "id of the bench", "bench_sha256": "of the bench file", "bench_toml": "the bench file",
    "branch": "within the repeat, from 0; in HDF5 the row of `/branches`", "branches": "each branch with its attempts",
    "build_id": "build of the program", "calibrated": "date of the calibration", "calibrated_by": "who calibrated it",
    "calibration": "what the bench file and the instrument state, as a tree", "calibration_json": "the same as JSON",
    "certificate": "number of the calibration certificate", "chain_sha256": "link of the hash chain up to this frame",
    "checks": "seating, warm-up, conditioning, mount, tare: what was found", "columns": "columns of the array",
    "configuration": "the files of the run as texts",
    "content_sha256": "hash of the run's content; of a model: of the run or table it was fitted on",
    "counts": "raw counts of the converter: scans × rows × columns; a blob is uint16, little-endian",
    "counts_rR_cC": "raw counts of row R and column C", "criterion": "what was judged", "detail": "in words, or as a tree",
    "detail_json": "as JSON", "device_time_us": "the scanner's own clock", "devices": "the instruments",
    "dtype": "how `counts` are held", "due": "last day that the calibration holds", "ended_utc": "end, by the wall clock",
    "events": "what happened, in order", "exchanges": "exchanges with instruments that the frame took",
    "falling": "true: the output falls when the input rises", "feedback_counts": "raw counts of the regulator's monitor",
    "feedback_psi": "pressure by the regulator's monitor", "firmware": "as the instrument reports it",
    "fit": "number of the fit in the store", "flags": "what makes it incomparable: dwell, left-band, retried ...; empty: nothing",
    "force_start_n": "force at the dwell's start", "frame": "the frame's place in the run, from 1; in HDF5 the row of `/frames`",
    "frames": "of the run: how many, or the frames themselves", "frames_per_repeat": "frames planned in a repeat",
    "from_n": "force at which the branch began; pressures are then 0", "from_psi": "pressure at which it began",
    "fx_n": "force along x", "fy_n": "force along y", "fz_n": "force along z",
    "git_commit": "commit of the program", "git_dirty": "1: built from a modified source", "host": "computer",
    "id": "identifier TB-..., where there is one", "in_band_ns": "time in band before the frame",
    "in_band_s": "time in band before the frame", "input": "inputs of a table, in its order", "kind": "of an event or a check", "limit": "that it was judged by", "limit_value": "that it was judged by", "limits_sha256": "of the limits file",
    "metadata": "lot, order and others, by key", "model": "maker and model; of a fit: kind of model", "name": "name",
    "notes": "lines that people added", "operator": "who ran it",
    "options": "how the models were fitted", "ordinal": "of the branch, from 0",
    "origin": "simulated, hardware or imported", "outcome": "how the run ended", "output": "outputs of a table, in its order",
    "overdue": "true: the run was made after the due date",
    "overrides": "what --set changed", "overrides_json": "what --set changed, as JSON", "place_mm": "x, y, z of the stage", "polls": "readings of pressure since the frame before",
    "position": "the frame's place in the run, from 1", "program_version": "version of the program", "purpose": "why, in the operator's words",
    "reason": "of the outcome", "recipe": "name of the recipe", "recipes": "the recipes, in their order",
    "reference_counts": "raw counts of the reference", "reference_psi": "pressure by the reference: the one that models use",
    "remarks": "what is doubtful about the calibration", "repeat": "of the sequence, from 0", "repeats": "how often the sequence was carried out",
    "rest_s": "between the sensor's last load and this run", "role": "what the instrument is for", "rows": "rows of the array",
    "rule": "decision rule", "run": "number of the run in this store", "safe_state": "how the safe state was proved at the end",
    "scan": "of the frame, from 0", "scanner": "serial number of the scanner", "scanner_serial": "serial number of the scanner",
    "scans": "scans in the frame; a sample is their mean", "schema": "name of the document's form", "scope": "level, direction, array",
    "seed": "of noise and faults, on a simulated bench", "sensor": "serial number of the sensor", "sensor_seed": "of the simulated array",
    "sensor_serial": "serial number of the sensor", "sensor_toml": "the sensor type file",
    "sensor_type_sha256": "of the sensor type file", "sequence": "number of the recipe in the run, from 0", "sequences": "that were fitted",
    "serial": "serial number of the instrument", "series": "of an imported table: each taxel's inputs and outputs",
    "setpoint_counts": "raw counts of the set-point", "setpoint_psi": "commanded pressure", "sha256": "of the text",
    "since_command_ns": "from the command to the frame", "since_command_s": "from the command to the frame",
    "source": "run or table", "started_utc": "start, by the wall clock", "state": "of the sequencer", "status": "of the scanner; of a taxel: fitted, dead ...",
    "step": "within the repeat, from 0", "subject": "what the figures are of", "tags": "words that people added",
    "target_n": "commanded force; empty without a stage", "taxel": "row × columns + column; -1: the mean taxel", "taxels": "each taxel's model",
    "time_ns": "process time since the run's start", "time_s": "process time since the run's start", "time_zone": "of the computer",
    "to_n": "force at which it ended", "to_psi": "pressure at which it ended", "toml": "the recipe's text", "trace": "readings of pressure between frames",
    "before_frame_s": "time before the frame that it belongs to",
    "tx_nmm": "torque about x", "ty_nmm": "torque about y", "tz_nmm": "torque about z", "uncertainty": "as the calibration states it, in words",
    "unit": "of the value; of a fit: of its outputs", "uuid": "of the run, in any store", "validity": "what the models were made for: ranges, mount", "value": "of the figure",
    "verdict": "pass, conditional pass, conditional fail, fail, inconclusive; of a check pass, warning, fail", "verdicts": "judgements on the run",
    "version": "of the document's form", "void": "1, true: declared void; of a branch: done again", "void_by": "who declared it void",
    "void_reason": "why", "void_utc": "when", "volts_per_count": "of the scanner: volts = counts × this", "volts_rR_cC": "volts of row R and column C",
    "wrench": "Fx, Fy, Fz, Tx, Ty, Tz when the frame was taken", "wrench_n_nmm": "Fx, Fy, Fz in N, Tx, Ty, Tz in N mm when the frame was taken",
    "wrench_raw": "the same as it came: counts or volts; a blob is six float64, little-endian", "x_mm": "x of the stage", "y_mm": "y of the stage", "z_mm": "z of the stage",
}

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
    missing = sorted(name for name in places if name not in MEANING)
    unused = sorted(name for name in MEANING if name not in places)
    if missing or unused:
        sys.exit(f"tests/docs/formats.py: MEANING lacks {missing}; no layout has {unused}")
    names = "| name | is | stands in |\n|---|---|---|\n"
    for name in sorted(places, key=str.lower):
        names += f"| `{name}` | {MEANING[name]} | {', '.join(places[name])} |\n"
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
with open(PAGE, encoding="utf-8") as file:
    committed = file.read()
if committed != made:
    sys.exit("docs/reference-formats.md is not what the program writes: tests/docs/formats.py build/tactbench --write")
print("the page of layouts is true")
