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
    """Solution at the forces (load,), N, and tilts (load,), rad; `error` (load, position), m, over one mesh cycle."""

    pair: GearPair
    evaluator: LawEvaluator
    pinion: Teeth
    wheel: Teeth
    forces: np.ndarray
    tilts: np.ndarray
    cycle: np.ndarray  # (position,), mesh cycles
    error: np.ndarray

    def line_loads(self, load: int = -1) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (position, n) of the pairs near mesh and their line loads (position, n, slice), N/m, at one load."""
        state = self.cycle, self.error[load], self.tilts[load]
        return self.evaluator.near_loads(*state, self.pinion, self.wheel)

    def pressure(self, load: int = -1) -> float:
        """Largest Hertz pressure (Pa) on the active flanks.

        Contact of a tip edge beyond the active flank has no Hertzian pressure: the curvature of the flank ends there.
        """
        pairs, loads = self.line_loads(load)
        law = self.evaluator.law
        xi = self.cycle[:, None, None] - pairs[..., None] + law.cycle_shift
        inside = (xi >= self.pair.xi_start) & (xi <= self.pair.xi_end)
        return float(contact_pressure(self.pair, law, self.cycle, pairs, np.where(inside, loads, 0.0)).max())

    def face_load(self, load: int = -1) -> np.ndarray:
        """Line load (slice,), N/m, of all pairs, mean over the mesh cycle."""
        return np.asarray(self.line_loads(load)[1].sum(axis=1).mean(axis=0))

    def face_load_factor(self, load: int = -1) -> float:
        """Largest mean line load of the face divided by its mean, as K_H beta of ISO 6336-1."""
        along, width = self.face_load(load), self.evaluator.law.slice_width
        return float(along.max() * width.sum() / (along @ width))


def mesh_cycle(
    pair: GearPair,
    law: MeshLaw,
    forces: np.ndarray,
    tilts: np.ndarray,
    positions: int,
    pinion: Teeth = None,
    wheel: Teeth = None,
    teeth: int = 1,
) -> MeshCycle:
    """Solve a pair over one mesh cycle.

    Parameters
    ----------
    pair, law : the gears in mesh, and the law of their drive flank
    forces, tilts : (load,) N, > 0, ascending, and rad
    positions : number of positions in a mesh cycle
    pinion, wheel : what single teeth bring, see `evaluator.Teeth`
    teeth : number of mesh cycles, from that of tooth 0 on, of which the mean is taken

    Raises
    ------
    LawError : a force is not reached
    """
    evaluator, cycle = LawEvaluator(law), np.arange(positions) / positions
    every = (np.arange(teeth)[:, None] + cycle).ravel()
    error = evaluator.approach_at(forces, every, np.broadcast_to(tilts, (every.size, len(forces))), pinion, wheel)
    mean = error.T.reshape(len(forces), teeth, positions).mean(axis=1)
    return MeshCycle(
        pair=pair, evaluator=evaluator, pinion=pinion, wheel=wheel, forces=forces, tilts=tilts, cycle=cycle, error=mean
    )


def order_amplitudes(error: np.ndarray) -> np.ndarray:
    """Amplitudes (..., order) of the orders 1, 2, ... of the mesh frequency of whole mesh cycles (..., position)."""
    return np.asarray(2 * np.abs(np.fft.rfft(error))[..., 1 : ORDERS + 1] / error.shape[-1])
