"""Geometry that pictures show: gear pairs and casing surfaces at their places in the machine."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from fem.contact.faults.tooth_fault import ToothFault
from fem.contact.law import MeshLaw
from fem.elements.facets import corner_triangles
from fem.gears.gear import Gear
from fem.gears.geometry import GearPair
from fem.gears.profile import half_tooth_profile
from pipelines.machine.machine_model import MachineModel
from pipelines.machine.scene_flanks import Fault, first_tooth_fault
from pipelines.report.figures.damage import drawn_tooth
from pipelines.report.figures.damaged_tooth import DrawnTooth
from pipelines.report.figures.gear_frame import scene_frame
from pipelines.report.figures.views import GearPairView, GearView

VISIBLE = 1 / 7  # of a turn before it meshes, where the other gear does not hide a damaged tooth


def gear_view(
    pair: GearPair,
    marked: tuple[str, int] | None = None,
    *,
    missing: bool = True,
    in_mesh: bool = False,
    tooth: DrawnTooth | None = None,
    frame: np.ndarray | None = None,
    sense: int = 1,
) -> GearPairView:
    """The pair at a whole mesh cycle, with a tooth pair in contact at the pitch point.

    The pinion turns counter-clockwise and drives; in the picture pinion tooth i follows tooth i - 1 clockwise and
    wheel tooth j follows tooth j - 1 counter-clockwise, so that pair (i, i) follows pair (i - 1, i - 1). With a marked
    tooth the cycle is chosen so that it meshes after a seventh of a turn of its gear.

    Parameters
    ----------
    pair : the gears in mesh
    marked : gear ("pinion" or "wheel") and number of the damaged tooth, or None
    missing : the marked tooth is missing
    in_mesh : use the cycle 0 instead
    tooth : the marked one with its damage, or None: all of it is red
    frame, sense : place in the scene, see `pipelines.report.figures.gear_frame`; None: the pinion's axis along y
    """
    radii = pair.working_radii
    # tooth 0 touches at the pitch point with its upper (pinion) or lower (wheel) flank, not with its middle
    pinion_zero = -pair.pinion.half_thickness_angle(radii[0])
    wheel_zero = math.pi - pair.wheel.half_thickness_angle(radii[1])
    cycle, angle = 0, 0.0
    if marked is not None:
        gear, number = marked
        teeth = pair.pinion.teeth if gear == "pinion" else pair.wheel.teeth
        cycle = 0 if in_mesh else shown_cycle(pair, marked)
        rotation = 2 * math.pi * (cycle - number) / teeth
        angle = pinion_zero + rotation if gear == "pinion" else wheel_zero - rotation
    return GearPairView(
        pinion=_shape(pair.pinion, pinion_zero),
        wheel=_shape(pair.wheel, wheel_zero),
        face_width=pair.face_width,
        centre_distance=pair.axis_distance,
        marked_gear="" if marked is None else marked[0],
        marked_angle=angle,
        missing=missing,
        tooth=tooth,
        frame=scene_frame((0.0, 0.0), (1.0, 0.0), 0.0, 1) if frame is None else frame,
        sense=sense,
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class PlacedPair:
    """A gear pair at its place in the scene, its fault, and all damage of that tooth."""

    pair: GearPair
    frame: np.ndarray  # (4, 4), see `pipelines.report.figures.gear_frame`
    sense: int
    fault: Fault | None
    damage: tuple[ToothFault, ...]


def placed_pair(machine: MachineModel, stage: int) -> PlacedPair:
    """Pair of a stage (from 1) of a machine."""
    pinion, wheel = machine.layout.pair_shafts[stage - 1]
    sense = machine.layout.pinion_senses[stage - 1]
    axes = machine.layout.axes
    faults = machine.faults_of(stage)
    fault = first_tooth_fault(faults, stage) or next(iter(faults), None)  # else one of all teeth, shown on tooth 0
    damage = [] if fault is None else [one for one in faults if one.gear == fault.gear]
    return PlacedPair(
        pair=machine.layout.pairs[stage - 1],
        frame=scene_frame(axes[pinion], axes[wheel], machine.parts.meshes[stage - 1].y, sense),
        sense=sense,
        fault=fault,
        damage=tuple(one.damage for one in damage if fault and one.tooth in (None, fault.tooth or 0)),
    )


def stage_view(placed: PlacedPair, law: MeshLaw | None, *, in_mesh: bool = False, damaged: bool = True) -> GearPairView:
    """The pair at its place.

    Parameters
    ----------
    placed : the pair
    law : of the drive flank, which gives the depth of wear; None if `needs_law` is false for the damage
    in_mesh : as for `gear_view`
    damaged : with the damaged tooth, and all its faults
    """
    pair, frame, sense, fault = placed.pair, placed.frame, placed.sense, placed.fault
    if fault is None:
        return replace(gear_view(pair, frame=frame, sense=sense, in_mesh=in_mesh), seen_from=_open_end(pair, sense))
    gear: Gear = getattr(pair, fault.gear)
    tooth = drawn_tooth(pair, law, fault.gear, twist(gear), placed.damage)
    marked = (fault.gear, fault.tooth or 0)
    view = gear_view(pair, marked, missing=tooth.missing, in_mesh=in_mesh, tooth=tooth, frame=frame, sense=sense)
    view = replace(view, seen_from=sense * tooth.end or _open_end(pair, sense))
    return view if damaged else replace(view, marked_gear="", tooth=None)


def shown_cycle(pair: GearPair, marked: tuple[str, int] | None) -> int:
    """Mesh cycle of a picture of the pair out of mesh."""
    return 0 if marked is None else marked[1] - round(VISIBLE * getattr(pair, marked[0]).teeth)


def _shape(gear: Gear, centre_angle: float) -> GearView:
    return GearView(
        outline=outline(gear, centre_angle),
        teeth=gear.teeth,
        bore=gear.bore_radius,
        twist=twist(gear),
        web=_web(gear),
    )


def outline(gear: Gear, centre_angle: float) -> np.ndarray:
    """Transverse profile of all teeth, counter-clockwise (n, 2) in m, the middle of one tooth at `centre_angle`."""
    half = half_tooth_profile(gear, n_fillet=6, n_flank=8, n_tip=2)  # mid space at x > 0 to mid tooth on +y
    tooth = np.vstack([half[:-1], half[::-1] * [-1.0, 1.0]])[:-1]  # counter-clockwise, mid space kept once
    angle = centre_angle - math.pi / 2 + 2 * math.pi * np.arange(gear.teeth) / gear.teeth
    rotations = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return (tooth @ np.moveaxis(rotations, 2, 0)).reshape(-1, 2)


def casing_surface(nodes: np.ndarray, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Surface of a casing by its corner nodes: nodes float (m, 3), m, and triangles int (t, 3).

    Parameters
    ----------
    nodes : float (n, 3), m
    facets : int (f, k), see `fem.elements.facets`
    """
    corners = corner_triangles(np.asarray(facets)).reshape(-1, 3)
    used, triangles = np.unique(corners, return_inverse=True)
    return np.asarray(nodes, dtype=float)[used], triangles.reshape(corners.shape)


def _open_end(pair: GearPair, sense: int) -> int:
    """End of the shafts, along the global y, from which an offset web is deeper; -1 without one."""
    offset = max((pair.pinion.web_offset, pair.wheel.web_offset), key=abs)
    return 1 if sense * offset < 0.0 else -1


def _web(gear: Gear) -> tuple[float, float, float] | None:
    """Inner radius of the rim and ends of the web along the face; None for a solid body."""
    if gear.web_ratio >= 1.0:
        return None
    half = gear.web_ratio * gear.face_width / 2
    return gear.rim_inner_radius, gear.web_offset - half, gear.web_offset + half


def twist(gear: Gear) -> float:
    """Rotation of the section per metre along the axis, rad/m: tan(beta) / r, positive for a right hand."""
    return gear.hand_sign * math.tan(abs(gear.helix_angle)) / gear.reference_radius
