"""A run exported as HDF5, read back by h5dump, beside the same run as JSON. Arguments: the program, h5dump."""

import array
import json
import os
import re
import subprocess
import sys
import tempfile

PROGRAM, H5DUMP = sys.argv[1:]


def said(*words):
    done = subprocess.run(words, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, (words, done.stdout, done.stderr)
    return done.stdout


def values(path, kind):
    """The numbers of a dataset, little-endian, as h5dump writes them to a file."""
    said(H5DUMP, "-d", path, "-b", "LE", "-o", "values.bin", "run.h5")
    with open(os.path.join(folder, "values.bin"), "rb") as file:
        return array.array(kind, file.read()).tolist()


def attribute(path):
    """The value between quotes, or the bare number."""
    found = re.search(r"\(0\): (.*)", said(H5DUMP, "-w", "0", "-a", path, "run.h5")).group(1)
    return found[1:-1] if found.startswith('"') else found


with tempfile.TemporaryDirectory() as folder:
    for name in ("TACTBENCH_BENCH", "TACTBENCH_DB"):
        os.environ.pop(name, None)  # the developer's
    os.environ["TACTBENCH_RUNTIME_DIR"] = folder  # commands to other runs of this machine do not reach it
    said(PROGRAM, "init")
    said(PROGRAM, "sensors", "add", "S-1", "--type", "sensor.toml")
    said(PROGRAM, "run", "ring", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "Zoë, \"Q\"", "-q",
         "--yes")
    said(PROGRAM, "runs", "export", "1", "--format", "json", "-o", "run.json")
    said(PROGRAM, "runs", "export", "1", "--format", "hdf5", "-o", "run.h5")
    said(PROGRAM, "runs", "export", "1", "--format", "hdf5", "-o", "again.h5")
    with open(os.path.join(folder, "run.json")) as file:
        run = json.load(file)
    with open(os.path.join(folder, "run.h5"), "rb") as one, open(os.path.join(folder, "again.h5"), "rb") as other:
        assert one.read() == other.read()
    assert not os.path.exists(os.path.join(folder, "run.h5.part"))

    frames = run["frames"]
    assert len(frames) == 27, len(frames)
    assert values("/frames/counts", "H") == [count for frame in frames for count in frame["counts"]]
    shape = re.search(r"DATASPACE  SIMPLE \{ \( (.*?) \)", said(H5DUMP, "-H", "-d", "/frames/counts", "run.h5")).group(1)
    assert shape == f'27, {frames[0]["scans"]}, {frames[0]["rows"]}, {frames[0]["columns"]}', shape
    for name in ("setpoint_psi", "feedback_psi", "reference_psi", "target_n"):
        read = values(f"/frames/{name}", "d")
        assert [None if value != value else value for value in read] == [frame[name] for frame in frames], name
    assert values("/frames/wrench", "d") == [value for frame in frames for value in frame["wrench_n_nmm"]]
    assert values("/frames/time_ns", "q") == [frame["time_ns"] for frame in frames]
    branches = values("/frames/branch", "q")
    ordinals = values("/branches/ordinal", "q")
    assert [ordinals[branch] for branch in branches] == [frame["branch"] for frame in frames]
    assert values("/events/time_ns", "q") == [event["time_ns"] for event in run["events"]]

    # What JSON says of the run, its recipes and its devices are attributes of the same names.
    def check_attributes(path, members, apart=()):
        for key, value in members.items():
            if key in apart or value is None or isinstance(value, (list, dict)):
                continue
            read = attribute(f"{path}/{key}")
            if isinstance(value, str) and value.isascii() and not set(value) & set('"\\\n'):
                assert read == value, (path, key, read, value)
            elif not isinstance(value, str):
                assert float(read) == float(value), (path, key, read, value)

    assert (run["schema"], run["version"]) == ("tactbench.run", 2)
    check_attributes("", run, apart=("notes", "bench_toml", "sensor_toml"))
    check_attributes("/recipes/0", run["recipes"][0], apart=("toml",))
    for number, device in enumerate(run["devices"]):
        check_attributes(f"/devices/{number}", device)
    assert attribute("/sensor") == "S-1" and attribute("/outcome") == "completed"
    assert attribute("/sensor_type_sha256") == run["sensor_type_sha256"] and len(run["sensor_type_sha256"]) == 64
    rest = float(attribute("/rest_s"))
    assert rest != rest and run["rest_s"] is None
    assert attribute("/tags") == "" == " ".join(run["tags"])
    name = attribute("/operator")  # h5dump writes what is not ASCII as octal numbers of its own
    assert name.startswith("Zo\\") and name.endswith(', "Q"'), name
    assert attribute("/frames/counts/units") == "count" and attribute("/frames/feedback_psi/units") == "psi"
    assert abs(float(attribute("/frames/counts/volts_per_count")) - 5 / 65535) < 1e-9
    scanners = [device for device in run["devices"] if "scanner" in device["role"]]
    assert scanners and scanners[0]["serial"] in said(H5DUMP, "-A", "-g", "/devices", "run.h5")
    assert attribute("/recipes/0/name") == run["recipes"][0]["name"] == "ring"

    # As every other file: with its folder if need be, and not where a file stands in a folder's place.
    into = [PROGRAM, "runs", "export", "1", "--format", "hdf5", "-o"]
    subprocess.run([*into, "new/folder/x.h5"], cwd=folder, check=True, capture_output=True)
    assert said(H5DUMP, "-H", "new/folder/x.h5")
    nowhere = subprocess.run([*into, "run.h5/x.h5"], cwd=folder, capture_output=True, text=True)
    assert nowhere.returncode == 2 and "TB-FILE-WRITE" in nowhere.stderr, nowhere.stderr
print("what h5dump reads is what was stored")
