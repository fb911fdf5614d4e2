"""pymodbus as client of the simulated rig: reads and sets the pressure over TCP and RTU, and is refused what is wrong."""

import sys

from pymodbus.client import ModbusSerialClient, ModbusTcpClient

from rig import Rig, follow, require

EK9000_OUTPUT, EK9000_WATCHDOG = 0x0800, 0x1120
VOLT = 3277  # EK9000 counts
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS = 1, 2


def registers(answer):
    if answer.isError():
        raise SystemExit(f"FAILED: {answer}")
    return answer.registers


def signed(word):
    return word - 65536 if word > 32767 else word


def over_tcp(rig):
    client = ModbusTcpClient("127.0.0.1", port=rig.modbus_tcp_port(), timeout=10)
    require(client.connect(), "tcp: connected")

    def feedback():
        return signed(registers(client.read_input_registers(0, 2, slave=1))[0])

    require(registers(client.read_holding_registers(EK9000_WATCHDOG, 5, slave=1)) == [1000, 0, 1, 0, 1],
            "tcp: the coupler's watchdog stands as it leaves the factory")
    client.write_register(EK9000_WATCHDOG + 2, 2, slave=1)  # off: this client feeds nothing
    written = client.write_registers(EK9000_OUTPUT, [2 * VOLT], slave=1)
    require(not written.isError() and written.count == 1, "tcp: output written (function 16)")
    follow(feedback, 2 * VOLT, 40, "tcp: feedback follows 2 V")
    both = registers(client.readwrite_registers(read_address=0, read_count=2, write_address=EK9000_OUTPUT,
                                                write_registers=[0], slave=1))
    require(len(both) == 2, f"tcp: written and read in one exchange (function 23): {both}")
    follow(feedback, 0, 60, "tcp: feedback falls at 0 V")
    refused = client.read_input_registers(0x4000, 1, slave=1)
    require(refused.isError() and refused.exception_code == ILLEGAL_ADDRESS, f"tcp: refused: {refused}")
    refused = client.read_coils(0, 1, slave=1)
    require(refused.isError() and refused.exception_code == ILLEGAL_FUNCTION, f"tcp: refused: {refused}")
    client.close()


def over_rtu(rig):
    # Parity N: a pseudo-terminal has no other, and pyserial insists.
    client = ModbusSerialClient(port=rig.modbus_rtu_port(), baudrate=9600, parity="N", timeout=10)
    require(client.connect(), "rtu: opened")

    def feedback():
        return registers(client.read_input_registers(0, 7, slave=2))[0]

    require(not client.write_register(0, 3000, slave=1).isError(), "rtu: output written (function 6)")
    require(registers(client.read_holding_registers(0, 8, slave=1)) == [3000] + 7 * [0], "rtu: outputs read back")
    follow(feedback, 3000, 15, "rtu: feedback follows 3 V")
    require(not client.write_registers(0, 8 * [0], slave=1).isError(), "rtu: all outputs to 0 (function 16)")
    follow(feedback, 0, 20, "rtu: feedback falls at 0 V")
    refused = client.read_input_registers(0x4000, 1, slave=2)
    require(refused.isError() and refused.exception_code == ILLEGAL_ADDRESS, f"rtu: refused: {refused}")
    client.close()


with Rig(sys.argv[1]) as rig:
    over_tcp(rig)
    over_rtu(rig)
