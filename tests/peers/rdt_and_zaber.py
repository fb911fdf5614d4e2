"""Two clients that share no code with tactbench, written from the manufacturers' protocols: a Zaber T-Series chain by
pyserial and an ATI Net F/T by RDT over UDP. The first presses the indenter on the specimen, the second feels it."""

import socket
import struct
import sys
import time
import urllib.request
import xml.etree.ElementTree

import serial

from rig import Rig, require

HOME, MOVE_ABSOLUTE, RETURN_SETTING, RETURN_DEVICE_ID, ECHO, ERROR = 1, 20, 53, 50, 55, 255
T_NA08A50, T_LA60A = 5082, 60
SURFACE_MM, STIFFNESS_N_PER_MM = 30.0, 20.0  # of the simulated specimen
MICROSTEP_MM = 0.047625e-3  # T-NA08A50 at 64 microsteps a step


class Chain:
    """Six bytes each way: device, command, four of data with the lowest first."""

    def __init__(self, port):
        self.line = serial.Serial(port, 9600, timeout=60)

    def ask(self, device, command, data=0):
        self.line.write(struct.pack("<BBi", device, command, data))
        reply = self.line.read(6)
        if len(reply) != 6:
            raise SystemExit(f"FAILED: device {device}, command {command}: {len(reply)} bytes came")
        return reply

    def value(self, device, command, data=0):
        sender, answered, value = struct.unpack("<BBi", self.ask(device, command, data))
        if (sender, answered) != (device, command):
            raise SystemExit(f"FAILED: asked {device} for {command}, {sender} answered {answered} with {value}")
        return value


class NetFt:
    """Request: 0x1234, command, count of records. Record: two sequence numbers, status, six signed counts."""

    START, BIAS = 0x0002, 0x0042

    def __init__(self, address, page):
        host, port = address.split(":")
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.settimeout(10)
        self.socket.connect((host, int(port)))
        with urllib.request.urlopen(page, timeout=60) as answer:
            fields = xml.etree.ElementTree.fromstring(answer.read())
        self.counts_per_force = float(fields.findtext("cfgcpf"))
        self.force_unit = fields.findtext("scfgfu")

    def send(self, command, count=0):
        self.socket.send(struct.pack(">HHI", 0x1234, command, count))

    def records(self, count):
        self.send(self.START, count)
        records = [struct.unpack(">IIIiiiiii", self.socket.recv(64)) for _ in range(count)]
        if [record[0] for record in records] != list(range(records[0][0], records[0][0] + count)):
            raise SystemExit("FAILED: RDT sequence numbers do not count up")
        if any(record[2] != 0 for record in records):
            raise SystemExit("FAILED: a status bit is set")
        return records

    def force_n(self, count=50):
        records = self.records(count)
        return [sum(record[3 + axis] for record in records) / count / self.counts_per_force for axis in range(3)]


def no_proxy():
    urllib.request.install_opener(urllib.request.build_opener(urllib.request.ProxyHandler({})))


def zaber(chain):
    echo = chain.ask(3, ECHO, 123456)
    require(echo == bytes([3, 55, 0x40, 0xE2, 0x01, 0x00]), f"zaber: echo bytes {echo.hex(' ')}")
    ids = [chain.value(device, RETURN_DEVICE_ID) for device in (1, 2, 3)]
    require(ids == [T_LA60A, T_LA60A, T_NA08A50], f"zaber: device ids {ids}")
    error = struct.unpack("<BBi", chain.ask(3, RETURN_SETTING, 127))
    require(error[:2] == (3, ERROR), f"zaber: a setting that there is not is refused with error {error[2]}")
    begin = time.monotonic()
    for device in (1, 2, 3):
        require(chain.value(device, HOME) == 0, f"zaber: device {device} is home, {time.monotonic() - begin:.1f} s")


def force(chain, sensor):
    free = sensor.force_n()
    require(sensor.force_unit == "N", f"rdt: {sensor.counts_per_force:.0f} counts a newton")
    require(all(abs(axis) < 0.05 for axis in free), f"rdt: hanging free {[round(axis, 4) for axis in free]} N")
    depth_mm = 0.25
    target = round((SURFACE_MM + depth_mm) / MICROSTEP_MM)
    require(chain.value(3, MOVE_ABSOLUTE, target) == target, f"zaber: z moved to {target} microsteps")
    expected = -STIFFNESS_N_PER_MM * depth_mm
    pressed = sensor.force_n()
    require(abs(pressed[2] - expected) < 0.05, f"rdt: pressed {depth_mm} mm, Fz {pressed[2]:.4f} N (wanted {expected})")
    sensor.send(NetFt.BIAS)
    biased = sensor.force_n()
    require(abs(biased[2]) < 0.05, f"rdt: after the software bias Fz {biased[2]:.4f} N")
    chain.value(3, HOME)
    lifted = sensor.force_n()
    require(abs(lifted[2] + expected) < 0.05, f"rdt: lifted off, Fz {lifted[2]:.4f} N above the bias")


no_proxy()
# 20 N/mm and nothing else, so that a place is a force.
ELASTIC = [word for key in ("stiffening_n_per_mm2", "friction_share", "relaxation_share")
           for word in ("--set", f"simulation.contact.{key}=0")]
with Rig(sys.argv[1], "--rate", "10", *ELASTIC) as rig:
    chain = Chain(rig.where(r"Zaber.*: (/\S+)"))
    sensor = NetFt(rig.where(r"RDT over UDP\): (\S+)"), rig.where(r": (http://\S+netftapi2\.xml)"))
    zaber(chain)
    force(chain, sensor)
