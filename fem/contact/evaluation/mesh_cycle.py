"""A loaded gear pair over one mesh cycle: transmission error at several loads, line loads, pressure, load factor.

A tooth pair passes all its positions while the mesh cycle passes once over all pairs in contact. So extremes over one
cycle and all pairs are those of one tooth pair over its engagement.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.contact.contact_pressure import contact_pressure
from fem.contact.evaluation.evaluator import LawEvaluator, Teeth
from fem.contact.law import MeshLaw
from fem.gears.geometry import GearPair

ORDERS = 8  # of the mesh frequency


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshCycle:
    """Solution at the forces (load,), N, and the tilt, rad; `error` (load, position), m, over one mesh cycle.

    Line loads, pressure and load factor are those at the last force.
    """

    pair: GearPair
    evaluator: LawEvaluator
    pinion: Teeth
    wheel: Teeth
    forces: np.ndarray
    tilt: float
    cycle: np.ndarray  # (position,), mesh cycles
    error: np.ndarray

    def line_loads(self) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (position, n) of the pairs near mesh and their line loads (position, n, slice), N/m."""
        state = self.cycle, self.error[-1], self.tilt
        return self.evaluator.near_loads(*state, self.pinion, self.wheel)

    def pressure(self) -> float:
        """Largest Hertz pressure (Pa) on the active flanks.

        Contact of a tip edge beyond the active flank has no Hertzian pressure: the curvature of the flank ends there.
        """
        pairs, loads = self.line_loads()
        law = self.evaluator.law
        xi = self.cycle[:, None, None] - pairs[..., None] + law.cycle_shift
        inside = (xi >= self.pair.xi_start) & (xi <= self.pair.xi_end)
        return float(contact_pressure(self.pair, law, self.cycle, pairs, np.where(inside, loads, 0.0)).max())

    def face_load_factor(self) -> float:
        """Largest mean line load of the face divided by its mean, as K_H beta of ISO 6336-1."""
        along, width = self.line_loads()[1].sum(axis=1).mean(axis=0), self.evaluator.law.slice_width
        return float(along.max() * width.sum() / (along @ width))


def mesh_cycle(
    pair: GearPair,
    law: MeshLaw,
    forces: np.ndarray,
    tilt: float,
    positions: int,
    pinion: Teeth = None,
    wheel: Teeth = None,
) -> MeshCycle:
    """Solve a pair over one mesh cycle.

    Parameters
    ----------
    pair, law : the gears in mesh, and the law of their drive flank
    forces, tilt : (load,) N, > 0, ascending, and rad
    positions : number of positions in a mesh cycle
    pinion, wheel : what single teeth bring, see `evaluator.Teeth`

    Raises
    ------
    LawError : a force is not reached
    """
    evaluator, cycle = LawEvaluator(law), np.arange(positions) / positions
    error = evaluator.approach_at(forces, cycle, np.full((positions, len(forces)), tilt), pinion, wheel).T
    return MeshCycle(
        pair=pair, evaluator=evaluator, pinion=pinion, wheel=wheel, forces=forces, tilt=tilt, cycle=cycle, error=error
    )


def order_amplitudes(error: np.ndarray) -> np.ndarray:
    """Amplitudes (..., order) of the orders 1, 2, ... of the mesh frequency of whole mesh cycles (..., position)."""
    return np.asarray(2 * np.abs(np.fft.rfft(error))[..., 1 : ORDERS + 1] / error.shape[-1])
