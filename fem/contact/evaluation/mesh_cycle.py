"""A loaded gear pair over one mesh cycle: transmission error at several loads, pressure, load factor.

A tooth pair passes all its positions while the mesh cycle passes once over all pairs in contact. So extremes over one
cycle and all pairs are those of one tooth pair over its engagement.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.contact.contact_pressure import flank_pressure
from fem.contact.evaluation.evaluator import LawEvaluator, Teeth
from fem.gears.geometry import GearPair

ORDERS = 8  # of the mesh frequency


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshCycle:
    """Solution over one mesh cycle; methods take the number of a force, by default the last one.

    pair, evaluator, teeth : the gears in mesh, the law of their drive flank, and what single teeth bring
    tilt : rad
    cycle : (position,) mesh cycles
    error : (load, position) transmission error, m
    """

    pair: GearPair
    evaluator: LawEvaluator
    teeth: tuple[Teeth, Teeth]
    tilt: float
    cycle: np.ndarray
    error: np.ndarray

    def pressure(self, load: int = -1) -> np.ndarray:
        """Largest Hertz pressure (slice,), Pa, on the active flanks."""
        pressure = flank_pressure(self.pair, self.evaluator.law, self.cycle, *self.line_loads(load))
        return np.asarray(pressure.max(axis=(0, 1)))

    def line_load(self, load: int = -1) -> np.ndarray:
        """Mean line load (slice,), N/m, of all pairs in contact."""
        return np.asarray(self.line_loads(load)[1].sum(axis=1).mean(axis=0))

    def face_load_factor(self, load: int = -1) -> float:
        """Largest mean line load of the face divided by its mean, as K_H beta of ISO 6336-1."""
        along, width = self.line_load(load), self.evaluator.law.slice_width
        return float(along.max() * width.sum() / (along @ width))

    def line_loads(self, load: int = -1) -> tuple[np.ndarray, np.ndarray]:
        """Successive numbers (position, pair) of all pairs that carry load, and their line loads (..., slice), N/m."""
        pairs, loads = self.evaluator.line_loads(self.cycle, self.error[load], self.tilt, *self.teeth)
        used = np.flatnonzero(loads.any(axis=(0, 2)))
        near = slice(used[0], used[-1] + 1)
        return pairs[:, near], loads[:, near]


def mesh_cycle(
    pair: GearPair,
    evaluator: LawEvaluator,
    forces: np.ndarray,
    tilt: float,
    positions: int,
    teeth: tuple[Teeth, Teeth] = (None, None),
) -> MeshCycle:
    """Solve a pair over one mesh cycle.

    Parameters
    ----------
    pair, evaluator : the gears in mesh, and the law of their drive flank
    forces, tilt : (load,) N, > 0, ascending, and rad
    positions : number of positions in a mesh cycle
    teeth : what single teeth of pinion and wheel bring, see `evaluator.Teeth`

    Raises
    ------
    LawError : a force is not reached
    """
    cycle = np.arange(positions) / positions
    error = evaluator.approach_at(forces, cycle, tilt, *teeth).T
    return MeshCycle(pair=pair, evaluator=evaluator, teeth=teeth, tilt=tilt, cycle=cycle, error=error)


def order_amplitudes(error: np.ndarray) -> np.ndarray:
    """Amplitudes (..., order) of the orders 1, 2, ... of the mesh frequency of whole mesh cycles (..., position)."""
    return np.asarray(2 * np.abs(np.fft.rfft(error))[..., 1 : ORDERS + 1] / error.shape[-1])
