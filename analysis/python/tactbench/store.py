"""Runs of a store, read: frames as arrays in volts and psi, with units. Nothing here writes to a store."""

import json
import math
import os
import sqlite3

from .errors import TactbenchError, package

_APPLICATION_ID = 0x54424348  # "TBCH" in the file's header
_SCHEMA = 1  # the schema that is read

# A frame's numbers: name, unit, meaning, SQL. NULL is NaN.
_NUMBERS = (
    ("time_s", "s", "process time since the run's start", "f.time_ns * 1e-9"),
    ("reference_psi", "psi", "pressure reference, when the frame was taken", "f.reference_psi"),
    ("feedback_psi", "psi", "the regulator's own feedback", "f.feedback_psi"),
    ("setpoint_psi", "psi", "commanded pressure", "f.setpoint_psi"),
    ("since_command_s", "s", "time since the set-point was commanded", "f.since_command_ns * 1e-9"),
    ("in_band_s", "s", "time since the pressure entered the band about the set-point", "f.in_band_ns * 1e-9"),
)
_WHERE = (("position", "of the frame in its run, from 1", "f.frame - :run * 1000000000"),
          ("recipe", "sequence's name", "s.name"),
          ("repeat", "of the sequence, from 0", 'b."repeat"'),
          ("branch", "of the repeat, from 0", "b.ordinal"),
          ("step", "of the branch, from 0", "f.ordinal"),
          ("void", "1: its branch was done again", "b.void"),
          ("flags", "what makes the frame incomparable; empty: nothing", "f.flags"))
_WRENCH = (("fx_n", "N"), ("fy_n", "N"), ("fz_n", "N"), ("tx_nmm", "N mm"), ("ty_nmm", "N mm"), ("tz_nmm", "N mm"))
_PLACE = (("x_mm", "mm"), ("y_mm", "mm"), ("z_mm", "mm"))


class Store:
    """A run store, opened to be read; also while a run is being written. Closed by close() or at the end of `with`."""

    frames_of_run = "f.frame BETWEEN :run * 1000000000 + 1 AND :run * 1000000000 + 999999999"  # of `frames f`

    def __init__(self, path):
        self.path = os.fspath(path)
        self._connection = None
        if not os.path.isfile(self.path):
            raise TactbenchError(f"there is no store {self.path}: name the file that tactbench --db writes")
        self._connection = self._opened()
        try:
            application = self._connection.execute("PRAGMA application_id").fetchone()[0]
            version = self._connection.execute("PRAGMA user_version").fetchone()[0]
        except sqlite3.Error as error:
            self.close()
            raise TactbenchError(f"store {self.path} cannot be read: {error}") from error
        if application != _APPLICATION_ID or version != _SCHEMA:
            self.close()
            raise TactbenchError(f"{self.path} is no tactbench store of schema {_SCHEMA} (it has {version}): take the package of the "
                                 "build that wrote it")

    def _opened(self):
        """Read-only. In a folder that cannot be written SQLite cannot make the files beside a closed store."""
        name = "file:" + self.path.replace("%", "%25").replace("?", "%3f").replace("#", "%23")
        immutable = not os.access(os.path.dirname(self.path) or ".", os.W_OK) and not os.path.exists(self.path + "-wal")
        try:
            connection = sqlite3.connect(name + ("?mode=ro&immutable=1" if immutable else "?mode=ro"), uri=True)
        except sqlite3.Error as error:
            raise TactbenchError(f"store {self.path} cannot be opened: {error}") from error
        connection.row_factory = sqlite3.Row
        return connection

    def close(self):
        """A second time does nothing."""
        if self._connection is not None:
            self._connection.close()
        self._connection = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def query(self, sql, values=()):
        """Rows of a SELECT, by column's name (sqlite3.Row). Raises TactbenchError."""
        if self._connection is None:
            raise TactbenchError(f"store {self.path} is closed")
        try:
            return self._connection.execute(sql, values).fetchall()
        except sqlite3.Error as error:
            raise TactbenchError(f"store {self.path}: {error}") from error

    def runs(self):
        """All runs, void ones too: a list of dicts, the columns of the view v_runs."""
        return [dict(row) for row in self.query("SELECT * FROM v_runs ORDER BY run")]

    def run(self, run):
        """One run, as in runs(). Raises TactbenchError when there is none."""
        found = self.query("SELECT * FROM v_runs WHERE run = ?", (run,))
        if not found:
            raise TactbenchError(f"store {self.path} has no run {run}: tactbench runs list shows those that it has")
        return dict(found[0])

    def usable_run(self, run, void_too):
        """run(), refused when it is void, unless `void_too`."""
        facts = self.run(run)
        if facts.get("void") and not void_too:
            raise TactbenchError(f"run {run} of {self.path} is void ({facts['void_reason']}): void_too=True takes it anyway")
        return facts

    def volts_per_count(self, run):
        """Of the run's scanner, as its calibration is stored. Raises TactbenchError when it states none."""
        for row in self.query("SELECT calibration_json FROM devices WHERE run = ? AND role = 'tactile scanner'", (run,)):
            try:
                value = json.loads(row[0])["volts_per_count"]
            except (ValueError, KeyError, TypeError):
                continue
            if isinstance(value, (int, float)) and math.isfinite(value) and value > 0:
                return value
        raise TactbenchError(f"run {run} of {self.path} states no volts_per_count of its scanner, so that its counts cannot be "
                             "scaled")

    def refuse_pruned(self, run):
        """Raises TactbenchError when the run's frames were removed."""
        gone = self._connection.execute("SELECT pruned_utc, rule FROM pruned WHERE run = ?", (run,)).fetchone()
        if gone:
            raise TactbenchError(f"the frames of run {run} of {self.path} were removed on {gone[0]}, by the rule {gone[1]}: its "
                                 "figures and models are there")

    def frames(self, run, kind="xarray", scans=False, void_too=False):
        """A run's frames, in the order of time: volts of each taxel, pressures, force and place.

        kind: "xarray", a Dataset with the dimensions frame, row, column; "pandas", a DataFrame with one row a frame, volts in
        columns volts_r0_c0 ...; "numpy", a dict of arrays. Units are in the Dataset's and its variables' attrs, in the frame's
        attrs["units"], in the dict's "units". What a run has not measured is NaN; force and place are there when any frame has
        them. scans: volts of each scan (a further dimension, scan) instead of their mean; not with pandas. void_too: also
        branches that were done again, and runs that were voided. Raises TactbenchError, MissingPackage.
        """
        if kind not in ("xarray", "pandas", "numpy"):
            raise TactbenchError(f"kind is {kind!r}, not one of: xarray, pandas, numpy")
        if scans and kind == "pandas":
            raise TactbenchError("a pandas table has one row a frame: take scans=False, or kind='xarray'")
        module = package(kind, f"frames(kind={kind!r})")
        numpy = package("numpy", "frames()")
        facts = self.usable_run(run, void_too)
        self.refuse_pruned(run)
        data, units, meaning = self._arrays(numpy, run, scans, void_too)
        if kind == "numpy":
            return {**data, "units": units}
        attrs = {"run": run, "simulated": int(facts["origin"] == "simulated"), "store": self.path,
                 **{name: facts[name] for name in ("origin", "uuid", "sensor_serial", "bench_id", "started_utc",
                                                   "outcome", "content_sha256", "program_version")}}
        volts = data.pop("volts")
        if kind == "pandas":
            rows, columns = volts.shape[1:]
            names = [f"volts_r{row}_c{column}" for row in range(rows) for column in range(columns)]
            table = module.concat([module.DataFrame(data),
                                   module.DataFrame(volts.reshape(len(volts), rows * columns), columns=names)], axis=1)
            table.attrs = {**attrs, "units": {**{name: units[name] for name in data if name in units},
                                              **dict.fromkeys(names, "V")}}
            return table.set_index("position")
        dims = ("frame", "scan", "row", "column") if scans else ("frame", "row", "column")
        set_ = module.Dataset({"volts": (dims, volts, {"units": "V", "long_name": "output of a taxel"})}, attrs=attrs)
        for name, values in data.items():
            about = {"long_name": meaning[name]}
            if name in units:
                about["units"] = units[name]
            set_[name] = ("frame", values, about)
        return set_.set_coords(["position", *(name for name, _, _ in _WHERE), "time_s"])

    def _arrays(self, numpy, run, scans, void_too):
        """Arrays by name, units and meanings. One pass over the frames."""
        scale = self.volts_per_count(run)
        columns = ", ".join(f"{sql} AS {name}" for name, _, _, sql in _NUMBERS)
        where = ", ".join(f"{sql} AS {name}" for name, _, sql in _WHERE)
        rows = self.query(
            f'SELECT {where}, {columns}, f.target_n, f.wrench, f.place_mm, f."rows" AS r, f.columns AS c, f.scans AS k, f.counts '
            "FROM frames f JOIN branches b ON b.branch = f.branch "
            "JOIN sequences s ON s.run = b.run AND s.sequence = b.sequence "
            f"WHERE {self.frames_of_run}{'' if void_too else ' AND b.void = 0'} ORDER BY f.frame", {"run": run})
        if not rows:
            raise TactbenchError(f"run {run} of {self.path} has no frames: imported tables and runs that ended early have none")
        shapes = {(row["k"], row["r"], row["c"]) for row in rows}
        if len({shape[1:] for shape in shapes}) > 1 or (scans and len(shapes) > 1):
            raise TactbenchError(f"the frames of run {run} differ in shape (scans, rows, columns): {sorted(shapes)}")
        volts = [numpy.frombuffer(row["counts"], "<u2").reshape(row["k"], row["r"], row["c"]) for row in rows]
        volts = numpy.stack(volts) * scale if scans else numpy.stack([each.mean(axis=0) for each in volts]) * scale
        data = {name: numpy.array([row[name] for row in rows]) for name, _, _ in _WHERE}
        units, meaning = {"volts": "V"}, {name: text for name, text, _ in _WHERE}

        def put(name, unit, text, values):
            data[name] = numpy.array([math.nan if value is None else value for value in values], "float64")
            units[name], meaning[name] = unit, text

        for name, unit, text, _ in _NUMBERS:
            put(name, unit, text, [row[name] for row in rows])
        if any(row["target_n"] is not None for row in rows):
            put("target_n", "N", "commanded force", [row["target_n"] for row in rows])
        for blob, parts, text in (("wrench", _WRENCH, "force sensor, when the frame was taken"),
                                  ("place_mm", _PLACE, "stage, when the frame was taken")):
            if all(row[blob] is None for row in rows):
                continue
            empty = [math.nan] * len(parts)
            table = [empty if row[blob] is None else numpy.frombuffer(row[blob], "<f8") for row in rows]
            for i, (name, unit) in enumerate(parts):
                put(name, unit, text, [values[i] for values in table])
        data["volts"] = volts
        return data, units, meaning
