"""Contact pattern: the pressure that a tooth feels over its whole engagement, on its unrolled flank.

It follows from the line loads of `fem.contact.evaluation.evaluator`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.contact.contact_pressure import contact_pressure
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.law import MeshLaw
from fem.gears.geometry import GearPair

POSITIONS = 161  # of the tooth pair on its way through the mesh
ROWS = 141  # on the flank, from its foot to its tip


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactPattern:
    """Greatest Hertz pressure on a flank; the face coordinate is that of the law."""

    name: str  # "healthy", "chipped tooth 3 of the wheel"
    face: np.ndarray  # (place,), m: the ends of the face and the middles of the slices
    diameter: np.ndarray  # (row,), m, of the gear
    pressure: np.ndarray  # (row, place), Pa, nan where nothing touches


def contact_pattern(
    name: str,
    pair: GearPair,
    law: MeshLaw,
    gear: str,
    tooth: int,
    force: float,
    teeth: tuple[np.ndarray, np.ndarray],
    *,
    tilt: float | None = 0.0,
) -> ContactPattern:
    """The pattern of one tooth at one force.

    Parameters
    ----------
    name : of the state
    pair, law : the gears in mesh, and the law of their drive flank
    gear, tooth : "pinion" or "wheel", and the number of the tooth
    force : N, along the transverse line of action
    teeth : terms of the teeth of pinion and wheel, see `fem.contact.teeth`
    tilt : of the gears in the plane of action along the face coordinate of the law, rad; None: force at mid face

    Raises
    ------
    LawError : the force is not reached
    """
    evaluator, overlap = LawEvaluator(law), float(np.abs(law.cycle_shift).max())
    last = law.position_start + law.position_step * (law.compliance.size - 1)
    local = np.linspace(law.position_start - overlap, last + overlap, POSITIONS)
    cycles = tooth + local
    curve = stiffness_curve(law, force, cycles, psi=tilt, clearance_pinion=teeth[0], clearance_wheel=teeth[1])
    pairs, loads = evaluator.line_loads(cycles, curve.transmission_error, curve.tilt, *teeth)
    own = np.where((pairs == tooth)[..., None], loads, 0.0)
    found = contact_pressure(pair, law, cycles, pairs, own).max(axis=1)
    rolls = _flank_rolls(pair, gear)
    xi = _position(pair, gear, rolls)
    pressure = np.column_stack(
        [np.interp(xi, local + shift, column) for shift, column in zip(law.cycle_shift, found.T, strict=True)]
    )
    half = pair.face_width / 2
    return ContactPattern(
        name=name,
        face=np.concatenate([[-half], law.face_coordinate, [half]]),
        diameter=2 * np.hypot(getattr(pair, gear).base_radius, rolls),
        pressure=_to_the_ends(np.where(pressure > 0.0, pressure, np.nan)),
    )


def damaged_part(pair: GearPair, law: MeshLaw, gear: str, gaps: Sequence[np.ndarray]) -> np.ndarray:
    """Where the gaps of faults are on the flank: 0 to 1 over (row, place) of a `ContactPattern`, 1 at the deepest.

    Parameters
    ----------
    pair, law : the gears in mesh, and the law of their drive flank
    gear : "pinion" or "wheel" that has the faults
    gaps : (slice, position), m, of the faults of one tooth
    """
    xi = _position(pair, gear, _flank_rolls(pair, gear))
    grid = law.position_start + law.position_step * np.arange(law.compliance.size)
    nearest = np.clip(np.rint((xi - grid[0]) / law.position_step).astype(int), 0, grid.size - 1)
    total = np.zeros((law.face_coordinate.size, grid.size))
    for gap in gaps:
        total = total + gap
    total = np.minimum(total, 0.1 * pair.pinion.normal_module)
    most = float(total.max())
    return _to_the_ends(total[:, nearest].T / (most or 1.0))


def _to_the_ends(values: np.ndarray) -> np.ndarray:
    """Values (row, slice) with those of the outer slices at the ends of the face, too."""
    return np.column_stack([values[:, 0], values, values[:, -1]])


def _flank_rolls(pair: GearPair, gear: str) -> np.ndarray:
    """Roll lengths (row,), m, of the active flank from its foot to its tip."""
    side = 0 if gear == "pinion" else 1
    low, high = sorted(pair.roll_lengths(xi)[side] for xi in (pair.xi_start, pair.xi_end))
    return np.linspace(low, high, ROWS)


def _position(pair: GearPair, gear: str, roll: np.ndarray) -> np.ndarray:
    """Positions xi on the path of contact at roll lengths of a gear."""
    own = pair.roll_lengths(0.0)[0 if gear == "pinion" else 1]
    return np.asarray((roll - own) / pair.base_pitch * (1 if gear == "pinion" else -1))
