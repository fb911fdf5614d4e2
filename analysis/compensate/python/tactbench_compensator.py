"""Pressures from a tactile array's outputs, hysteresis taken out: Python over compensator_c.h (ctypes).

    from tactbench_compensator import Compensator
    stream = Compensator(open("model.json").read(), at_rest=True)
    frame = stream.volts(volts, seconds)     # frame.pressure, frame.uncertainty, frame.status

numpy is used where it is installed (arrays go in and come out without a copy of each element), lists otherwise. The
library is libtactbench_compensator.so.1: at the path in TACTBENCH_COMPENSATOR, next to this file or in the folder tactbench
beside it (where the wheel has it), or on the loader's path.
"""

import ctypes
import os
from array import array
from collections import namedtuple

try:
    import numpy
except ImportError:
    numpy = None

ABI_VERSION = 1
# With OUT_OF_RANGE the uncertainty means nothing; see compensator_c.h.
VALID, FLAT, OUT_OF_RANGE, DEAD, OUTSIDE, UNKNOWN, LOST = 1, 2, 4, 8, 16, 32, 64

_TIME = -4

Frame = namedtuple("Frame", "pressure uncertainty status")


class CompensatorError(Exception):
    """What the library refused, in its own words."""


def load_library(path=None):
    """The shared library, its version checked. Raises CompensatorError or OSError."""
    name, here = "libtactbench_compensator.so.1", os.path.dirname(os.path.abspath(__file__))
    beside = [file for file in (os.path.join(here, name), os.path.join(here, "tactbench", name)) if os.path.exists(file)]
    path = path or os.environ.get("TACTBENCH_COMPENSATOR") or (beside or [name])[0]
    library = ctypes.CDLL(path)
    library.tb_compensator_abi_version.restype = ctypes.c_uint32
    if library.tb_compensator_abi_version() != ABI_VERSION:
        raise CompensatorError(f"{path} has ABI version {library.tb_compensator_abi_version()}, not {ABI_VERSION}")
    pointer, size, real = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_double
    for name, arguments in (("parse", [ctypes.c_char_p, ctypes.c_uint, pointer, ctypes.c_char_p, size]),
                            ("frame", [pointer, pointer, size, real, pointer, pointer, pointer]),
                            ("lost_frame", [pointer, real]), ("start", [pointer, ctypes.c_int, real]),
                            ("tare", [pointer, pointer, size, pointer]),
                            ("set_outside_validity", [pointer, ctypes.c_int])):
        function = getattr(library, "tb_compensator_" + name)
        function.argtypes, function.restype = arguments, ctypes.c_int
    library.tb_compensator_taxels.argtypes, library.tb_compensator_taxels.restype = [pointer], size
    library.tb_compensator_destroy.argtypes, library.tb_compensator_destroy.restype = [pointer], None
    return library


def _zeros(code, count):
    return numpy.zeros(count, {"f": "float32", "H": "uint16"}[code]) if numpy else array(code, bytes(count * array(code).itemsize))


def _floats(values):
    if numpy is not None:
        return numpy.ascontiguousarray(values, "float32").reshape(-1)
    return values if isinstance(values, array) and values.typecode == "f" else array("f", values)


def _address(values):
    return values.ctypes.data if numpy is not None else values.buffer_info()[0]


class Compensator:
    """One handle; not for two threads at once. document: the text of a model of a whole array. scans: averaged into a frame
    that is given; 0: as many as in those that were fitted. at_rest: the sensor is unloaded; worked_seconds: for how long it
    had been conditioned just before."""

    def __init__(self, document, at_rest=False, worked_seconds=0.0, scans=0, library=None):
        self._library, self._handle = load_library(library), None
        handle, message = ctypes.c_void_p(), ctypes.create_string_buffer(300)
        text = document.encode() if isinstance(document, str) else document
        if self._library.tb_compensator_parse(text, scans, ctypes.byref(handle), message, len(message)) != 0:
            raise CompensatorError(message.value.decode(errors="replace"))
        self._handle, self._count = handle, self._library.tb_compensator_taxels(handle)
        if at_rest or worked_seconds:
            self.start(at_rest, worked_seconds)

    def close(self):
        """Gives the memory back; a second time does nothing."""
        handle, self._handle = self._handle, None
        if handle:
            self._library.tb_compensator_destroy(handle)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __del__(self):
        if getattr(self, "_handle", None):
            self.close()

    def _call(self, name, *arguments):
        if not self._handle:
            raise CompensatorError("the compensator is closed")
        code = getattr(self._library, "tb_compensator_" + name)(self._handle, *arguments)
        if code == _TIME:
            raise CompensatorError("the model undoes lag and creep: give the seconds since the frame before")
        if code != 0:
            raise CompensatorError(f"{name} refused: code {code} (compensator_c.h, tb_compensator_code)")

    def volts(self, volts, seconds=float("nan")):
        """One frame, `seconds` after the one before (the first has none before); NaN marks its taxel LOST."""
        volts = _floats(volts)
        if len(volts) != self._count:
            raise CompensatorError(f"{len(volts)} samples for {self._count} taxels")
        frame = Frame(_zeros("f", self._count), _zeros("f", self._count), _zeros("H", self._count))
        self._call("frame", _address(volts), self._count, seconds, *(_address(each) for each in frame))
        return frame

    def lost_frame(self, seconds=float("nan")):
        self._call("lost_frame", seconds)

    def start(self, at_rest=True, worked_seconds=0.0):
        """All taxels are unloaded and at rest, or anywhere."""
        self._call("start", int(bool(at_rest)), worked_seconds)

    def tare(self, volts):
        """`volts` is the unloaded sensor. Returns how many taxels were too far off."""
        volts, refused = _floats(volts), ctypes.c_size_t()
        self._call("tare", _address(volts), len(volts), ctypes.byref(refused))
        return refused.value

    def set_outside_validity(self, outside):
        self._call("set_outside_validity", int(bool(outside)))
