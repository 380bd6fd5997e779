"""The law by which limits and bands of frequencies follow from coarser meshes, and their sizes, by the elements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from fem.casing.mesh_error.frequency_limits import FrequencyLimits, frequency_limits
from fem.casing.mesh_error.hexahedral_limits import hexahedral_limits
from fem.elements.solid_elements import SOLIDS

Law = Callable[[Sequence[float], np.ndarray], FrequencyLimits]

RATIOS = (1.3, 1.7)  # element sizes of the coarser meshes
LARGEST_RATIO = (1.7,)  # of hexahedra, whose law is read from the coarsest mesh alone


def law_of(element: str) -> Law:
    """What elements miss depends on their kind: one of `fem.elements.solid_elements.SOLIDS`."""
    if _follow_edges(element):
        return hexahedral_limits
    return partial(frequency_limits, formal_order=SOLIDS[element].frequency_order)


def ratios_of(element: str) -> tuple[float, ...]:
    """Sizes of the elements of the meshes that the law asks for, over those of the finest."""
    return LARGEST_RATIO if _follow_edges(element) else RATIOS


def _follow_edges(element: str) -> bool:
    kind = SOLIDS[element]
    return kind.corners == 8 and kind.degree == 2
