"""package_check.py PROGRAM LIBRARY: the Python package on stores and models that the program makes. What it reads is compared
with what the program exports and computes from the same."""

import json
import math
import os
import shutil
import sys

import numpy
from made_runs import call, exported, folder, refused
import tactbench
from tactbench import Compensator, Store


def counted(run):
    """Frames of a run's branches that count, and volts a count."""
    document = exported(run)
    scale = [device["calibration"]["volts_per_count"] for device in document["devices"] if device["role"] == "tactile scanner"]
    return [frame for frame in document["frames"] if not frame["void"]], scale[0]


def check_frames(store):
    """Numbers and units of each kind, against the program's own export."""
    frames, scale = counted(2)
    data = store.frames(2)
    for i, frame in enumerate(frames):
        counts = numpy.array(frame["counts"], float).reshape(frame["scans"], frame["rows"], frame["columns"])
        assert numpy.allclose(data.volts[i], counts.mean(axis=0) * scale, rtol=1e-12, atol=0), i
        for name in ("reference_psi", "feedback_psi", "setpoint_psi"):
            assert float(data[name][i]) == frame[name], (i, name)
        assert abs(float(data.time_s[i]) - frame["time_ns"] * 1e-9) < 1e-9 and int(data.step[i]) == frame["step"]
    assert data.sizes["frame"] == len(frames) > 400 and data.sizes["row"] == data.sizes["column"] == 16
    assert data.volts.attrs["units"] == "V" and data.reference_psi.attrs["units"] == "psi"
    assert data.time_s.attrs["units"] == "s" and data.attrs["simulated"] == 1 and data.attrs["sensor_serial"] == "MY-1"
    each = store.frames(2, scans=True)
    assert each.volts.dims == ("frame", "scan", "row", "column")
    assert numpy.allclose(each.volts.mean("scan"), data.volts, rtol=1e-12)
    table = store.frames(2, "pandas")
    assert numpy.array_equal(table["volts_r3_c7"], data.volts[:, 3, 7]) and table.attrs["units"]["volts_r3_c7"] == "V"
    assert numpy.array_equal(table["reference_psi"], data.reference_psi) and list(table.index[:2]) == [1, 2]
    plain = store.frames(2, "numpy")
    assert numpy.array_equal(plain["volts"], data.volts) and plain["units"]["reference_psi"] == "psi"
    assert "fz_n" not in plain
    frames, _ = counted(5)
    plain = store.frames(5, "numpy")
    for i, name in enumerate(("fx_n", "fy_n", "fz_n", "tx_nmm", "ty_nmm", "tz_nmm")):
        assert list(plain[name]) == [frame["wrench_n_nmm"][i] for frame in frames], name
    for i, name in enumerate(("x_mm", "y_mm", "z_mm")):
        assert list(plain[name]) == [frame["place_mm"][i] for frame in frames], name
    assert plain["units"]["fz_n"] == "N" and plain["units"]["tx_nmm"] == "N mm" and max(abs(plain["fz_n"])) > 1


def check_stream(data, stream, model, most=3):
    """All frames of a run through the package's stream, some taxels of them through the program's."""
    flat, times = data["volts"].reshape(len(data["volts"]), -1).astype("float32"), data["time_s"]
    read = [stream.volts(volts, float(times[i] - times[i - 1]) if i > 0 else 0) for i, volts in enumerate(flat)]
    for taxel in (0, 37, 255):
        with open("outputs.csv", "w") as file:
            file.write("time_s,output\n" + "".join(f"{float(t)!r},{float(v)!r}\n" for t, v in zip(times, flat[:, taxel])))
        lines = call("compensate", model, "outputs.csv", "--taxel", str(taxel), "-q").splitlines()[1:]
        for i, line in enumerate(lines):
            psi, own = float(line.split(",")[2]), float(read[i].pressure[taxel])
            assert abs(psi - own) < 1e-4, f"{model}, taxel {taxel}, frame {i}: {own}, the program {psi}"
            doubt, of_program = float(read[i].uncertainty[taxel]), float(line.split(",")[3])
            assert math.isnan(of_program) or abs(doubt - min(of_program, 60)) < 1e-3 * doubt, (model, taxel, i, doubt, of_program)
        assert len(lines) == len(flat)
    errors = numpy.concatenate([numpy.abs(frame.pressure - true)[(frame.status & tactbench.VALID) > 0]
                                for frame, true in zip(read, data["reference_psi"])])
    assert len(errors) > 100_000 and errors.mean() < most, (model, len(errors), errors.mean())
    return errors.mean()


def check_models(store):
    options = {"at_rest": True}
    data = store.frames(2, "numpy")
    figures = [check_stream(data, Compensator.load("runs.db", 1, fit=1, **options), "1:1"),
               check_stream(data, Compensator.load("model.json", **options), "model.json"),
               check_stream(data, Compensator.load("runs.db", 1, fit=2, **options), "1:2"),
               check_stream(data, Compensator.load("runs.db", 1, **options), "1")]
    assert abs(figures[0] - figures[1]) < 1e-6 and figures[3] < 0.8, figures
    check_stream(data, Compensator.load("monotone.json", **options), "monotone.json", most=8)
    assert Compensator.load("runs.db", 1).about["model"] == "dynamic"  # of ELAM and the dynamic model the newest
    # A child: each taxel's zero and gain moved, so that both have to be taken.
    with open("model.json") as file:
        document = json.load(file)
    for taxel in document["taxels"]:
        taxel.update(zero=0.01, gain=1.02)
    with open("child.json", "w") as file:
        json.dump(document, file)
    moved = {**data, "volts": 0.01 + 1.02 * data["volts"]}
    adjusted = check_stream(moved, Compensator.load("child.json", **options), "child.json")
    as_before = check_stream(moved, Compensator.load("model.json", **options), "model.json", most=8)
    assert abs(adjusted - figures[0]) < 0.01 < as_before - adjusted, (adjusted, as_before, figures[0])
    stream = Compensator.load("runs.db", 1, at_rest=True)
    about = stream.about
    assert about["simulated"] and about["sensor_serial"] == "MY-1" and about["rows"] == about["columns"] == 16
    counts = numpy.round(data["volts"][100] / about["volts_per_count"])
    by_counts = stream.counts(counts)
    stream.start()
    by_volts = stream.volts(counts * about["volts_per_count"])
    assert numpy.allclose(by_counts.pressure, by_volts.pressure, atol=1e-3)
    # A frame of one scan has more noise than the mean of two that were fitted; the residual stays.
    noisy = Compensator.load("runs.db", 1, scans=1, at_rest=True).volts(data["volts"][100].reshape(-1))
    assert 1 < numpy.median(noisy.uncertainty / by_volts.uncertainty) < 1.2
    for taxel in document["taxels"]:
        taxel.pop("residual_psi", None)
    with open("alone.json", "w") as file:
        json.dump(document, file)
    alone = {scans: Compensator.load("alone.json", scans=scans, at_rest=True, volts_per_count=about["volts_per_count"])
             .volts(0.01 + 1.02 * data["volts"][100].reshape(-1)).uncertainty for scans in (1, 2)}
    ratio = numpy.median(alone[1] / alone[2])
    assert abs(ratio - math.sqrt(2)) < 0.1, ratio
    assert numpy.median(by_volts.uncertainty / alone[2]) > 2


def taken_or_refused(name, **options):
    """Whatever a document and options say: numbers, or one of the package's own errors."""
    try:
        frame = Compensator.load(name, **options).volts([2.0] * 256)
    except (tactbench.TactbenchError, tactbench.CompensatorError):
        return
    valid = (frame.status & tactbench.VALID) > 0
    assert numpy.isfinite(frame.pressure[valid]).all() and numpy.isfinite(frame.uncertainty[valid]).all()


def check_refusals(store):
    with open("text.db", "w") as file:
        file.write("no store" * 1000)
    for named, act in (("77", lambda: store.frames(77)), ("polars", lambda: store.frames(1, "polars")),
                       ("scans=False", lambda: store.frames(1, "pandas", scans=True)), ("other.db", lambda: Store("other.db")),
                       ("text.db", lambda: Store("text.db")), ("fit 9", lambda: Compensator.load("runs.db", 1, fit=9)),
                       ("run 2", lambda: Compensator.load("runs.db", 2)), ("runs.db", lambda: Compensator.load("runs.db")),
                       ("volts_per_count=5 / 65536", lambda: Compensator.load("model.json").counts([0] * 256)),
                       ("1.toml", lambda: Compensator.load("1.toml")), ("none.json", lambda: Compensator.load("none.json"))):
        refused(named, act)
    with open("model.json") as file:
        document = json.load(file)
    del document["taxels"][3]["model"]["parameters"]
    with open("broken.json", "w") as file:
        json.dump(document, file)
    refused("parameters", lambda: Compensator.load("broken.json"))
    document["version"] = 2
    with open("broken.json", "w") as file:
        json.dump(document, file)
    refused("version 1", lambda: Compensator.load("broken.json"))
    # A document may have anything in any place: what cannot be streamed is refused by the package's own errors alone.
    call("model", "export", "1:2", "-o", "dynamic.json")
    for name, places in (("model.json", (("sensor", "rows"), ("taxels",), ("taxels", 3, "model"), ("taxels", 3, "gain"), ("taxels", 3, "noise"),
                                         ("taxels", 3, "model", "x"), ("taxels", 3, "model", "descending", 0), ("output", "scans"))),
                         ("dynamic.json", (("dynamics", "creep_s"), ("dynamics", "lag_s"), ("taxels", 3, "zero"), ("taxels", 3, "lag_share"),
                                           ("taxels", 3, "model", "of", "weights"), ("taxels", 3, "model", "of", "x_high")))):
        for *path, last in places:
            for value in (None, "x", {}, [[]], -1e300, 1e38, 10 ** 400, [1e308] * 3):
                with open(name) as file:
                    document = holder = json.load(file)
                for key in path:
                    holder = holder[key]
                holder[last] = value
                with open("broken.json", "w") as file:
                    json.dump(document, file)
                taken_or_refused("broken.json", volts_per_count=5 / 65536)
    with open("broken.json", "w") as file:
        file.write("[" * 100_000)
    refused("broken.json", lambda: Compensator.load("broken.json"))
    for option, value in (("scans", 0), ("volts_per_count", -1.0), ("volts_per_count", math.inf)):
        refused(option, lambda: Compensator.load("dynamic.json", **{option: value}))
    refused("-3", lambda: Compensator.load("dynamic.json", worked_seconds=-1.0))
    call("runs", "void", "2", "--reason", "gauge closed", "--by", "test")
    refused("gauge closed", lambda: store.frames(2))
    assert len(store.frames(2, "numpy", void_too=True)["time_s"]) > 400
    for missing in ("xarray", "pandas", "numpy"):
        kept, sys.modules[missing] = sys.modules.get(missing), None  # as if it were not installed
        refused(f"apt install python3-{missing}", lambda kind=missing: store.frames(1, kind), tactbench.MissingPackage)
        sys.modules[missing] = kept
    store.close()
    refused("is closed", store.runs)


try:
    os.chdir(folder)
    call("init")
    call("sensors", "add", "MY-1", "--type", "sensor.toml")
    for words in (["production"], ["random-reversal", "--seed", "2"], ["rate"], ["creep-levels"], ["ring"]):
        call("run", *words, "--bench", "bench.toml", "--sensor", "MY-1", "--operator", "test", "-q", "--yes")
    call("fit", "1", "--model", "elam", "-q")
    call("fit", "1", "--model", "dynamic", "--rate", "3", "--creep", "4", "-q")
    call("fit", "1", "-q")
    call("model", "export", "1:1", "-o", "model.json")
    call("fit", "1", "--model", "monotone", "-o", "monotone.json", "-q")
    with open("1.toml", "w") as file:
        file.write("a = 1\n")
    with Store("runs.db") as opened:
        assert [run["recipes"] for run in opened.runs()][:2] == ["loops, inner-loops, hold", "random-reversal"]
        check_frames(opened)
        check_models(opened)
        check_refusals(opened)
finally:
    os.chdir("/")
    shutil.rmtree(folder)
print("frames and models as the program's")
