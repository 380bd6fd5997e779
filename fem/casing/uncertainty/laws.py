"""Extrapolation of frequencies from meshes of several sizes, by the kind of their elements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from fem.casing.uncertainty.frequency_limits import FrequencyLimits, frequency_limits
from fem.casing.uncertainty.hexahedral_limits import hexahedral_limits
from fem.elements.solid_elements import SOLIDS

Law = Callable[[Sequence[float], np.ndarray], FrequencyLimits]

RATIOS = (1.3, 1.7)  # relative element sizes of the coarser meshes for quadratic tetrahedra


def law_of(element: str) -> Law:
    """The extrapolation for one of `fem.elements.solid_elements.SOLIDS`, as errors depend on the kind of element."""
    kind = SOLIDS[element]
    if kind.corners == 8:
        return partial(hexahedral_limits, degree=kind.degree)
    return partial(frequency_limits, formal_order=kind.frequency_order)
