"""A pyserial client of the simulated pressure controller, which shares no code with tactbench: set-points, exhaust and what
is refused."""

import sys

import serial

from rig import Rig, follow, require


class Controller:
    """A letter, a command, a carriage return; back come the letter, pressure, set-point and words of status."""

    def __init__(self, port):
        self.line = serial.Serial(port, 19200, timeout=60)

    def ask(self, text):
        self.line.write(text.encode() + b"\r")
        answer = self.line.read_until(b"\r").decode()
        require(answer.endswith("\r"), f"controller: '{text}' is answered '{answer.strip()}'")
        return answer.split()

    def pressure(self):
        return float(self.ask("A")[1])


with Rig(sys.argv[1], "--rate", "10", "--bench", "simulated-serial.toml") as rig:
    controller = Controller(rig.where(r"pressure controller.*: (/\S+)"))
    unit, pressure, setpoint = controller.ask("A")
    require(unit == "A" and abs(float(pressure)) < 0.5 and float(setpoint) == 0.0, "controller: empty, set to 0 psi")
    require(float(controller.ask("AS12.34")[2]) == 12.34, "controller: the set-point comes back")
    follow(controller.pressure, 12.34, 0.3, "controller: pressure in psi")
    require(controller.ask("AS500") == ["?"] and controller.ask("Ahello") == ["?"], "controller: refuses")
    require(controller.ask("AE")[3:] == ["EXH"], "controller: exhausts")
    follow(controller.pressure, 0.0, 0.3, "controller: exhausted, in psi")
    require(controller.ask("AC")[3:] == [], "controller: the exhaust is cancelled")
    follow(controller.pressure, 12.34, 0.3, "controller: it regulates again, in psi")
