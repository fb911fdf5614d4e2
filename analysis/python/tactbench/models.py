"""A stored model as a stream of compensated frames: from a document (tactbench fit -o, model export) or from a store."""

import json
import math
import os

import tactbench_compensator as _streams

from .errors import TactbenchError
from .store import Store


class Compensator(_streams.Compensator):
    """tactbench_compensator's; load() takes it from a stored model. `about`, a dict: model, input_unit, rows, columns, scans,
    volts_per_count, sensor_serial, scanner_serial, origin, simulated, validity."""

    about = None

    @classmethod
    def load(cls, path, run=None, fit=None, volts_per_count=None, scans=None, void_too=False, **options):
        """The stream of a stored model of a whole array.

        path: a model's document, or a store with the number of a run; fit: of that run, as `tactbench runs show` shows (None:
        the newest dynamic model or ELAM, else the newest). volts_per_count: of the scanner that the frames come from, for
        counts(); None: that of the run's, which a document does not state. scans: how many are averaged into a frame that is
        given (None: as many as in those that were fitted); a frame of fewer has more noise. options: of Compensator,
        at_rest=True, worked_seconds. Raises TactbenchError, CompensatorError.
        """
        path = os.fspath(path)
        if run is None:
            if fit is not None:
                raise TactbenchError("fit belongs to a run: load(store, run=RUN, fit=FIT)")
            document = _document_in(path)
        else:
            with Store(path) as store:
                document = _document_of(store, run, fit, void_too)
                volts_per_count = volts_per_count or store.volts_per_count(run)
        name = path if run is None else f"the model of run {run} in {path}"
        if scans is not None and scans < 1:
            raise TactbenchError(f"scans is {scans}, and a frame has at least one")
        if volts_per_count is not None and not (math.isfinite(volts_per_count) and volts_per_count > 0):
            raise TactbenchError(f"volts_per_count is {volts_per_count}, and has to be positive")
        try:
            stream = cls(json.dumps(document), scans=scans or 0, **options)
        except _streams.CompensatorError as error:
            raise TactbenchError(f"{name} cannot compensate frames: {error}") from error
        sensor, source = document["sensor"], document["source"]
        stream.about = {"model": document["model"], "input_unit": document["input"]["unit"], "rows": sensor["rows"],
                        "columns": sensor["columns"], "scans": scans or document["output"]["scans"],
                        "volts_per_count": volts_per_count, "sensor_serial": sensor["serial"],
                        "scanner_serial": sensor["scanner_serial"], "origin": source["origin"],
                        "simulated": source["origin"] == "simulated", "validity": document.get("validity")}
        return stream

    def counts(self, counts, seconds=float("nan")):
        """One frame of raw counts, as volts()."""
        per_count = (self.about or {}).get("volts_per_count")
        if per_count is None:
            raise TactbenchError("a model's document does not state volts_per_count: load(..., volts_per_count=5 / 65536), "
                                 "with your scanner's; or give volts")
        return self.volts([count * per_count for count in counts], seconds)


def _document_in(path):
    try:
        with open(path, "rb") as file:
            start = file.read(16)
            if start.startswith(b"SQLite format 3"):
                raise TactbenchError(f"{path} is a store: name a run, load({path!r}, run=1)")
            document = json.loads((start + file.read()).decode())
    except OSError as error:
        raise TactbenchError(f"cannot read the model {path}: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise TactbenchError(f"{path} is no model: {error}; give a file that tactbench fit -o or model export wrote") from error
    return _checked(document, path)


def _checked(document, name):
    if not isinstance(document, dict) or document.get("schema") != "tactbench.model" or document.get("version") != 1:
        raise TactbenchError(f"{name} is no model of version 1: give a file that tactbench fit -o or model export wrote")
    return document


def _document_of(store, run, fit, void_too):
    """A fit of a store as the document that `model export` writes: what streaming needs of it."""
    store.usable_run(run, void_too)
    found = store.query("SELECT fit, document FROM fits WHERE run = ? ORDER BY stands DESC, fit DESC", (run,))
    found = [row for row in found if fit is None or row["fit"] == fit]
    if not found:
        which = "fit" if fit is None else f"fit {fit}"
        raise TactbenchError(f"run {run} of {store.path} has no {which}: tactbench runs show {run} shows them, tactbench fit {run} "
                             "makes one")
    name = f"fit {found[0]['fit']} of {store.path}"
    try:
        return _checked(json.loads(found[0]["document"]), name)
    except (TypeError, ValueError, RecursionError) as error:
        raise TactbenchError(f"{name} cannot be read: {error!r}; fit the run again: tactbench fit {run}") from error
