"""Limits and bands of natural frequencies on hexahedra that follow the stresses at edges (`fem.casing.edges`).

One element through a wall misses some of its shear, and of the corners, at any size along the wall: on the shipped rig
elements divided in the walls and beside them lower the frequencies by 0.23 % (22 mm) and 0.27 % (30 mm). No change of
size shows that; the middle of `WALLS` is taken off. The rest falls with an order between `SLOW` and `FAST` (2.6 from 30
to 22 mm with walls divided) and is told by the largest size alone: elements end on the faces of feet and
bosses, so that near sizes give meshes that differ by chance. The limit lies half-way, the band reaches to both ends.

The numbers were chosen with the errors of two housings in sight, the rig and one with walls of 5 mm; `python -m
benchmarks.casing_limits` shows them and others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fem.casing.mesh_error.frequency_limits import Changes, FrequencyLimits, share_at

SLOW, FAST = 2.2, 3.0  # orders
WALLS = (0.0005, 0.0035)  # of the frequencies


def hexahedral_limits(sizes: Sequence[float], frequencies: np.ndarray) -> FrequencyLimits:
    """Limits and bands.

    Parameters
    ----------
    sizes, frequencies : those of `fem.casing.mesh_error.frequency_limits.Changes`; what lies between the finest and the
        coarsest mesh tells which modes are monotone

    Raises
    ------
    LimitError : as `Changes`
    """
    changes = Changes(np.asarray(sizes, float), np.asarray(frequencies, float))
    log_ratio = math.log(changes.sizes[-1] / changes.sizes[0])
    most, least = (share_at(order, log_ratio) for order in (SLOW, FAST))
    share = 0.5 * (most + least)
    order = math.log1p(1.0 / share) / log_ratio
    return changes.limits(order, share=share, reach=0.5 * (most - least), walls=WALLS)
