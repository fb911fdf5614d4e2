"""A run exported as HDF5, read by xarray (through h5netcdf) and by h5py, names and units as written, beside the store.
Argument: the program. Ends with 77 where a package lacks."""

import os
import re
import sqlite3
import subprocess
import sys
import tempfile

PROGRAM = sys.argv[1]
try:
    import h5py
    import numpy
    import xarray
    import h5netcdf  # noqa: F401, xarray's engine
except ImportError as error:
    print(f"SKIPPED: {error} (Debian: python3-h5py python3-h5netcdf python3-xarray)")
    sys.exit(77)


def call(*words):
    done = subprocess.run([PROGRAM, *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, (words, done.stdout, done.stderr)


with tempfile.TemporaryDirectory() as folder:
    for name in ("TACTBENCH_BENCH", "TACTBENCH_DB"):
        os.environ.pop(name, None)
    os.environ["TACTBENCH_RUNTIME_DIR"] = folder
    call("init")
    call("sensors", "add", "S-1", "--type", "sensor.toml")
    call("run", "ring", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "Zoë", "-q", "--yes")
    call("runs", "export", "1", "--format", "hdf5", "-o", "run.h5")
    file = os.path.join(folder, "run.h5")
    store = sqlite3.connect(os.path.join(folder, "runs.db"))
    truth = store.execute("SELECT counts, reference_psi, time_ns, fz_n, scans, \"rows\", columns FROM v_frames ORDER BY position")
    truth = truth.fetchall()

    with xarray.open_dataset(file, engine="h5netcdf", group="frames") as frames:
        assert frames.counts.dims == ("frame", "scan", "row", "column"), frames.counts.dims
        assert frames.counts.shape == (len(truth), *truth[0][4:]), frames.counts.shape
        assert frames.counts.attrs["units"] == "count" and frames.reference_psi.attrs["units"] == "psi"
        assert frames.time_ns.attrs["units"] == "ns" and frames.place_mm.attrs["units"] == "mm"
        assert not [name for name in (*frames.dims, *frames.data_vars) if "phony" in name]
        # Chosen by name, not by position.
        one = frames.counts.sel(row=3, column=4).isel(scan=0, frame=5)
        shape = truth[5][4:]
        assert int(one) == int(numpy.frombuffer(truth[5][0], "<u2").reshape(shape)[0, 3, 4])
        assert frames.reference_psi.values.tolist() == [row[1] for row in truth]
        assert frames.time_ns.values.tolist() == [row[2] for row in truth]
        assert numpy.allclose(frames.wrench.sel(component="fz_n"), [row[3] for row in truth], rtol=0, atol=0)
        assert frames.wrench.dims == ("frame", "component") and frames.wrench_raw.dims == ("frame", "channel")
    for group, dimension in (("trace", "poll"), ("branches", "branch"), ("events", "event"), ("checks", "check")):
        with xarray.open_dataset(file, engine="h5netcdf", group=group) as table:
            assert list(table.dims) == [dimension], (group, table.dims)
    with xarray.open_dataset(file, engine="h5netcdf", group="branches") as branches:
        assert branches.from_psi.attrs["units"] == "psi"
    with h5py.File(file) as whole:
        entry = whole[whole.attrs["default"]]
        assert entry.attrs["NX_class"] == "NXentry" and "SIMULATED" in entry["title"].asstr()[()]
        data = entry[entry.attrs["default"]]
        assert data.attrs["NX_class"] == "NXdata" and data == whole["frames"]
        assert list(data.attrs["axes"]) == ["frame", "scan", "row", "column"]
        signal = data[data.attrs["signal"]]
        for place, axis in enumerate(data.attrs["axes"]):
            assert signal.dims[place][0] == data[axis], axis
        sensors = {group["name"].asstr()[()]: group for group in entry["instrument"].values()
                   if isinstance(group, h5py.Group) and group.attrs["NX_class"] == "NXsensor"}
        reference = sensors["pressure reference"]
        assert reference["measurement"].asstr()[()] == "pressure"
        assert reference["value"].attrs["units"] == "psi" and reference["value"] == whole["frames/reference_psi"]
        assert sensors["force sensor"]["value"] == whole["frames/wrench"]
        assert {group.attrs["NX_class"] for group in entry["instrument"].values() if isinstance(group, h5py.Group)} >= {
            "NXsensor", "NXpositioner"}
        assert entry["user/name"].asstr()[()] == "Zoë" and entry["sample/name"].asstr()[()] == "S-1"
        assert entry["sample"].attrs["NX_class"] == "NXsample"
        # Every array of numbers has a unit or is one of what has none.
        bare = []
        whole.visititems(lambda name, item: bare.append(name) if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu"
                         and "units" not in item.attrs and item.attrs.get("CLASS") != b"DIMENSION_SCALE"
                         and not name.startswith("entry/") else None)
        without = {"frames/branch", "frames/step", "frames/status", "frames/exchanges", "frames/wrench", "frames/wrench_raw",
                   "trace/frame", "branches/sequence", "branches/repeat", "branches/ordinal", "branches/attempt",
                   "branches/void", "verdicts/value", "verdicts/limit"}
        assert set(bare) <= without, set(bare) - without
print("what xarray and h5py read is what was stored, with names and units")
