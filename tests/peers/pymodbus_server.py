"""A Modbus analog module that is not ours: pymodbus serves the map of devices/profiles/generic.toml on free TCP port or,
as RTU, on a pseudo-terminal. Prints "listening on PLACE", then serves until it is ended.

Holding register 0: the output, 0x7FFF for 10 V. Input register 0: the regulator's monitor, which is where it was sent;
1: a transducer of 100 psi. Behind them a digital gauge's psi as two floats, encoded by pymodbus: input registers
100 (low word first) and 110 (high word first)."""

import asyncio
import logging
import os
import sys
import threading
import tty

from pymodbus.constants import Endian
from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.payload import BinaryPayloadBuilder
from pymodbus.server.async_io import ModbusSerialServer, ModbusTcpServer
from pymodbus.transaction import ModbusRtuFramer

FULL = 32767
PSI_FOR_10_V = 9 * 14.503774  # the regulator: 9 bar
REFERENCE_SPAN_PSI = 100
UNIT = 1


def float_words(value, word_order):
    builder = BinaryPayloadBuilder(byteorder=Endian.Big, wordorder=word_order)
    builder.add_32bit_float(value)
    return builder.to_registers()


class Inputs(ModbusSequentialDataBlock):
    def __init__(self, outputs):
        super().__init__(0, [0] * 120)
        self.outputs = outputs

    def getValues(self, address, count=1):
        counts = self.outputs.getValues(0)[0]
        psi = counts / FULL * PSI_FOR_10_V
        self.setValues(0, [counts, round(psi / REFERENCE_SPAN_PSI * FULL)])
        self.setValues(100, float_words(psi, Endian.Little))
        self.setValues(110, float_words(psi, Endian.Big))
        return super().getValues(address, count)


def context():
    outputs = ModbusSequentialDataBlock(0, [0])
    unit = ModbusSlaveContext(hr=outputs, ir=Inputs(outputs), zero_mode=True)
    return ModbusServerContext(slaves={UNIT: unit}, single=False)


async def serve_tcp():
    server = ModbusTcpServer(context(), address=("127.0.0.1", 0))
    task = asyncio.ensure_future(server.serve_forever())
    await server.serving
    print(f"listening on 127.0.0.1:{server.server.sockets[0].getsockname()[1]}", flush=True)
    await task


def pump(source, sink):
    while True:
        os.write(sink, os.read(source, 256))


def line():
    """Two terminals joined back to back, as a cable joins two serial ports; both are held open, so that no end is lost."""
    (near, near_name), (far, far_name) = [(master, os.ttyname(slave)) for master, slave in (os.openpty(), os.openpty())]
    for name in (near_name, far_name):
        tty.setraw(os.open(name, os.O_RDWR | os.O_NOCTTY))
    for pair in ((near, far), (far, near)):
        threading.Thread(target=pump, args=pair, daemon=True).start()
    return near_name, far_name


async def serve_rtu():
    near, far = line()
    server = ModbusSerialServer(context(), framer=ModbusRtuFramer, port=near, baudrate=115200, parity="N", timeout=1)
    await server.start()
    print(f"listening on {far}", flush=True)
    await asyncio.Event().wait()


logging.disable(logging.CRITICAL)  # a client that hangs up is no error
asyncio.run(serve_rtu() if sys.argv[1:] == ["rtu"] else serve_tcp())
