"""Reading: one channel as a linear function of the motion, value = D q + V q' + A q'' + L lambda + rigid part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(eq=False)
class Reading:
    """Coefficients of one channel; rows are (coordinate,) or (force,), ``rigid`` is on (phi_m, phi_m', phi_m'')."""

    units: str
    displacement: np.ndarray | float = 0.0
    velocity: np.ndarray | float = 0.0
    acceleration: np.ndarray | float = 0.0
    forces: np.ndarray | float = 0.0
    rigid: tuple[float, float, float] = (0.0, 0.0, 0.0)
    shift: np.ndarray | None = None  # (3,) motion by which it reads 1 m along x, y, z; None: that of its coordinates
    vibration: bool = False  # by which the error of a run is judged
