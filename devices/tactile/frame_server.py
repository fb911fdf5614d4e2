#!/usr/bin/python3
"""Reference server of the frame-source protocol (frame_protocol.md), Python 3 standard library only.

Serves a synthetic 16 x 16 array. To connect your own scanner, write a class with the members of SyntheticArray that
reads your hardware, and serve that. Prints "listening on HOST:PORT" once it is ready.
"""

import argparse
import socketserver
import struct
import threading
import time
import zlib

MAGIC = b"TBFP"
VERSION = 1
HEADER = struct.Struct("<4sBBHI")  # magic, type, reserved 0, tag, payload length
MAX_PAYLOAD = 18 + 2 * 256 * 256  # bytes
IDENTIFY, SCAN, SUBSCRIBE, UNSUBSCRIBE = 0x01, 0x02, 0x03, 0x04
DESCRIPTION, FRAME, DONE, ERROR = 0x81, 0x82, 0x84, 0x8F
DAMAGED, UNKNOWN_TYPE, BAD_PAYLOAD, DEVICE = 1, 2, 3, 4


class SyntheticArray:
    """Your hardware goes here."""

    rows, columns, volts_per_count = 16, 16, 1.0e-4
    model, serial, firmware = "synthetic array", "PY-1", "1.0"
    frames_per_second = 100.0  # to subscribers

    def scan(self):
        """One fresh frame: (status, rows x columns counts of 0 to 65535, row-major)."""
        step = time.monotonic_ns() // 1_000_000
        return 0, [(step + 7 * i) % 65536 for i in range(self.rows * self.columns)]


def message(kind, tag, payload=b""):
    body = HEADER.pack(MAGIC, kind, 0, tag, len(payload)) + payload
    return body + struct.pack("<I", zlib.crc32(body))


def text(string):
    data = string.encode()
    return bytes([len(data)]) + data


def error(tag, code, why):
    return message(ERROR, tag, struct.pack("<H", code) + text(why))


class Connection(socketserver.BaseRequestHandler):
    def setup(self):
        self.sending = threading.Lock()
        self.subscription = None  # an Event that ends it

    def finish(self):
        self.unsubscribe()

    def send(self, data):
        with self.sending:
            self.request.sendall(data)

    def receive(self, size):
        data = b""
        while len(data) < size:
            more = self.request.recv(size - len(data))
            if not more:
                raise ConnectionError
            data += more
        return data

    def handle(self):
        try:
            while True:
                header = self.receive(HEADER.size)
                magic, kind, reserved, tag, length = HEADER.unpack(header)
                sound = magic == MAGIC and reserved == 0 and length <= MAX_PAYLOAD
                payload = self.receive(length) if sound else b""
                if not sound or struct.unpack("<I", self.receive(4))[0] != zlib.crc32(header + payload):
                    self.send(error(0, DAMAGED, "damaged request"))
                    return  # what follows cannot be trusted: close
                self.answer(kind, tag, payload)
        except OSError:
            pass  # the client has gone

    def answer(self, kind, tag, payload):
        if kind not in (IDENTIFY, SCAN, SUBSCRIBE, UNSUBSCRIBE):
            self.send(error(tag, UNKNOWN_TYPE, "not a request of this protocol"))
        elif len(payload) != (2 if kind == IDENTIFY else 0):
            self.send(error(tag, BAD_PAYLOAD, "the payload does not fit the request"))
        elif kind == IDENTIFY:
            a = self.server.array
            fixed = struct.pack("<HHHBBd", VERSION, a.rows, a.columns, 1, 0, a.volts_per_count)
            self.send(message(DESCRIPTION, tag, fixed + text(a.model) + text(a.serial) + text(a.firmware)))
        elif kind == SCAN:
            self.send(self.frame(tag))
        elif kind == SUBSCRIBE:
            self.unsubscribe()
            self.subscription = threading.Event()
            threading.Thread(target=self.publish, args=(tag, self.subscription), daemon=True).start()
        else:
            self.unsubscribe()
            self.send(message(DONE, tag))

    def frame(self, tag):
        a = self.server.array
        with self.server.scanning:
            now = time.monotonic_ns() // 1000
            try:
                status, counts = a.scan()
            except Exception as failure:  # whatever the hardware's library throws
                return error(tag, DEVICE, type(failure).__name__)
            counter = self.server.counter
            self.server.counter = (counter + 1) % 2**32
        head = struct.pack("<QIHHBB", now, counter, a.rows, a.columns, status, 0)
        return message(FRAME, tag, head + struct.pack(f"<{len(counts)}H", *counts))

    def publish(self, tag, ended):
        try:
            while not ended.wait(1.0 / self.server.array.frames_per_second):
                frame = self.frame(tag)
                with self.sending:
                    if not ended.is_set():  # after DONE no frame may follow
                        self.request.sendall(frame)
        except OSError:
            pass

    def unsubscribe(self):
        if self.subscription:
            with self.sending:
                self.subscription.set()


class Server(socketserver.ThreadingTCPServer):
    allow_reuse_address = True
    daemon_threads = True

    def __init__(self, address, array):
        super().__init__(address, Connection)
        self.array = array
        self.scanning = threading.Lock()
        self.counter = 0


if __name__ == "__main__":
    arguments = argparse.ArgumentParser(description="Reference server of the frame-source protocol")
    arguments.add_argument("--host", default="127.0.0.1")
    arguments.add_argument("--port", type=int, default=5800, help="0: the system chooses")
    chosen = arguments.parse_args()
    with Server((chosen.host, chosen.port), SyntheticArray()) as server:
        print("listening on %s:%d" % server.server_address, flush=True)
        server.serve_forever()
