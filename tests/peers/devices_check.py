"""`tactbench devices check` reads a module that is not ours: pymodbus_server.py, over TCP and RTU."""

import json
import os
import subprocess
import sys
import tempfile

from rig import die_with_parent, require

BENCH = """
schema = 1
[bench]
id = "foreign-module"
origin = "hardware"
[module]
profile = "generic"
unit = 1
response_timeout_ms = 10000
{wire}
[regulator]
serial = "unknown"
[reference]
model = "digital gauge"
serial = "unknown"
[reference.gauge]
unit = 1
address = {gauge}
type = "f32"
word_order = "{order}"
[scanner]
serial = ""
"""


def check(program, wire, gauge, order):
    with tempfile.TemporaryDirectory() as folder:
        bench = os.path.join(folder, "bench.toml")
        with open(bench, "w", encoding="utf-8") as file:
            file.write(BENCH.format(wire=wire, gauge=gauge, order=order))
        done = subprocess.run([program, "devices", "check", "--bench", bench, "--json"], capture_output=True, text=True,
                              timeout=600)
    require(done.returncode == 3, f"exit code {done.returncode}: there is no scanner {done.stderr}")
    return {device["role"]: device for device in json.loads(done.stdout)["devices"]}


for kind in ("tcp", "rtu"):
    server = subprocess.Popen(["/usr/bin/python3", os.path.join(os.path.dirname(__file__), "pymodbus_server.py"), kind],
                              stdout=subprocess.PIPE, text=True, preexec_fn=die_with_parent)
    try:
        place = server.stdout.readline().rsplit(" ", 1)[-1].strip()
        if kind == "tcp":
            host, port = place.split(":")
            devices = check(sys.argv[1], f'host = "{host}"\nport = {port}', 100, "low-first")
        else:
            devices = check(sys.argv[1], f'transport = "rtu"\nbaud = 115200\nserial_port = "{place}"', 110, "high-first")
        for role, device in devices.items():
            print(f"{kind}: {device['state']:<7} {role}: {device['found']} {device['reading']} {device['notes'][:1]}")
        states = {role: device["state"] for role, device in devices.items()}
        require([role for role, state in states.items() if state != "ok"] == ["tactile scanner"],
                f"{kind}: all but the scanner are ok")
    finally:
        server.kill()
        server.wait()
