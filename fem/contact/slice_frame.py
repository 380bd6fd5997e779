"""Slices, signs and offsets of a MeshLaw, which every sliced model takes from the gear pair, for either flank."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fem.contact.law import MeshLaw
from fem.gears.geometry import GearPair
from fem.gears.path import PathPoints, path_points

FLANKS = ("drive", "coast")


class ModelError(ValueError):
    """The input of a model is outside its valid range."""


def flank_frame(pair: GearPair, flank: str, slices: int) -> dict[str, Any]:
    """Fields of `MeshLaw` that follow from the pair, the flank and the number of equal slices.

    The drive flank has c' = c. The coast flank of a pinion tooth lags its drive flank by tau = s_w1 / p_wt and meshes
    when the pinion rotates backwards, so c' = tau - c; pair p then consists of pinion tooth -p and wheel tooth -p + 1,
    the tooth behind. In the mirrored view the helix has the opposite hand. The backlash is not part of the law: it is
    subtracted from the coast approach. cycle_shift is positive at y > 0 for a right-hand pinion that rotates in the
    positive sense about +y.
    """
    sign = 1 if flank == "drive" else -1
    width = pair.face_width / slices
    face = (np.arange(slices) + 0.5) * width - pair.face_width / 2.0
    lead = math.tan(pair.base_helix_angle) / pair.base_pitch
    return {
        "flank": flank,
        "face_coordinate": face,
        "slice_width": np.full(slices, width),
        "cycle_shift": sign * pair.pinion.hand_sign * lead * face,
        "cycle_sign": sign,
        "cycle_offset": 0.0 if flank == "drive" else pair.thickness_cycle,
        "base_pitch": pair.base_pitch,
        "pinion_teeth": pair.pinion.teeth,
        "wheel_teeth": pair.wheel.teeth,
        "wheel_tooth_offset": 0 if flank == "drive" else 1,
    }


def law_points(law: MeshLaw, pair: GearPair) -> PathPoints:
    """The contact points of the pair at the positions of the law."""
    xi = law.position_start + law.position_step * np.arange(law.compliance.size)
    return path_points(pair, xi, pair.pinion.normal_module, (np.inf, np.inf))


def window_fraction(gap: np.ndarray) -> np.ndarray:
    """Fraction (position,) of the pairs within the window of finite gaps: 1, and 0 at its first and last point.

    Under an approach greater than the gap at the ends a pair enters and leaves the window in contact. The transition
    takes one cell, so that the force is a continuous function of the position at any load.
    """
    finite = np.isfinite(gap)
    inside = finite[1:-1] & finite[:-2] & finite[2:]
    return np.concatenate([[0.0], inside.astype(float), [0.0]])
