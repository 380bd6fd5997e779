"""The law by which limits and bands of frequencies follow from three meshes, by the elements of these."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from fem.casing.mesh_error.frequency_limits import FrequencyLimits, frequency_limits
from fem.casing.mesh_error.hexahedral_limits import hexahedral_limits
from fem.elements.solid_elements import SOLIDS

Law = Callable[[Sequence[float], np.ndarray], FrequencyLimits]


def law_of(element: str) -> Law:
    """What elements miss depends on their kind: one of `fem.elements.solid_elements.SOLIDS`."""
    kind = SOLIDS[element]
    if kind.corners == 8 and kind.degree == 2:
        return hexahedral_limits
    return partial(frequency_limits, formal_order=kind.frequency_order)
