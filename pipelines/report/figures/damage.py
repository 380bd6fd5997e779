"""Pictures of tooth faults: one function per kind of fault.

A fault of another kind is shown by the gap that it opens on the flank, as wear is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fem.contact.faults.broken_patches import FlankDamage, Patch, arc_at
from fem.contact.faults.chipped_tooth import ChippedTooth
from fem.contact.faults.cracked_tooth import CrackedTooth
from fem.contact.faults.missing_tooth import MissingTooth
from fem.contact.faults.pitted_tooth import PittedTooth
from fem.contact.faults.spalled_tooth import SpalledTooth
from fem.contact.faults.tooth_fault import ToothFault
from fem.contact.law import MeshLaw
from fem.gears.geometry import GearPair
from fem.gears.sector_mesh import root_chord
from pipelines.report.figures.damaged_tooth import DrawnTooth, ToothSection, cut_down, stations, surface_of
from pipelines.report.figures.tooth_surfaces import swept, twist

DRAWN_DEPTH = 0.12  # modules: depth of wear in the picture
_ROUND = (1.0, 2.0, 5.0)


def needs_law(faults: Sequence[ToothFault]) -> bool:
    """True if a fault is shown by the gap that it opens on the flank, which needs a mesh law."""
    return any(type(fault) not in DRAWN for fault in faults)


def drawn_tooth(pair: GearPair, law: MeshLaw | None, gear: str, faults: Sequence[ToothFault]) -> DrawnTooth:
    """Damaged tooth of "pinion" or "wheel" with all of `faults`.

    Parameters
    ----------
    pair, law : the gears in mesh, and the law of their drive flank, None if `needs_law` is false
    gear : "pinion" or "wheel"
    faults : of the tooth
    """
    fine = any(isinstance(fault, FlankDamage) for fault in faults)
    section = ToothSection(gear=getattr(pair, gear), flank_points=96 if fine else 24)
    edges = [edge for fault in faults for edge in _edges(fault, pair.face_width)]
    face = stations(pair.face_width, edges, 161 if fine else 25)
    height = np.full(face.size, np.inf)
    for fault in faults:
        if isinstance(fault, ChippedTooth):
            height = np.minimum(height, section.gear.tip_radius - fault.depth_at(face, pair.face_width))
    flat, broken = cut_down(section, np.where(height < section.gear.tip_radius, height, np.inf))
    depth = np.zeros(flat.shape[:2])
    for fault in faults:
        if isinstance(fault, FlankDamage):
            depth = np.maximum(depth, patch_depth(section, face, fault.patches(section.gear), fault.flank))
        elif type(fault) not in DRAWN:
            assert law is not None, "required by `needs_law`"
            depth = np.maximum(depth, worn_depth(section, face, pair, law, gear, fault))
    scale = _scale(float(depth.max()), section.gear.normal_module)
    points, quads, torn = surface_of(section, face, flat - scale * depth[..., None] * _normals(section), broken)
    tooth = DrawnTooth(
        points=points,
        quads=quads,
        broken=torn,
        depth=np.concatenate([depth.ravel(), [0.0, 0.0]]),
        scale=scale,
    )
    words: list[str] = []
    for fault in faults:
        changes = DRAWN.get(type(fault), _wear)(tooth, section, pair, fault)
        words.append(changes.pop("words"))
        tooth = replace(tooth, **changes)
    return replace(tooth, words="; ".join(dict.fromkeys(words)))


def _wear(tooth: DrawnTooth, section: ToothSection, pair: GearPair, fault: ToothFault) -> dict[str, Any]:
    return {"words": f"up to {1e6 * tooth.depth.max():.3g} µm removed from the flank{_scaled(tooth)}"}


def _spall(tooth: DrawnTooth, section: ToothSection, pair: GearPair, fault: SpalledTooth) -> dict[str, Any]:
    size = f"{1000 * fault.height:.3g} x {1000 * fault.length:.3g} mm, {1e6 * fault.depth:.3g} µm deep"
    return {"words": f"spall on the {fault.flank} flank: {size}{_scaled(tooth)}", "flank": _flank(fault)}


def _pits(tooth: DrawnTooth, section: ToothSection, pair: GearPair, fault: PittedTooth) -> dict[str, Any]:
    count = len(fault.patches(section.gear))
    return {"words": f"{count} pits on the {fault.flank} flank{_scaled(tooth)}", "flank": _flank(fault)}


def _chip(tooth: DrawnTooth, section: ToothSection, pair: GearPair, fault: ChippedTooth) -> dict[str, Any]:
    piece = "corner" if fault.corner else "piece"
    words = f"{piece} broken off: {1000 * fault.depth:.3g} mm deep, {1000 * fault.extent:.3g} mm long"
    return {"words": words, "end": _side(fault.end)}


def _crack(tooth: DrawnTooth, section: ToothSection, pair: GearPair, fault: CrackedTooth) -> dict[str, Any]:
    """Crack surface inside the tooth, and its edges in the fillet and on the end face."""
    inside, depth = crack_depth(fault, pair.face_width)
    radius, chord = root_chord(section.gear)
    side = _flank(fault)
    mouth = np.array([math.sqrt(radius**2 - chord**2 / 4), side * chord / 2])
    inwards = np.array([-math.cos(fault.angle), -side * math.sin(fault.angle)])
    flat = mouth + np.linspace(0.0, 1.0, 9)[None, :, None] * depth[:, None, None] * inwards
    sheet = swept(flat, twist(section.gear), inside[:, None])
    ends = [sheet[row] for row in (0, -1) if abs(abs(inside[row]) - pair.face_width / 2) < 1e-9]
    falling = "" if fault.far_depth is None else f" to {1000 * fault.far_depth:.3g}"
    size = f"{1000 * fault.depth:.3g}{falling} mm deep from the fillet, {1000 * np.ptp(inside):.3g} mm long"
    return {
        "words": f"crack {size}",
        "sheets": (*tooth.sheets, sheet),
        "lines": (*tooth.lines, sheet[:, 0], *ends),
        "end": 0 if fault.extent is None else _side(fault.end),
        "flank": side,
    }


def _gap(tooth: DrawnTooth, section: ToothSection, pair: GearPair, fault: MissingTooth) -> dict[str, Any]:
    return {"words": "tooth broken off at the root", "missing": True}


DRAWN: dict[type[ToothFault], Callable[..., dict[str, Any]]] = {  # what a fault changes in the picture of its tooth
    ChippedTooth: _chip,
    CrackedTooth: _crack,
    MissingTooth: _gap,
    SpalledTooth: _spall,
    PittedTooth: _pits,
}


def _scaled(tooth: DrawnTooth) -> str:
    """Note on an enlarged depth of the damage."""
    return "" if tooth.scale == 1.0 else f", depth enlarged {tooth.scale:g} times"


def crack_depth(fault: CrackedTooth, face_width: float) -> tuple[np.ndarray, np.ndarray]:
    """Face coordinates over the crack, and its depths there (m)."""
    extent = face_width if fault.extent is None else fault.extent
    inside = face_width / 2 - np.linspace(0.0, extent, 15)
    inside = inside[::-1] if fault.end == "+y" else -inside
    return inside, fault.depth_at(inside, face_width)


def patch_depth(section: ToothSection, face: np.ndarray, patches: Sequence[Patch], flank: str) -> np.ndarray:
    """Depth (station, point), m, of patches on a flank.

    Parameters
    ----------
    section, face : the tooth and its stations (s,)
    patches : on the flank, in the face coordinate of the stations
    flank : "drive" or "coast"
    """
    depth = np.zeros((face.size, section.radius.size))
    arc, peak = arc_at(section.gear, section.radius), int(np.argmax(section.radius))
    for patch in patches:
        along = np.abs(face - patch.face) <= patch.length / 2
        middle = arc_at(section.gear, patch.radius)
        inside = along[:, None] & (np.abs(arc - middle) <= patch.half_height(face)[:, None])
        depth = np.where(inside, np.maximum(depth, patch.depth), depth)
    depth[:, slice(None, peak + 1) if flank == "drive" else slice(peak, None)] = 0.0
    depth[:, section.radius <= section.gear.base_radius] = 0.0
    return depth


def worn_depth(
    section: ToothSection, face: np.ndarray, pair: GearPair, law: MeshLaw, gear: str, fault: ToothFault
) -> np.ndarray:
    """Depth (station, point), m, by which a fault lowers the flanks: the gap that it opens to the mate.

    Both flanks get the same depth.

    Parameters
    ----------
    section, face : the tooth and its stations (s,)
    pair, law, gear : the gears in mesh, the law of their drive flank, and the gear of the tooth
    fault : of the tooth
    """
    gap = np.atleast_2d(fault.gap(law, pair, gear))
    gap = np.broadcast_to(np.where(np.isfinite(gap), gap, 0.0), (law.face_coordinate.size, law.compliance.size))
    roll = np.sqrt(np.maximum(section.radius**2 - section.gear.base_radius**2, 0.0))
    own, mate = pair.roll_lengths(0.0)
    xi = (roll - own) / pair.base_pitch if gear == "pinion" else (mate - roll) / pair.base_pitch
    grid = law.position_start + law.position_step * np.arange(law.compliance.size)
    by_slice = np.array([np.interp(xi, grid, row) for row in gap])
    places = np.interp(face, law.face_coordinate, np.arange(law.face_coordinate.size))
    low = np.minimum(places.astype(int), law.face_coordinate.size - 1)
    high = np.minimum(low + 1, law.face_coordinate.size - 1)
    part = (places - low)[:, None]
    depth: np.ndarray = (1 - part) * by_slice[low] + part * by_slice[high]
    depth[:, section.radius <= max(section.gear.base_radius, section.gear.root_radius) * (1 + 1e-6)] = 0.0
    return depth


def _normals(section: ToothSection) -> np.ndarray:
    """Unit normals (point, 2) of the section, outwards."""
    along = np.gradient(section.points, axis=0)
    return np.asarray(np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None])


def _scale(depth: float, module: float) -> float:
    """Round factor, at least 1, by which wear is enlarged to a depth of about DRAWN_DEPTH."""
    if depth <= 0.0 or depth >= DRAWN_DEPTH * module:
        return 1.0
    wanted = DRAWN_DEPTH * module / depth
    power = 10.0 ** math.floor(math.log10(wanted))
    return max(step * power for step in _ROUND if step * power <= wanted)


def _edges(fault: ToothFault, face_width: float) -> list[float]:
    extent, end = getattr(fault, "extent", None), getattr(fault, "end", "")
    return [] if extent is None else [_side(end) * (face_width / 2 - extent)]


def _flank(fault: CrackedTooth | PittedTooth | SpalledTooth) -> int:
    return 1 if fault.flank == "drive" else -1


def _side(end: str) -> int:
    return 1 if end == "+y" else -1
