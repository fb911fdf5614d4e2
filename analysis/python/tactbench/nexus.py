"""A run as one HDF5 file, with the names of NeXus beside our own (docs/store.md has the layout)."""

import contextlib
import json
import math
import os
import re

from .errors import TactbenchError, package
from .store import Store

_LAYOUT = 2  # attribute `version` of the root
_NAN = float("nan")

# Attributes of the root: name there, column of `runs`.
_RUN = [(name, name) for name in (
    "run", "uuid", "origin", "state", "outcome", "reason", "safe_state", "operator", "purpose", "bench_sha256", "seed",
    "sensor_seed", "started_utc", "ended_utc", "host", "time_zone", "program_version", "git_commit", "git_dirty", "build_id",
    "content_sha256", "void_reason", "void_by", "void_utc")] + [
        ("sensor", "sensor_serial"), ("sensor_type_sha256", "sensor_sha256"), ("bench", "bench_id")]

# Tables: name, unit, kind (i: int64, d: float64, s: text), SQL.
_FRAMES = [("step", "", "i", "ordinal"),
           *((f"{name}_psi", "psi", "d", f"{name}_psi") for name in ("setpoint", "feedback", "reference")),
           *((f"{name}_counts", "count", "i", f"{name}_counts") for name in ("setpoint", "feedback", "reference")),
           *((f"{name}_ns", "ns", "i", f"{name}_ns") for name in ("time", "since_command", "in_band")),
           ("device_time_us", "us", "i", "device_time_us"), ("status", "", "i", "status"), ("exchanges", "", "i", "exchanges"),
           ("flags", "", "s", "flags")]
_BRANCHES = [*((name, "", "i", f'"{name}"') for name in ("sequence", "repeat", "ordinal", "attempt", "void")),
             ("void_reason", "", "s", "void_reason"), ("from_psi", "psi", "d", "from_psi"), ("to_psi", "psi", "d", "to_psi"),
             ("from_n", "N", "d", "from_n"), ("to_n", "N", "d", "to_n")]
_EVENTS = [("time_ns", "ns", "i", "time_ns"), ("kind", "", "s", "kind"), ("id", "", "s", "id"), ("detail", "", "s", "detail")]
_CHECKS = [("time_ns", "ns", "i", "time_ns"), ("kind", "", "s", "kind"), ("verdict", "", "s", "verdict"),
           ("detail_json", "", "s", "detail_json")]
_VERDICTS = [("criterion", "", "s", "criterion"), ("scope_kind", "", "s", "scope_kind"), ("low_psi", "psi", "d", "low_psi"),
             ("high_psi", "psi", "d", "high_psi"), ("direction", "", "s", "direction"), ("taxel_share", "", "d", "taxel_share"),
             ("value", "", "d", "value"), ("expanded", "", "d", "expanded"), ("limit", "", "d", "limit_value"), ("unit", "", "s", "unit"), ("rule", "", "s", "rule"),
             ("verdict", "", "s", "verdict"), ("limits_sha256", "", "s", "limits_sha256")]

# Role of a device: the quantity that it measures, and where its values lie.
_MEASURED = {"regulator": ("pressure", "/frames/feedback_psi"), "pressure reference": ("pressure", "/frames/reference_psi"),
             "tactile scanner": ("voltage", "/frames/counts"), "force sensor": ("force", "/frames/wrench")}


def to_nexus(store, run, file):
    """Writes all data of a run, raw counts of every scan and void branches too, to an HDF5 file that h5py, xarray, netCDF's
    tools and NeXus viewers read. An existing file is replaced once the new one is complete.

    store: a Store, or the path of one. Raises TactbenchError, and MissingPackage where h5py or numpy are not installed.
    """
    h5py = package("h5py", "to_nexus()")
    numpy = package("numpy", "to_nexus()")
    file = os.fspath(file)
    with contextlib.ExitStack() as stack:
        if not isinstance(store, Store):
            store = stack.enter_context(Store(store))
        store.run(run)  # refuses one that is not there
        store.refuse_pruned(run)
        half = file + ".part"
        stack.callback(lambda: os.path.exists(half) and os.remove(half))
        try:
            with h5py.File(half, "w") as made:
                _Writer(h5py, numpy, store, run, made).write()
            os.replace(half, file)
        except OSError as error:
            raise TactbenchError(f"cannot write {file}: {error}; name a file in a folder that exists and can be written") from error


class _Writer:
    def __init__(self, h5py, numpy, store, run, file):
        self.h5py, self.numpy, self.store, self.number, self.file = h5py, numpy, store, run, file
        self.run = self.rows("SELECT * FROM runs WHERE run = :run")[0]
        self.devices = self.rows("SELECT * FROM v_devices WHERE run = :run")

    def rows(self, sql):
        return self.store.query(sql, {"run": self.number})

    def write(self):
        self.head()
        self.recipes_and_devices()
        branches = self.rows("SELECT * FROM branches WHERE run = :run ORDER BY branch")
        self.frames({row["branch"]: i for i, row in enumerate(branches)})
        self.table("branches", "branch", "branches WHERE run = :run ORDER BY branch", _BRANCHES)
        self.table("events", "event", "events WHERE run = :run ORDER BY event", _EVENTS)
        self.table("checks", "check", "checks WHERE run = :run ORDER BY check_row", _CHECKS)
        self.table("verdicts", "judgement", "verdicts WHERE run = :run ORDER BY verdict_row", _VERDICTS)
        series = self.file.create_group("series")
        for number, row in enumerate(self.rows("SELECT * FROM series WHERE run = :run ORDER BY sequence, taxel")):
            group = series.create_group(str(number))
            group.attrs.update({"sequence": row["sequence"], "taxel": row["taxel"]})
            self.axis(group, "sample", len(row["input"]) // 8)
            for name in ("input", "output"):
                self.array(group, name, self.numpy.frombuffer(row[name], "<f8"), "", ["sample"])
        self.entry()

    # What an HDF5 file is made of.

    def array(self, group, name, values, unit, axes):
        """`axes`: names of arrays of the group, a dimension each. Large arrays are compressed."""
        how = {"compression": "gzip", "compression_opts": 4, "shuffle": True} if values.nbytes > 1024 else {}
        made = group.create_dataset(name, data=values, **how)
        if unit:
            made.attrs["units"] = unit
        for place, axis in enumerate(axes):
            made.dims[place].attach_scale(group[axis])
        return made

    def axis(self, group, name, values):
        """A length, or names, as a scale of a dimension (netCDF's dimensions)."""
        if isinstance(values, int):
            group.create_dataset(name, data=self.numpy.arange(values, dtype="int64")).make_scale(name)
        else:
            group.create_dataset(name, data=list(values), dtype=self.h5py.string_dtype()).make_scale(name)

    def column(self, group, axis, rows, name, unit, kind):
        values = [row[name] for row in rows]
        if kind == "s":
            texts = self.numpy.array([value or "" for value in values], dtype=object)
            made = group.create_dataset(name, data=texts, dtype=self.h5py.string_dtype())
            made.dims[0].attach_scale(group[axis])
            return
        empty = 0 if kind == "i" else _NAN
        values = self.numpy.array([empty if value is None else value for value in values], "int64" if kind == "i" else "float64")
        self.array(group, name, values, unit, [axis])

    def table(self, name, axis, source, columns):
        words = ", ".join(f'{sql} AS "{column}"' for column, _, _, sql in columns)
        rows = self.rows(f"SELECT {words} FROM {source}")
        group = self.file.create_group(name)
        self.axis(group, axis, len(rows))
        for column, unit, kind, _ in columns:
            self.column(group, axis, rows, column, unit, kind)

    def text(self, group, name, value):
        group.create_dataset(name, data=value or "", dtype=self.h5py.string_dtype())

    # What is in it.

    def head(self):
        root, run = self.file.attrs, self.run
        root.update({"schema": "tactbench.run", "version": _LAYOUT})
        root.update({name: "" if run[column] is None else run[column] for name, column in _RUN})
        root["void"] = int(bool(run["void_utc"]))
        root["tags"] = run["tags"] or ""
        root["rest_s"] = _NAN if run["rest_s"] is None else run["rest_s"]
        scanners = [row["serial"] for row in self.devices if row["role"] == "tactile scanner"]
        root["scanner"] = (scanners[0] if scanners else "") or run["scanner_serial"] or ""
        group = self.file.create_group("configuration")
        for name in ("bench_toml", "sensor_toml", "overrides_json", "notes"):
            self.text(group, name, run[name])

    def recipes_and_devices(self):
        recipes = self.file.create_group("recipes")
        for row in self.rows("SELECT * FROM sequences WHERE run = :run ORDER BY sequence"):
            group = recipes.create_group(str(row["sequence"]))
            group.attrs.update({"name": row["name"], "sha256": row["recipe_sha256"], "repeats": row["repeats"],
                                "frames_per_repeat": row["frames_per_repeat"]})
            self.text(group, "toml", row["recipe_toml"])
        devices = self.file.create_group("devices")
        for number, row in enumerate(self.devices):
            group = devices.create_group(str(number))
            group.attrs.update({name: row[name] or "" for name in ("role", "model", "serial", "firmware", "origin")})
            stated = _document(row["calibration_json"])
            group.attrs.update({name: stated.get(name, "") for name in ("certificate", "calibrated", "due")})
            self.text(group, "calibration_json", row["calibration_json"])

    def frames(self, place_of_branch):
        words = ", ".join(sql for _, _, _, sql in _FRAMES if sql != "ordinal")
        rows = self.rows(f'SELECT branch, ordinal AS step, {words}, "rows", columns, scans, counts, trace, target_n, '
                         "force_start_n, wrench, wrench_raw, place_mm FROM frames f WHERE " + self.store.frames_of_run + " ORDER BY f.frame")
        shapes = {(row["scans"], row["rows"], row["columns"]) for row in rows} or {(0, 0, 0)}
        if len(shapes) > 1:
            raise TactbenchError(f"the frames of run {self.number} differ in shape (scans, rows, columns): {sorted(shapes)}; "
                                 "tactbench runs export --format json holds frames of any shape")
        shape = shapes.pop()
        group = self.file.create_group("frames")
        self.axis(group, "frame", len(rows))
        own = self.numpy.array([place_of_branch[row["branch"]] for row in rows], "int64")
        self.array(group, "branch", own, "", ["frame"]).attrs["long_name"] = "row of /branches"
        for name, unit, kind, _ in _FRAMES:
            self.column(group, "frame", rows, name, unit, kind)
        for name, length in zip(("scan", "row", "column"), shape):
            self.axis(group, name, length)
        counts = self.numpy.frombuffer(b"".join(row["counts"] for row in rows), "<u2").reshape(len(rows), *shape)
        made = self.array(group, "counts", counts, "count", ["frame", "scan", "row", "column"])
        scales = [_document(row["calibration_json"]).get("volts_per_count") for row in self.devices]
        made.attrs["volts_per_count"] = next((scale for scale in scales if isinstance(scale, (int, float))), math.nan)
        if any(row["wrench"] is not None for row in rows):
            self.wrenches(group, rows)
        self.trace(rows)

    def wrenches(self, group, rows):
        for name in ("target_n", "force_start_n"):
            self.column(group, "frame", rows, name, "N", "d")
        # An array has one unit, a wrench two: its components say theirs.
        self.axis(group, "component", ["fx_n", "fy_n", "fz_n", "tx_nmm", "ty_nmm", "tz_nmm"])
        self.axis(group, "channel", 6)
        self.axis(group, "direction", ["x", "y", "z"])
        for name, unit, axis in (("wrench", "", "component"), ("wrench_raw", "", "channel"), ("place_mm", "mm", "direction")):
            width = len(group[axis])
            values = [[_NAN] * width if row[name] is None else self.numpy.frombuffer(row[name], "<f8") for row in rows]
            self.array(group, name, self.numpy.array(values, "float64"), unit, ["frame", axis])

    def trace(self, rows):
        """Readings of pressure between the frames."""
        points = [self.numpy.frombuffer(row["trace"] or b"", "<f4").reshape(-1, 4) for row in rows]
        lengths = [len(own) for own in points]
        group = self.file.create_group("trace")
        self.axis(group, "poll", sum(lengths))
        frame = self.numpy.repeat(self.numpy.arange(len(rows), dtype="int64"), lengths)
        self.array(group, "frame", frame, "", ["poll"]).attrs["long_name"] = "row of /frames"
        table = self.numpy.concatenate([*points, self.numpy.empty((0, 4), "<f4")]).astype("float64")
        for i, (name, unit) in enumerate((("before_frame_s", "s"), ("setpoint_psi", "psi"), ("feedback_psi", "psi"),
                                          ("reference_psi", "psi"))):
            self.array(group, name, table[:, i], unit, ["poll"])

    # The same by the names of NeXus (https://manual.nexusformat.org).

    def entry(self):
        run, file = self.run, self.file
        file.attrs.update({"NX_class": "NXroot", "default": "entry"})
        entry = self.named(file, "entry", "NXentry")
        entry.attrs.update({"default": "data", "origin": run["origin"]})
        simulated = "SIMULATED DATA: " if run["origin"] == "simulated" else ""
        purpose = f": {run['purpose']}" if run["purpose"] else ""
        self.text(entry, "title", f"{simulated}run {self.number} of sensor {run['sensor_serial'] or ''}{purpose}")
        for name, value in (("entry_identifier_uuid", run["uuid"]), ("start_time", run["started_utc"]),
                            ("end_time", run["ended_utc"]), ("program_name", "tactbench")):
            self.text(entry, name, value)
        entry["program_name"].attrs["version"] = run["program_version"]
        self.text(self.named(entry, "user", "NXuser"), "name", run["operator"])
        self.text(self.named(entry, "sample", "NXsample"), "name", run["sensor_serial"])
        instrument = self.named(entry, "instrument", "NXinstrument")
        self.text(instrument, "name", run["bench_id"])
        for number, device in enumerate(self.devices):
            self.device(instrument, number, device)
        frames = file["frames"]
        frames.attrs.update({"NX_class": "NXdata", "signal": "counts", "target": "/frames"})
        frames.attrs["axes"] = ["frame", "scan", "row", "column"]
        entry["data"] = frames

    def named(self, group, name, kind):
        made = group.create_group(name)
        made.attrs["NX_class"] = kind
        return made

    def device(self, instrument, number, device):
        role = device["role"]
        quantity, values = _MEASURED.get(role, (role[:-len(" sensor")] if role.endswith(" sensor") else "", ""))
        kind = "NXsensor" if quantity else "NXpositioner" if role.startswith("stage") else "NXcollection"
        group = self.named(instrument, f"{re.sub('[^a-z0-9]', '_', role) or 'device'}_{number}", kind)
        group.attrs["origin"] = device["origin"]
        self.text(group, "name", role)
        self.text(group, "model" if quantity else "description", device["model"])
        self.text(group, "serial_number", device["serial"])
        if quantity:
            self.text(group, "measurement", quantity)
        if values in self.file:
            group["value"] = self.file[values]


def _document(text):
    try:
        document = json.loads(text)
    except (TypeError, ValueError):
        return {}
    return document if isinstance(document, dict) else {}
