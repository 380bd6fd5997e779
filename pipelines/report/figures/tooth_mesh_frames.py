"""What happens in the mesh of a stage while the damaged tooth passes: contact lines, loads and shares, frame by frame.

The picture's frame: pinion axis at the origin along z, wheel axis at x = a, the pinion turns counter-clockwise and
drives. Contact lies on the line of action through the pitch point (r_w1, 0) along n = (sin alpha_wt, cos alpha_wt);
z runs with the rotation vector of the pinion, as the face coordinate of the law does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.contact.contact_pressure import contact_pressure
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import StiffnessCurve, stiffness_curve
from fem.contact.law import MeshLaw
from fem.gears.geometry import GearPair
from pipelines.report.figures.views import PairStates

PASSAGE = 2.5  # pitches before and after
CURVE_POINTS = 161


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshFrames:
    """One state of the teeth over the frames: lines (frame, pair, slice); nan where nothing touches."""

    name: str  # "healthy", "missing tooth"
    points: np.ndarray  # (frame, pair, slice, 3), m
    load: np.ndarray  # (frame, pair, slice), N/m
    pressure: np.ndarray  # (frame, pair, slice), Pa
    curve: StiffnessCurve  # over the whole passage


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshView(PairStates):
    """The gears, the mesh cycles of the frames, and one or two states of the teeth, the healthy one first.

    `marked` names the damaged tooth of the second state, "" without one.
    """

    cycles: np.ndarray
    states: tuple[MeshFrames, ...]

    @property
    def most_load(self) -> float:
        """Highest line load of all states, N/m."""
        return max(float(np.nanmax(state.load)) for state in self.states)


def passage(middle: float, frames: int) -> np.ndarray:
    """Mesh cycles of the frames around the passage of a tooth; one frame stands in the middle."""
    if frames == 1:
        return np.array([middle])
    return middle + np.linspace(-PASSAGE, PASSAGE, frames)


def mesh_frames(
    name: str, pair: GearPair, law: MeshLaw, load: float, cycles: np.ndarray, pinion: np.ndarray, wheel: np.ndarray
) -> MeshFrames:
    """Solve every frame at one force without tilt.

    Parameters
    ----------
    name : of this state of the teeth
    pair, law : the gears in mesh, and the law of their drive flank
    load : N, along the transverse line of action
    cycles : (frame,) mesh cycles
    pinion, wheel : (tooth,) clearances, m, or (tooth, 6) tooth terms, see `fem.contact.teeth`

    Raises
    ------
    LawError : the force is not reached
    """
    centre = float(np.median(cycles))
    whole = centre + np.linspace(-PASSAGE, PASSAGE, CURVE_POINTS)
    curve, states = (
        stiffness_curve(law, load, places, clearance_pinion=pinion, clearance_wheel=wheel) for places in (whole, cycles)
    )
    pairs, loads = LawEvaluator(law).line_loads(cycles, states.transmission_error, 0.0, pinion, wheel)
    own = law.cycle_sign * cycles + law.cycle_offset
    points = contact_places(pair, own[:, None, None] - pairs[..., None] + law.cycle_shift, law.face_coordinate)
    points[~loads.any(axis=2)] = np.nan
    pressure = np.where(loads > 0.0, contact_pressure(pair, law, cycles, pairs, loads), np.nan)
    lines = np.where(loads > 0.0, loads, np.nan)
    return MeshFrames(name=name, points=points, load=lines, pressure=pressure, curve=curve)


def contact_places(pair: GearPair, xi: np.ndarray, face: np.ndarray) -> np.ndarray:
    """Points (pair, slice, 3), m, on the plane of action at xi (pair, slice) base pitches from the pitch point."""
    alpha, along = pair.working_pressure_angle, xi * pair.base_pitch
    x, y = pair.working_radii[0] + along * np.sin(alpha), along * np.cos(alpha)
    return np.stack([x, y, np.broadcast_to(face, xi.shape)], axis=-1)
