"""Geometry that pictures show: gear pairs and casing surfaces at their places in the machine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.contact.faults.tooth_fault import ToothFault
from fem.contact.law import MeshLaw
from fem.elements.facets import corner_triangles
from fem.gears.geometry import GearPair
from pipelines.machine.machine_model import MachineModel
from pipelines.machine.scene_flanks import Fault, first_tooth_fault
from pipelines.report.figures.damage import drawn_tooth
from pipelines.report.figures.gear_frame import scene_frame
from pipelines.report.figures.views import GearPairView

VISIBLE = 1 / 7  # of a turn before it meshes, where the other gear does not hide a damaged tooth


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
    in_mesh : at mesh cycle 0, otherwise where the other gear does not hide the damaged tooth
    damaged : with the damaged tooth, and all its faults
    """
    pair, fault = placed.pair, placed.fault
    marked = None if fault is None else (fault.gear, fault.tooth or 0)
    tooth = None if fault is None else drawn_tooth(pair, law, fault.gear, placed.damage)
    return GearPairView(
        pair=pair,
        marked=marked if damaged else None,
        cycle=0 if in_mesh else shown_cycle(pair, marked),
        tooth=tooth if damaged else None,
        frame=placed.frame,
        sense=placed.sense,
        seen_from=placed.sense * (0 if tooth is None else tooth.end) or _open_end(pair, placed.sense),
    )


def shown_cycle(pair: GearPair, marked: tuple[str, int] | None) -> int:
    """Mesh cycle of a picture of the pair out of mesh."""
    return 0 if marked is None else marked[1] - round(VISIBLE * getattr(pair, marked[0]).teeth)


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
