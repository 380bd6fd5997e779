"""Numbers of the unknowns of nodes."""

from __future__ import annotations

import numpy as np


def unknowns_of(nodes: np.ndarray, components: int = 3) -> np.ndarray:
    """Numbers (components node,) of all unknowns of some nodes, node by node."""
    return (components * nodes[:, None] + np.arange(components)).ravel()
