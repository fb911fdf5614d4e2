"""Runs and models of tactbench in Python.

    from tactbench import Compensator, Store
    frames = Store("runs.db").frames(1)                # xarray.Dataset: volts, reference_psi ..., each with its units
    tactbench.to_nexus("runs.db", 1, "run.h5")         # the whole run as HDF5 with NeXus' names
    stream = Compensator.load("runs.db", run=1)        # or .load("model.json"): counts in, pressures out
    frame = stream.counts(counts, seconds)             # frame.pressure, frame.uncertainty, frame.status

Python 3.8 or newer. Reading frames needs numpy, and xarray or pandas for their objects; to_nexus needs h5py; compensating
needs nothing else.
"""

from tactbench_compensator import (DEAD, FLAT, LOST, OUT_OF_RANGE, OUTSIDE, UNKNOWN, VALID, CompensatorError,
                                   Frame)

from .errors import MissingPackage, TactbenchError
from .models import Compensator
from .nexus import to_nexus
from .store import Store

__all__ = ["Compensator", "CompensatorError", "DEAD", "FLAT", "Frame", "LOST", "MissingPackage",
           "OUTSIDE", "OUT_OF_RANGE", "Store", "TactbenchError", "UNKNOWN", "VALID", "to_nexus"]
