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
    """Solution over one mesh cycle; pressure and load factor are those at the last force.

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

    def pressure(self) -> float:
        """Largest Hertz pressure (Pa) on the active flanks."""
        return float(flank_pressure(self.pair, self.evaluator.law, self.cycle, *self._line_loads()).max())

    def face_load_factor(self) -> float:
        """Largest mean line load of the face divided by its mean, as K_H beta of ISO 6336-1."""
        along, width = self._line_loads()[1].sum(axis=1).mean(axis=0), self.evaluator.law.slice_width
        return float(along.max() * width.sum() / (along @ width))

    def _line_loads(self) -> tuple[np.ndarray, np.ndarray]:
        return self.evaluator.line_loads(self.cycle, self.error[-1], self.tilt, *self.teeth)


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
