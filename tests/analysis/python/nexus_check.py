"""nexus_check.py PROGRAM LIBRARY: to_nexus() and netCDF of runs that the program makes, read back by h5py and xarray, beside what
the program exports of the same runs."""

import json
import os
import shutil
import sys

import h5py
import numpy
from made_runs import call, exported, folder, refused
import tactbench
import xarray


def same(stored, values):
    return numpy.array_equal(stored, numpy.array([numpy.nan if value is None else value for value in values], stored.dtype),
                             equal_nan=stored.dtype.kind == "f")


def check_attributes(holder, members, apart=()):
    """Texts, numbers and truth of a document are attributes of the same names."""
    for key, value in members.items():
        if key in apart or value is None or isinstance(value, (list, dict)):
            continue
        assert holder.attrs[key] == value, (holder.name, key, holder.attrs.get(key), value)


def check_whole(file, run):
    frames = run["frames"]
    for name in ("setpoint_psi", "feedback_psi", "reference_psi", "time_ns", "since_command_ns", "in_band_ns", "setpoint_counts",
                 "status", "step", "target_n"):
        if name in file["frames"]:
            assert same(file["frames"][name][()], [frame.get(name) for frame in frames]), name
    counts = file["frames/counts"]
    assert counts.shape == (len(frames), *(frames[0][name] for name in ("scans", "rows", "columns")))
    assert counts[()].ravel().tolist() == [count for frame in frames for count in frame["counts"]]
    ordinals, voids = file["branches/ordinal"][()], file["branches/void"][()]
    for i, branch in enumerate(file["frames/branch"][()]):
        assert ordinals[branch] == frames[i]["branch"] and bool(voids[branch]) == frames[i]["void"]
    assert file["events/detail"].asstr()[()].tolist() == [event["detail"] for event in run["events"]]
    assert file["checks/verdict"].asstr()[()].tolist() == [check["verdict"] for check in run["checks"]]
    assert len(run["verdicts"]) > 0 or run["run"] != 2
    assert file["verdicts/verdict"].asstr()[()].tolist() == [verdict["verdict"] for verdict in run["verdicts"]]
    rows = file["trace/frame"][()]
    assert len(rows) == len(file["trace/reference_psi"]) > 0 and sorted(rows) == list(rows) and rows[-1] < len(frames)
    check_attributes(file, run, apart=("notes", "bench_toml", "sensor_toml"))
    assert file.attrs["tags"] == " ".join(run["tags"]) and numpy.isnan(file.attrs["rest_s"]) == (run["rest_s"] is None)
    assert file["configuration/bench_toml"].asstr()[()] == run["bench_toml"]
    for number, recipe in enumerate(run["recipes"]):
        check_attributes(file[f"recipes/{number}"], recipe, apart=("toml",))
        assert file[f"recipes/{number}/toml"].asstr()[()] == recipe["toml"]
    for number, device in enumerate(run["devices"]):
        stated = {name: device[name] for name in ("role", "model", "serial", "firmware", "origin", "certificate", "calibrated", "due")}
        check_attributes(file[f"devices/{number}"], stated)
        assert json.loads(file[f"devices/{number}/calibration_json"].asstr()[()] or "null") == device["calibration"]


def check_names_and_units(path):
    """Dimensions have names, and what is a quantity has a unit."""
    with xarray.open_dataset(path, engine="h5netcdf", group="frames") as frames, h5py.File(path) as file:
        assert frames.counts.dims == ("frame", "scan", "row", "column") and frames.wrench.dims == ("frame", "component")
        assert int(frames.counts.sel(row=3, column=4).isel(scan=0, frame=5)) == file["frames/counts"][5, 0, 3, 4]
        assert frames.reference_psi.attrs["units"] == "psi" and frames.place_mm.attrs["units"] == "mm"
    for group, dimension in (("trace", "poll"), ("branches", "branch"), ("events", "event"), ("checks", "check")):
        with xarray.open_dataset(path, engine="h5netcdf", group=group) as table:
            assert list(table.dims) == [dimension], (group, table.dims)
    bare = {"branch", "step", "status", "exchanges", "wrench", "wrench_raw", "frame", "sequence", "repeat", "ordinal", "attempt",
            "void", "value", "expanded", "limit", "taxel_share"}
    with h5py.File(path) as file:
        def check(name, item):
            if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu" and not h5py.h5ds.is_scale(item.id):
                assert "units" in item.attrs or name.split("/")[-1] in bare, name
        file.visititems(check)


def check_entry(file):
    entry = file[file.attrs["default"]]
    data = entry[entry.attrs["default"]]
    assert entry.attrs["NX_class"] == "NXentry" and "SIMULATED" in entry["title"].asstr()[()]
    assert data.attrs["NX_class"] == "NXdata" and data == file["frames"]
    signal = data[data.attrs["signal"]]
    for place, axis in enumerate(data.attrs["axes"]):
        assert signal.dims[place][0] == data[axis], axis
    devices = {group["name"].asstr()[()]: group for group in entry["instrument"].values() if isinstance(group, h5py.Group)}
    assert devices["pressure reference"]["value"] == file["frames/reference_psi"]
    assert devices["pressure reference"]["measurement"].asstr()[()] == "pressure"
    assert devices["force sensor"]["value"] == file["frames/wrench"]
    assert {group.attrs["NX_class"] for group in devices.values()} >= {"NXsensor", "NXpositioner"}
    assert entry["user/name"].asstr()[()] == "Zoë" and entry["sample/name"].asstr()[()] == "S-1"


try:
    os.chdir(folder)
    call("init")
    call("sensors", "add", "S-1", "--type", "sensor.toml")
    for recipe in ("ring", "production", "production"):
        call("run", recipe, "--bench", "bench.toml", "--sensor", "S-1", "--operator", "Zoë", "--purpose", "door open", "-q", "--yes",
             "--no-seating")
    call("fit", "3", "--model", "elam", "-q")
    call("judge", "3", "2", "--limits", "limits.toml", "-q", codes=(0, 1, 6))  # whatever the verdict
    call("runs", "tag", "2", "night", "lot=A7")
    with open("table.csv", "w") as text:
        text.write("input,output\n0,0\n1,2\n2,3\n1,2.5\n0,0.1\n")
    call("runs", "import", "table.csv", "-q")
    for run in (1, 2):
        tactbench.to_nexus("runs.db", run, "run.h5")
        with h5py.File("run.h5") as made:
            check_whole(made, exported(run))
            assert ("wrench" in made["frames"]) == (run == 1)
        if run == 1:
            check_names_and_units("run.h5")
            with h5py.File("run.h5") as made:
                check_entry(made)
                assert made["frames/wrench"][()].tolist() == [frame["wrench_n_nmm"] for frame in exported(1)["frames"]]
    with tactbench.Store("runs.db") as store:
        tactbench.to_nexus(store, 2, "again.h5")
        with open("run.h5", "rb") as one, open("again.h5", "rb") as other:
            assert one.read() == other.read()
        tactbench.to_nexus(store, 4, "table.h5")
        with h5py.File("table.h5") as made:
            assert made["series/0/input"][()].tolist() == [0, 1, 2, 1, 0] and made.attrs["origin"] == "imported"
        data = store.frames(2)
        data.to_netcdf("run.nc", engine="h5netcdf")
        with xarray.open_dataset("run.nc", engine="h5netcdf") as read:
            assert read.volts.equals(data.volts) and read.volts.attrs["units"] == "V" and read.attrs["simulated"] == 1
        # What cannot be written leaves what is there, and nothing beside it.
        refused("77", lambda: tactbench.to_nexus(store, 77, "run.h5"))
        refused("none/run.h5", lambda: tactbench.to_nexus(store, 2, "none/run.h5"))
        kept, sys.modules["h5py"] = sys.modules["h5py"], None  # as if it were not installed
        refused("apt install python3-h5py", lambda: tactbench.to_nexus(store, 2, "run.h5"), tactbench.MissingPackage)
        sys.modules["h5py"] = kept
        with open("run.h5", "rb") as one, open("again.h5", "rb") as other:
            assert one.read() == other.read()
        assert not [name for name in os.listdir(".") if name.endswith(".part")]
finally:
    os.chdir("/")
    shutil.rmtree(folder)
print("HDF5 and netCDF hold what the program exports")
