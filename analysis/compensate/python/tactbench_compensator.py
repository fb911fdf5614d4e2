"""Pressures from a tactile array's raw counts, hysteresis taken out: Python over compensator_c.h (ctypes).

    from tactbench_compensator import Compensator, Taxel
    compensator = Compensator(pressure, taxels, volts_per_count=5.0 / 65536)
    frame = compensator.counts(counts)        # frame.pressure, frame.uncertainty, frame.status

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
# With OUT_OF_RANGE the pressure is the loop's end and its uncertainty means nothing; see compensator_c.h.
VALID, FLAT, OUT_OF_RANGE, DEAD, OUTSIDE, UNKNOWN, LOST = 1, 2, 4, 8, 16, 32, 64

_DOUBLE, _AT_REST, _EXACT_OUTER = 1, 2, 4
_USABLE, _FALLING = 1, 2

Frame = namedtuple("Frame", "pressure uncertainty status")


class CompensatorError(Exception):
    """What the library refused, in its own words."""


class Taxel:
    """Patterns in volts at the common pressures, ELAM's five parameters, noise in volts; usable=False: dead. residual: what the
    model leaves, by equal intervals of the pressures rising, then falling (compensator_c.h)."""

    def __init__(self, ascending=(), descending=(), parameters=(0.5, 0.5, 0.0, 0.5, 0.5), noise=0.0, falling=False,
                 usable=True, residual=()):
        self.ascending, self.descending = list(ascending), list(descending)
        self.parameters, self.noise, self.falling, self.usable = tuple(parameters), noise, falling, usable
        self.residual = list(residual)


class DynamicTaxel:
    """Preisach on the linearised output: Everett's table in linearised volts (compensator_c.h), zero in volts, 1 / the
    divider's highest output, creep over the array's, share that comes late, noise in volts; usable=False: dead."""

    def __init__(self, everett=(), zero=0.0, per_amplitude=0.0, creep_scale=1.0, lag_share=0.0, noise=0.0,
                 falling=False, usable=True, residual_scale=1.0):
        self.residual_scale = residual_scale
        self.everett, self.zero, self.per_amplitude = list(everett), zero, per_amplitude
        self.creep_scale, self.lag_share, self.noise = creep_scale, lag_share, noise
        self.falling, self.usable = falling, usable


class _Setup(ctypes.Structure):
    _fields_ = [("struct_size", ctypes.c_size_t), ("flags", ctypes.c_uint32), ("longest_gap", ctypes.c_uint32),
                ("taxels", ctypes.c_size_t), ("knots", ctypes.c_size_t),
                ("pressure", ctypes.POINTER(ctypes.c_double)), ("volts_per_count", ctypes.c_double),
                ("flat_pressure", ctypes.c_double), ("known_pressure", ctypes.c_double),
                ("tare_share", ctypes.c_double), ("residual_levels", ctypes.c_size_t)]


class _Taxel(ctypes.Structure):
    _fields_ = [("struct_size", ctypes.c_size_t), ("flags", ctypes.c_uint32), ("reserved", ctypes.c_uint32),
                ("ascending", ctypes.POINTER(ctypes.c_double)), ("descending", ctypes.POINTER(ctypes.c_double)),
                ("alpha_d", ctypes.c_double), ("beta_d", ctypes.c_double), ("alpha_a1", ctypes.c_double),
                ("alpha_a0", ctypes.c_double), ("beta_a", ctypes.c_double), ("noise_volts", ctypes.c_double),
                ("residual", ctypes.POINTER(ctypes.c_double))]


class _DynamicSetup(ctypes.Structure):
    _fields_ = [("struct_size", ctypes.c_size_t), ("flags", ctypes.c_uint32), ("longest_gap", ctypes.c_uint32),
                ("taxels", ctypes.c_size_t), ("intervals", ctypes.c_size_t), ("pressure_low", ctypes.c_double),
                ("pressure_high", ctypes.c_double), ("volts_per_count", ctypes.c_double),
                ("flat_pressure", ctypes.c_double), ("known_pressure", ctypes.c_double),
                ("tare_share", ctypes.c_double), ("creep_seconds", ctypes.c_double * 3),
                ("creep_share", ctypes.c_double * 3), ("creep_half", ctypes.c_double),
                ("lag_seconds", ctypes.c_double), ("top_share", ctypes.c_double),
                ("residual", ctypes.POINTER(ctypes.c_double)), ("worked_seconds", ctypes.c_double)]


class _DynamicTaxel(ctypes.Structure):
    _fields_ = [("struct_size", ctypes.c_size_t), ("flags", ctypes.c_uint32), ("reserved", ctypes.c_uint32),
                ("zero_volts", ctypes.c_double), ("per_amplitude", ctypes.c_double),
                ("everett", ctypes.POINTER(ctypes.c_double)), ("creep_scale", ctypes.c_double),
                ("lag_share", ctypes.c_double), ("noise_volts", ctypes.c_double),
                ("residual_scale", ctypes.c_double)]


def load_library(path=None):
    """The shared library, its version checked. Raises CompensatorError or OSError."""
    name, here = "libtactbench_compensator.so.1", os.path.dirname(os.path.abspath(__file__))
    beside = [file for file in (os.path.join(here, name), os.path.join(here, "tactbench", name)) if os.path.exists(file)]
    path = path or os.environ.get("TACTBENCH_COMPENSATOR") or (beside or [name])[0]
    library = ctypes.CDLL(path)
    library.tb_compensator_abi_version.restype = ctypes.c_uint32
    if library.tb_compensator_abi_version() != ABI_VERSION:
        raise CompensatorError(f"{path} has ABI version {library.tb_compensator_abi_version()}, not {ABI_VERSION}")
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    for name, arguments in (("create", [pointer, pointer, pointer, ctypes.c_char_p, size]),
                            ("create_dynamic", [pointer, pointer, pointer, ctypes.c_char_p, size]),
                            ("set_interval", [pointer, ctypes.c_double]),
                            ("counts", [pointer, pointer, size, pointer, pointer, pointer]),
                            ("counts_double", [pointer, pointer, size, pointer, pointer, pointer]),
                            ("volts", [pointer, pointer, size, pointer, pointer, pointer]),
                            ("volts_double", [pointer, pointer, size, pointer, pointer, pointer]),
                            ("lost_frame", [pointer]), ("reset", [pointer]), ("reset_unknown", [pointer]),
                            ("tare", [pointer, pointer, size, pointer]),
                            ("set_outside_validity", [pointer, ctypes.c_int])):
        function = getattr(library, "tb_compensator_" + name)
        function.argtypes, function.restype = arguments, ctypes.c_int
    library.tb_compensator_destroy.argtypes, library.tb_compensator_destroy.restype = [pointer], None
    return library


_CODES = {"H": "uint16", "f": "float32", "d": "float64"}


def _zeros(code, count):
    return numpy.zeros(count, _CODES[code]) if numpy else array(code, bytes(count * array(code).itemsize))


def _given(code, values):
    if numpy:
        return numpy.ascontiguousarray(values, _CODES[code]).reshape(-1)
    return values if isinstance(values, array) and values.typecode == code else array(code, values)


def _address(values):
    return values.ctypes.data if numpy else values.buffer_info()[0]


class Compensator:
    """One handle; not for two threads at once. double=True gives float64 results."""

    def __init__(self, pressure, taxels, volts_per_count, double=False, at_rest=False, exact_outer=False,
                 longest_gap=0, flat_pressure=0.0, known_pressure=0.0, tare_share=0.0, library=None):
        self._library, self._handle, self._real = load_library(library), None, "d" if double else "f"
        self._count = len(taxels)
        self._functions = ["tb_compensator_" + name + ("_double" if double else "") for name in ("counts", "volts")]
        knots = len(pressure)
        keep, levels = [], 0  # alive until the library has copied them

        def doubles(values):
            if len(values) != knots:
                raise CompensatorError(f"a pattern has {len(values)} values for {knots} pressures")
            keep.append((ctypes.c_double * knots)(*values))
            return ctypes.cast(keep[-1], ctypes.POINTER(ctypes.c_double))

        rows = (_Taxel * max(1, len(taxels)))()
        for row, taxel in zip(rows, taxels):
            row.struct_size = ctypes.sizeof(_Taxel)
            if not taxel.usable:
                continue
            row.flags = _USABLE | (_FALLING if taxel.falling else 0)
            row.ascending, row.descending = doubles(taxel.ascending), doubles(taxel.descending)
            row.alpha_d, row.beta_d, row.alpha_a1, row.alpha_a0, row.beta_a = taxel.parameters
            row.noise_volts = taxel.noise
            if taxel.residual:
                levels = levels or len(taxel.residual) // 2
                if len(taxel.residual) != 2 * levels:
                    raise CompensatorError(f"a residual has {len(taxel.residual)} values, not {2 * levels}")
                keep.append((ctypes.c_double * len(taxel.residual))(*taxel.residual))
                row.residual = ctypes.cast(keep[-1], ctypes.POINTER(ctypes.c_double))
        flags = (_DOUBLE if double else 0) | (_AT_REST if at_rest else 0) | (_EXACT_OUTER if exact_outer else 0)
        setup = _Setup(ctypes.sizeof(_Setup), flags, longest_gap, len(taxels), knots, doubles(list(pressure)),
                       volts_per_count, flat_pressure, known_pressure, tare_share, levels)
        self._create(self._library.tb_compensator_create, setup, rows)

    def _create(self, create, setup, rows):
        handle, message = ctypes.c_void_p(), ctypes.create_string_buffer(200)
        if create(ctypes.byref(setup), rows, ctypes.byref(handle), message, len(message)) != 0:
            raise CompensatorError(message.value.decode())
        self._handle = handle

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
        code = getattr(self._library, name)(self._handle, *arguments)
        if code != 0:
            raise CompensatorError(f"{name} refused: code {code} (compensator_c.h, tb_compensator_code)")

    def _frame(self, function, code, values):
        values = _given(code, values)
        if len(values) != self._count:
            raise CompensatorError(f"{len(values)} samples for {self._count} taxels")
        frame = Frame(_zeros(self._real, self._count), _zeros(self._real, self._count), _zeros("H", self._count))
        self._call(function, _address(values), self._count, *(_address(each) for each in frame))
        return frame

    def counts(self, counts):
        """One frame of raw counts."""
        return self._frame(self._functions[0], "H", counts)

    def volts(self, volts):
        """One frame in volts; NaN marks its taxel LOST."""
        return self._frame(self._functions[1], self._real, volts)

    def lost_frame(self):
        self._call("tb_compensator_lost_frame")

    def reset(self):
        self._call("tb_compensator_reset")

    def reset_unknown(self):
        self._call("tb_compensator_reset_unknown")

    def tare(self, counts):
        """`counts` is the unloaded sensor. Returns how many taxels were too far off."""
        counts, refused = _given("H", counts), ctypes.c_size_t()
        self._call("tb_compensator_tare", _address(counts), len(counts), ctypes.byref(refused))
        return refused.value

    def set_outside_validity(self, outside):
        self._call("tb_compensator_set_outside_validity", int(bool(outside)))


class DynamicCompensator(Compensator):
    """The dynamic Preisach model's compensator: tell it the time between frames by set_interval. creep: pairs (seconds,
    share) of up to three elements; worked_seconds: how long the sensor was conditioned just before a start; the other
    options are Compensator's and compensator_c.h's."""

    def __init__(self, intervals, taxels, volts_per_count, pressure_low, pressure_high, creep=(), creep_half=0.0,
                 lag_seconds=0.0, top_share=0.0, residual=(), double=False, at_rest=False, longest_gap=0, flat_pressure=0.0,
                 known_pressure=0.0, tare_share=0.0, library=None, worked_seconds=0.0):
        self._library, self._handle, self._real = load_library(library), None, "d" if double else "f"
        self._count = len(taxels)
        self._functions = ["tb_compensator_" + name + ("_double" if double else "") for name in ("counts", "volts")]
        size = (intervals + 1) * (intervals + 2) // 2
        rows, keep = (_DynamicTaxel * max(1, len(taxels)))(), []
        for number, (row, taxel) in enumerate(zip(rows, taxels)):
            row.struct_size = ctypes.sizeof(_DynamicTaxel)
            if not taxel.usable:
                continue
            if len(taxel.everett) != size:
                raise CompensatorError(f"taxel {number}: its table has {len(taxel.everett)} values, not {size}")
            keep.append((ctypes.c_double * size)(*taxel.everett))
            row.flags = _USABLE | (_FALLING if taxel.falling else 0)
            row.everett = ctypes.cast(keep[-1], ctypes.POINTER(ctypes.c_double))
            row.zero_volts, row.per_amplitude = taxel.zero, taxel.per_amplitude
            row.creep_scale, row.lag_share, row.noise_volts = taxel.creep_scale, taxel.lag_share, taxel.noise
            row.residual_scale = taxel.residual_scale
        seconds, shares = (ctypes.c_double * 3)(), (ctypes.c_double * 3)()
        for j, (time, share) in enumerate(creep):
            seconds[j], shares[j] = time, share
        setup = _DynamicSetup(ctypes.sizeof(_DynamicSetup), (_DOUBLE if double else 0) | (_AT_REST if at_rest else 0),
                              longest_gap, len(taxels), intervals, pressure_low, pressure_high, volts_per_count,
                              flat_pressure, known_pressure, tare_share, seconds, shares, creep_half, lag_seconds,
                              top_share)
        setup.worked_seconds = worked_seconds
        if residual:
            if len(residual) != 2 * intervals:
                raise CompensatorError(f"residual has {len(residual)} values, not {2 * intervals}")
            keep.append((ctypes.c_double * len(residual))(*residual))
            setup.residual = ctypes.cast(keep[-1], ctypes.POINTER(ctypes.c_double))
        self._create(self._library.tb_compensator_create_dynamic, setup, rows)

    def set_interval(self, seconds):
        """Seconds from one frame to the next, from now on."""
        self._call("tb_compensator_set_interval", ctypes.c_double(seconds))
