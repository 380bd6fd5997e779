"""Limits and bands of natural frequencies on hexahedra that follow the stresses at edges, from meshes of several sizes.

One quadratic element through a wall misses some of its shear, and of the corners, at any size along the wall: on the
shipped rig elements divided in the walls and beside them lower the frequencies by 0.23 % (22 mm) and 0.27 % (30 mm). No
change of size shows that; the middle of `WALLS` is taken off. Cubic elements miss nothing of the kind. The rest falls
with an order between `SLOW` and `FAST` and is told by the largest size alone: elements end on the faces of feet and
bosses, so that near sizes give meshes that differ by chance. The limit lies half-way, the band reaches to both ends.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fem.casing.uncertainty.frequency_limits import Changes, FrequencyLimits, share_at

SLOW = {2: 2.2, 3: 1.5}  # orders, by the degree of the element
FAST = {2: 3.0, 3: 3.0}
WALLS = {2: (0.0005, 0.0035), 3: (0.0, 0.0)}  # of the frequencies


def hexahedral_limits(sizes: Sequence[float], frequencies: np.ndarray, *, degree: int) -> FrequencyLimits:
    """Limits and bands.

    Parameters
    ----------
    sizes, frequencies : those of `fem.casing.uncertainty.frequency_limits.Changes`; what lies between the finest and
        the coarsest mesh tells which modes are monotone
    degree : of the elements, 2 or 3

    Raises
    ------
    LimitError : as `Changes`
    """
    changes = Changes(np.asarray(sizes, float), np.asarray(frequencies, float))
    log_ratio = math.log(changes.sizes[-1] / changes.sizes[0])
    most, least = (share_at(order[degree], log_ratio) for order in (SLOW, FAST))
    share = 0.5 * (most + least)
    order = math.log1p(1.0 / share) / log_ratio
    return changes.limits(order, share=share, reach=0.5 * (most - least), walls=WALLS[degree])
