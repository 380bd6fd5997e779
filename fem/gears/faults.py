"""Faults that enter a mesh law through the clearance of single teeth."""

from __future__ import annotations

import numpy as np

from fem.gears.gear import GeometryError


def missing_tooth(clearance: np.ndarray, tooth: int) -> np.ndarray:
    """The clearances (z,) of one flank with tooth number `tooth` (0 .. z - 1) broken off: +inf there, a new array.

    Apply it to the drive and the coast flank alike. The compliance of its neighbours is left as it is: it changes by
    about 1 %.

    Raises
    ------
    GeometryError : no such tooth
    """
    result = np.array(clearance, dtype=float)
    if not 0 <= tooth < result.size:
        raise GeometryError(f"missing tooth: number is {tooth!r}; the gear has teeth 0 to {result.size - 1}")
    result[tooth] = np.inf
    return result
