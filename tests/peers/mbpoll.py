"""mbpoll (libmodbus, but another program than ours) reads and sets the pressure of the simulated rig, TCP and RTU."""

import re
import subprocess
import sys

from rig import Rig, follow, require

# EK9000: an output word and two input words, 0x7FFF for 10 V. The regulator has 9 bar for 10 V, and its monitor too.
EK9000_OUTPUT, EK9000_WATCHDOG_TYPE, WATCHDOG_OFF = 0x0800, 0x1122, 2
EK9000_HALF_VOLT = 32767 // 20
WAVESHARE_VOLT = 1000  # millivolts


def mbpoll(*words, write=None):
    command = ["mbpoll", "-0", "-1", "-q", "-o", "5", *words]
    if write is not None:
        command.append(str(write))
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    if done.returncode != 0:
        raise SystemExit(f"FAILED: {' '.join(command)}: {done.stdout}{done.stderr}")
    words = re.findall(r"^\[(\d+)\]:\s+(\d+)", done.stdout, re.M)
    return {int(register): (int(word) + 0x8000) % 0x10000 - 0x8000 for register, word in words}


def over_tcp(rig):
    line = ["-m", "tcp", "-p", str(rig.modbus_tcp_port()), "-a", "1"]
    host = ["127.0.0.1"]

    def inputs():
        return mbpoll(*line, "-t", "3", "-r", "0", "-c", "2", *host)

    at_rest = inputs()
    require(set(at_rest) == {0, 1} and all(abs(v) < 100 for v in at_rest.values()), f"tcp: inputs at rest {at_rest}")
    mbpoll(*line, "-t", "4", "-r", str(EK9000_WATCHDOG_TYPE), *host, write=WATCHDOG_OFF)
    mbpoll(*line, "-t", "4", "-r", str(EK9000_OUTPUT), *host, write=2 * EK9000_HALF_VOLT)
    stands = mbpoll(*line, "-t", "4", "-r", str(EK9000_OUTPUT), *host)[EK9000_OUTPUT]
    require(stands == 2 * EK9000_HALF_VOLT, f"tcp: the output register holds {stands}")
    follow(lambda: inputs()[0], 2 * EK9000_HALF_VOLT, 40, "tcp: feedback follows 1 V (0.9 bar)")
    # The reference transducer has 100 psi for 10 V: 0.9 bar are 13.05 psi.
    follow(lambda: inputs()[1], round(32767 * 13.053 / 100), 160, "tcp: reference transducer agrees")
    mbpoll(*line, "-t", "4", "-r", str(EK9000_OUTPUT), *host, write=0)
    follow(lambda: inputs()[0], 0, 60, "tcp: feedback falls at 0 V")


def over_rtu(rig):
    line = ["-m", "rtu", "-b", "9600", "-P", "none"]
    port = [rig.modbus_rtu_port()]

    def inputs():
        return mbpoll(*line, "-a", "2", "-t", "3", "-r", "0", "-c", "2", *port)

    require(all(value < 40 for value in inputs().values()), f"rtu: inputs at rest {inputs()}")
    mbpoll(*line, "-a", "1", "-t", "4", "-r", "0", *port, write=2 * WAVESHARE_VOLT)
    outputs = mbpoll(*line, "-a", "1", "-t", "4", "-r", "0", "-c", "8", *port)
    require(outputs == {0: 2 * WAVESHARE_VOLT, **{i: 0 for i in range(1, 8)}}, f"rtu: output registers {outputs}")
    follow(lambda: inputs()[0], 2 * WAVESHARE_VOLT, 15, "rtu: feedback in mV follows 2 V (1.8 bar)")
    follow(lambda: inputs()[1], 2611, 50, "rtu: reference transducer agrees")
    mbpoll(*line, "-a", "1", "-t", "4", "-r", "0", *port, write=0)
    follow(lambda: inputs()[0], 0, 20, "rtu: feedback falls at 0 V")


with Rig(sys.argv[1]) as rig:
    over_tcp(rig)
    over_rtu(rig)
