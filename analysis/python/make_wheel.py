"""make_wheel.py WHEEL VERSION LIBRARY LICENSE SOURCE.py...: a wheel of the package and its library, and no more than Python's
own modules to make it. The same files give the same bytes."""

import base64
import hashlib
import os
import sys
import zipfile

wheel, version, library, license_file, *sources = sys.argv[1:]
TAG = os.path.basename(wheel)[:-len(".whl")].split("-", 2)[2]
METADATA = f"""Metadata-Version: 2.1
Name: tactbench
Version: {version}
Summary: Runs and models of tactbench: frames in volts and psi, and pressures from a tactile array's raw counts
License: Apache-2.0
Requires-Python: >=3.8
Provides-Extra: xarray
Requires-Dist: numpy; extra == "xarray"
Requires-Dist: pandas; extra == "xarray"
Requires-Dist: xarray; extra == "xarray"
Provides-Extra: hdf5
Requires-Dist: h5py; extra == "hdf5"
Requires-Dist: h5netcdf; extra == "hdf5"
"""
WHEEL = f"Wheel-Version: 1.0\nGenerator: tactbench {version}\nRoot-Is-Purelib: false\nTag: {TAG}\n"


def content(path):
    with open(path, "rb") as file:
        return file.read()


info = f"tactbench-{version}.dist-info"
files = {("tactbench_compensator.py" if path.endswith("/tactbench_compensator.py") else
          "tactbench/" + os.path.basename(path)): content(path) for path in sources}
files["tactbench/libtactbench_compensator.so.1"] = content(library)
files.update({f"{info}/METADATA": METADATA.encode(), f"{info}/WHEEL": WHEEL.encode(), f"{info}/LICENSE": content(license_file)})
record = ""
for name in sorted(files):
    digest = base64.urlsafe_b64encode(hashlib.sha256(files[name]).digest()).rstrip(b"=").decode()
    record += f"{name},sha256={digest},{len(files[name])}\n"
record += f"{info}/RECORD,,\n"
os.makedirs(os.path.dirname(wheel), exist_ok=True)
with zipfile.ZipFile(wheel + ".part", "w", zipfile.ZIP_DEFLATED) as archive:
    for name, data in [*sorted(files.items()), (f"{info}/RECORD", record.encode())]:
        entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
        entry.external_attr = 0o100644 << 16
        entry.compress_type = zipfile.ZIP_DEFLATED
        archive.writestr(entry, data)
os.replace(wheel + ".part", wheel)
print(wheel)
