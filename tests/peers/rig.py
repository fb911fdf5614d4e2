"""`tactbench simulate` beside a test: started on free ports, asked where it serves what, stopped when the test ends."""

import ctypes
import json
import re
import signal
import subprocess
import time

PARENT_DEATH_SIGNAL = 1  # prctl(2)
LONGEST_S = 120  # the simulator ends by itself


def die_with_parent():
    ctypes.CDLL(None).prctl(PARENT_DEATH_SIGNAL, signal.SIGKILL)


class Rig:
    def __init__(self, program, *words):
        self.process = subprocess.Popen(
            [program, "simulate", "--json", "--for", str(LONGEST_S), *words],
            stdout=subprocess.PIPE, text=True, preexec_fn=die_with_parent)
        text = ""
        while True:  # one JSON document, then it serves
            line = self.process.stdout.readline()
            if not line:
                raise SystemExit("tactbench simulate ended before it served: " + text)
            text += line
            try:
                self.served = json.loads(text)["served"]
                return
            except json.JSONDecodeError:
                pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        try:
            self.process.wait(timeout=120)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise SystemExit("tactbench simulate did not end at SIGTERM")

    def where(self, pattern):
        """The first group of `pattern` in what is served, written 'what: where'."""
        for entry in self.served:
            found = re.search(pattern, entry["what"] + ": " + entry["where"])
            if found:
                return found.group(1)
        raise SystemExit(f"not served: {pattern} in {self.served}")

    def modbus_tcp_port(self):
        return int(self.where(r"Modbus TCP 127\.0\.0\.1:(\d+).*EK9000"))

    def modbus_rtu_port(self):
        return self.where(r"Modbus RTU (\S+), .*Waveshare")


def require(holds, text):
    if not holds:
        raise SystemExit("FAILED: " + text)
    print("ok:", text, flush=True)


def follow(read, wanted, band, what, deadline_s=20.0):
    """Polls read() until it is within `band` of `wanted`; the values on the way."""
    values = []
    end = time.monotonic() + deadline_s
    while time.monotonic() < end:
        values.append(read())
        if abs(values[-1] - wanted) <= band:
            require(True, f"{what}: {values[0]} -> {values[-1]} in {len(values)} readings (wanted {wanted} +- {band})")
            return values
        time.sleep(0.05)
    raise SystemExit(f"FAILED: {what} did not come to {wanted} +- {band} in {deadline_s} s: {values[-5:]}")
