"""From gear pairs and casing meshes to what pictures are drawn from."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fem.elements.facets import corner_triangles
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.gears.profile import half_tooth_profile
from pipelines.figures.views import CasingView, GearPairView

VISIBLE = 1 / 7  # of a turn before it meshes: there a damaged tooth is not hidden by the other gear


def gear_view(
    pair: GearPair, marked: tuple[str, int] | None = None, *, missing: bool = True, in_mesh: bool = False
) -> GearPairView:
    """The pair at a whole mesh cycle, tooth pairs touching at the pitch point.

    The pinion turns counter-clockwise and drives; seen in the picture pinion tooth i follows tooth i - 1 clockwise and
    wheel tooth j follows tooth j - 1 counter-clockwise, so that pair (i, i) follows pair (i - 1, i - 1). With a marked
    tooth the cycle is chosen so that it meshes after a seventh of a turn of its gear.

    Parameters
    ----------
    pair : the gears in mesh
    marked : gear ("pinion" or "wheel") and number of the damaged tooth, or None
    missing : the marked tooth is not there
    in_mesh : keep the cycle 0 instead
    """
    radii = pair.working_radii
    # tooth 0 touches at the pitch point with its upper (pinion) or lower (wheel) flank; its middle lies beside it
    pinion_zero = -pair.pinion.half_thickness_angle(radii[0])
    wheel_zero = math.pi - pair.wheel.half_thickness_angle(radii[1])
    cycle, angle = 0, 0.0
    if marked is not None:
        gear, tooth = marked
        teeth = pair.pinion.teeth if gear == "pinion" else pair.wheel.teeth
        cycle = 0 if in_mesh else shown_cycle(pair, marked)
        rotation = 2 * math.pi * (cycle - tooth) / teeth
        angle = pinion_zero + rotation if gear == "pinion" else wheel_zero - rotation
    return GearPairView(
        pinion_outline=outline(pair.pinion, pinion_zero),
        wheel_outline=outline(pair.wheel, wheel_zero),
        pinion_teeth=pair.pinion.teeth,
        wheel_teeth=pair.wheel.teeth,
        pinion_bore=pair.pinion.bore_radius,
        wheel_bore=pair.wheel.bore_radius,
        pinion_twist=_twist(pair.pinion),
        wheel_twist=_twist(pair.wheel),
        face_width=pair.face_width,
        centre_distance=pair.axis_distance,
        marked_gear="" if marked is None else marked[0],
        marked_angle=angle,
        missing=missing,
    )


def shown_cycle(pair: GearPair, marked: tuple[str, int] | None) -> int:
    """The mesh cycle at which a view out of mesh shows the pair."""
    return 0 if marked is None else marked[1] - round(VISIBLE * getattr(pair, marked[0]).teeth)


def outline(gear: Gear, centre_angle: float) -> np.ndarray:
    """The transverse profile of all teeth, counter-clockwise (n, 2) in m, the middle of one tooth at `centre_angle`."""
    half = half_tooth_profile(gear, n_fillet=6, n_flank=8, n_tip=2).points  # mid space at x > 0 to mid tooth on +y
    tooth = np.vstack([half[:-1], half[::-1] * [-1.0, 1.0]])[:-1]  # counter-clockwise, mid space kept once
    corners = []
    for number in range(gear.teeth):
        angle = centre_angle - math.pi / 2 + 2 * math.pi * number / gear.teeth
        rotation = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
        corners.append(tooth @ rotation)
    return np.concatenate(corners)


def casing_view(nodes: np.ndarray, facets: np.ndarray, names: Sequence[str], positions: np.ndarray) -> CasingView:
    """Surface of a casing: its corner nodes alone, and its key points.

    Parameters
    ----------
    nodes : float (n, 3), m
    facets : int (f, k), see `fem.elements.facets`
    names, positions : key points, float (p, 3), m
    """
    corners = corner_triangles(np.asarray(facets)).reshape(-1, 3)
    used, triangles = np.unique(corners, return_inverse=True)
    return CasingView(
        nodes=np.asarray(nodes, dtype=float)[used],
        triangles=triangles.reshape(corners.shape),
        points={name: np.asarray(place, dtype=float) for name, place in zip(names, positions, strict=True)},
    )


def _twist(gear: Gear) -> float:
    """Rotation of the section per metre along the axis, rad/m: tan(beta) / r, positive for a right hand."""
    return gear.hand_sign * math.tan(abs(gear.helix_angle)) / gear.reference_radius
