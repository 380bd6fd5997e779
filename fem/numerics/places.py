"""Places in messages, and unknowns of nodes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np


def in_mm(place: Iterable[float]) -> str:
    """A place given in metres as text, such as "(12.5, 0, -3) mm"."""
    return f"({', '.join(f'{round(1000 * value, 6) + 0.0:.5g}' for value in place)}) mm"


def unknowns_of(nodes: np.ndarray, components: int = 3) -> np.ndarray:
    """Numbers (components node,) of all unknowns of some nodes, node by node."""
    return (components * nodes[:, None] + np.arange(components)).ravel()
