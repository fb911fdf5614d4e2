"""A stored model as a stream of compensated frames: from a document (tactbench fit -o, model export) or from a store."""

import bisect
import json
import math
import os

import tactbench_compensator as _streams

from .errors import TactbenchError
from .store import Store

_MEAN_TAXEL = -1
_FINE = 1e-6  # volts a count where only volts are given: a step that adds no noise of its own
_NONE = 1e-300  # 0 means "default" in compensator_c.h
_PARAMETERS = ("alpha_d", "beta_d", "alpha_a1", "alpha_a0", "beta_a")


def _refusal(name, why):
    return TactbenchError(f"{name} cannot compensate frames: {why}")


class _Loaded:
    """What a stream that was loaded knows of its model beside the numbers: `about`, a dict."""

    about = None

    def _scaled(self):
        if self.about["volts_per_count"] is None:
            raise TactbenchError("a model's document does not state volts_per_count: load(..., volts_per_count=5 / 65536), "
                                 "with your scanner's; or give volts")

    def counts(self, counts):
        """One frame of raw counts, whole ones; a mean of scans goes in by volts()."""
        self._scaled()
        return super().counts(counts)

    def tare(self, counts):
        """`counts` is the unloaded sensor. Returns how many taxels were too far off."""
        self._scaled()
        return super().tare(counts)


class _ElamStream(_Loaded, _streams.Compensator):
    pass


class _DynamicStream(_Loaded, _streams.DynamicCompensator):
    pass


class Compensator(_streams.Compensator):
    """tactbench_compensator's, made from patterns and parameters; load() takes them from a stored model."""

    @staticmethod
    def load(path, run=None, fit=None, volts_per_count=None, scans=None, void_too=False, **options):
        """The stream of a stored model: of ELAM as in the paper, or of the dynamic model (which set_interval tells the time).

        path: a model's document, or a store with the number of a run; fit: of that run, as `tactbench model list` shows (None:
        the newest dynamic model or ELAM, else the newest). volts_per_count: of the scanner that the frames come from; None: that
        of the run's, which a document does not state. scans: how many are averaged into a frame that is given (None: as many as
        in those that were fitted); a frame of fewer has more noise. options: of Compensator, as double=True, at_rest=True,
        longest_gap.
        The result has `about`, a dict: model, input_unit, rows, columns, scans, volts_per_count, sensor_serial,
        scanner_serial, origin, simulated, validity. Raises TactbenchError, CompensatorError.
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
        try:
            return _stream_of(document, name, volts_per_count, scans, options)
        except (TactbenchError, _streams.CompensatorError):
            raise
        except Exception as error:  # a document may have anything in any place
            raise TactbenchError(f"{name} with these options is no model that this package reads: {error!r}") from error


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
        raise TactbenchError(f"run {run} of {store.path} has no {which}: tactbench model list {run} shows them, tactbench fit {run} "
                             "makes one")
    name = f"fit {found[0]['fit']} of {store.path}"
    try:
        return _checked(json.loads(found[0]["document"]), name)
    except (TypeError, ValueError, RecursionError) as error:
        raise TactbenchError(f"{name} cannot be read: {error!r}; fit the run again: tactbench fit {run}") from error


def _stream_of(document, name, volts_per_count, scans, options):
    sensor, output = document["sensor"], document["output"]
    taxels = [taxel for taxel in document["taxels"] if taxel["taxel"] != _MEAN_TAXEL]
    if len(taxels) != sensor["rows"] * sensor["columns"] or [taxel["taxel"] for taxel in taxels] != list(range(len(taxels))):
        raise _refusal(name, "it is not of a whole array")
    scans = scans or output["scans"]
    if scans < 1:
        raise TactbenchError(f"scans is {scans}, and a frame has at least one")
    if volts_per_count is not None and not (math.isfinite(volts_per_count) and volts_per_count > 0):
        raise TactbenchError(f"volts_per_count is {volts_per_count}, and has to be positive")
    noisier = math.sqrt(output["scans"] / scans)
    make = _dynamic_stream if "dynamics" in document else _elam_stream
    stream = make(document, taxels, name, volts_per_count or _FINE, noisier, options)
    stream.about = {"model": document["model"], "input_unit": document["input"]["unit"], "rows": sensor["rows"],
                    "columns": sensor["columns"], "scans": scans, "volts_per_count": volts_per_count,
                    "sensor_serial": sensor["serial"], "scanner_serial": sensor["scanner_serial"],
                    "origin": document["source"]["origin"], "simulated": document["source"]["origin"] == "simulated",
                    "validity": document.get("validity")}
    return stream


def _elam_stream(document, taxels, name, volts_per_count, noisier, options):
    """As frame_setup_of() of analysis/identify/stored/model_store.cpp: the patterns have the taxel's zero and gain in them."""
    grid, exact_outer, rows = None, False, []
    for taxel in taxels:
        if taxel["status"] != "fitted":
            rows.append(_streams.Taxel(usable=False))
            continue
        model = taxel["model"]
        if model["model"] != "elam" or model["options"]["memory"] or model["options"]["splits"] > 1:
            raise _refusal(name, f"it is {document['model']}, and only the dynamic model (tactbench fit RUN) and ELAM as in "
                                 "the paper (--model elam) are streamed")
        if grid is None:
            grid, exact_outer = model["x"], model["options"]["exact_outer"]
        if model["x"] != grid:
            raise _refusal(name, "its taxels do not share one grid")
        up, down = ([taxel["zero"] + taxel["gain"] * value for value in model[name]] for name in ("ascending", "descending"))
        rows.append(_streams.Taxel(up, down, [model["parameters"][key] for key in _PARAMETERS], noisier * taxel["noise"],
                                   falling=document["output"]["falling"],
                                   residual=_residual_of(taxel.get("residual_psi", 0.0), grid, up, down)))
    if grid is None:
        raise _refusal(name, "none of its taxels is fitted")
    return _ElamStream(grid, rows, volts_per_count, **{"exact_outer": exact_outer, **options})


def _residual_of(scale, x, up, down):
    """As residual_by_level() of analysis/identify/streams/residuals.cpp: larger as the branch is flatter, to a limit."""
    if not scale:
        return ()

    def at(branch, where):
        k = min(max(bisect.bisect_right(x, where) - 1, 0), len(x) - 2)
        return branch[k] + (branch[k + 1] - branch[k]) * (where - x[k]) / (x[k + 1] - x[k])

    levels, most, least, rise, residual = 20, 12.0, 0.5, up[-1] - up[0], []
    for branch in (up, down):
        ends = [at(branch, x[0] + (x[-1] - x[0]) * k / levels) for k in range(levels + 1)]
        for low, high in zip(ends, ends[1:]):
            own = levels * (high - low)
            residual.append(scale * (max(rise / own, least) if own > rise / most else most))
    return residual


def _everett_of(weights, intervals, gain):
    """Everett's table at grid points (compensator_c.h) from Preisach's weights of cells: (i, j) has the cells of rows below i
    and columns from j on. Sums are rounded: of two that are equal one may come out less, and the table must not fall."""
    place = lambda i, j: i * (i + 1) // 2 + j
    table = [0.0] * ((intervals + 1) * (intervals + 2) // 2)
    for i in range(1, intervals + 1):
        row = 0.0  # of cells i - 1 from column j on
        for j in reversed(range(i)):
            row += gain * weights[place(i - 1, j)]
            table[place(i, j)] = max(table[place(i - 1, j)] + row, table[place(i - 1, j)], table[place(i, j + 1)])
    return table


def _dynamic_stream(document, taxels, name, volts_per_count, noisier, options):
    """As dynamic_setup_of() of analysis/identify/dynamic_setup_of.cpp."""
    shape, rows = None, []
    for taxel in taxels:
        if taxel["status"] != "fitted":
            rows.append(_streams.DynamicTaxel(usable=False))
            continue
        outer = taxel["model"]
        film = outer["of"] if outer["model"] == "linearised" else None
        if film is None or film["model"] != "preisach":
            raise _refusal(name, f"taxel {taxel['taxel']} is not Preisach on the linearised output")
        intervals = (math.isqrt(8 * len(film["weights"]) + 1) - 1) // 2
        own = (film["x_low"], film["x_high"], intervals)
        if shape is None:
            shape = own
        if own != shape:
            raise _refusal(name, f"the range or the number of intervals of taxel {taxel['taxel']} is not that of the others")
        amplitude = outer["per_amplitude"]
        if amplitude > 0 and abs(film["y_low"]) > 1e-9 * abs(sum(film["weights"])):
            raise _refusal(name, f"the divider of taxel {taxel['taxel']} does not count from the unloaded output")
        zero = taxel["zero"] + taxel["gain"] * (outer["zero"] + (0.0 if amplitude > 0 else film["y_low"]))
        rows.append(_streams.DynamicTaxel(_everett_of(film["weights"], intervals, taxel["gain"]), zero,
                                          amplitude / taxel["gain"], taxel["creep_scale"] or _NONE, taxel["lag_share"],
                                          noisier * taxel["noise"], falling=document["output"]["falling"],
                                          residual_scale=taxel["residual_psi"] or _NONE))
    if shape is None:
        raise _refusal(name, "none of its taxels is fitted")
    shared = document["dynamics"]
    return _DynamicStream(shape[2], rows, volts_per_count, shape[0], shape[1],
                          creep=list(zip(shared["creep_s"], shared["creep_share"])), creep_half=shared["creep_half"],
                          lag_seconds=shared["lag_s"], residual=shared["residual_shape"], **options)
