"""Extrapolation of frequencies to zero element size, by the kind of element; `frequency_limits` has the common method.

`hexahedral_limits` is for hexahedra with edge-singularity enrichment. One quadratic element through a wall cannot
represent all of its shear, nor the corners, at any size along the wall. On the shipped rig, elements divided in and
next to the walls lower the frequencies by 0.23 % (22 mm) and 0.27 % (30 mm). A change of size does not show this error,
so the middle of `WALLS` is subtracted; cubic elements do not have it. The rest decreases with an order between `SLOW`
and `FAST`. It is estimated from the largest size alone: elements end on the faces of feet and bosses, so that meshes of
similar sizes scatter. The extrapolated frequency is the middle; the band extends to both ends.

Quadratic tetrahedra of 1 to 3 wall thicknesses have the same error. Without this part, the extrapolated frequencies of
two housings with walls of 9 and 10 mm are 0.5 to 2.0 % above those of cubic elements, and of a third 0.25 +- 0.39 %.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from fem.casing.uncertainty.frequency_limits import Changes, FrequencyLimits, frequency_limits, share_at
from fem.elements.solid_elements import SOLIDS

Extrapolation = Callable[[Sequence[float], np.ndarray], FrequencyLimits]

RATIOS = (1.3, 1.7)  # relative element sizes of the coarser meshes for quadratic tetrahedra
SLOW = {2: 2.2, 3: 1.5}  # orders, by the degree of the element
FAST = {2: 3.0, 3: 3.0}
WALLS = {2: (0.0005, 0.0035), 3: (0.0, 0.0)}  # of the frequencies
WALLS_OF_TETRAHEDRA = {1: (0.0, 0.0), 2: (0.0, 0.02), 3: (0.0, 0.0)}


def hexahedral_limits(sizes: Sequence[float], frequencies: np.ndarray, *, degree: int) -> FrequencyLimits:
    """Extrapolated frequencies and uncertainty bands.

    Parameters
    ----------
    sizes, frequencies : those of `fem.casing.uncertainty.frequency_limits.Changes`; meshes between the finest and the
        coarsest only show which modes are monotone
    degree : of the elements, 2 or 3

    Raises
    ------
    LimitError : as `Changes`
    """
    changes = Changes(sizes, frequencies)
    log_ratio = math.log(changes.sizes[-1] / changes.sizes[0])
    most, least = (share_at(order[degree], log_ratio) for order in (SLOW, FAST))
    share = 0.5 * (most + least)
    order = math.log1p(1.0 / share) / log_ratio
    return changes.limits(order, share=share, reach=0.5 * (most - least), walls=WALLS[degree])


def extrapolation_of(element: str) -> Extrapolation:
    """The extrapolation for one of `fem.elements.solid_elements.SOLIDS`, as errors depend on the kind of element."""
    kind = SOLIDS[element]
    if kind.corners == 8:
        return partial(hexahedral_limits, degree=kind.degree)
    return partial(frequency_limits, formal_order=kind.frequency_order, walls=WALLS_OF_TETRAHEDRA[kind.degree])
