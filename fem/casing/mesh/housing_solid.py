"""The solid body of a parametric housing in OpenCASCADE, in millimetres (its tolerances are absolute).

    ((box - cavity) + bosses + feet, foot edges rounded) + pads + flange + ribs - bores - bolt holes

A bolted cover is cut off where it begins (`Dimensions.cover_start`).

Functions take the gmsh module of an open session (`fem.casing.mesh.gmsh_mesh`) and work on its current model.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fem.casing.geometry.housing import Housing
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.sizes import MM

_NEAR = 1e-3  # mm, for recognising edges and faces by their bounding boxes
_Solid = tuple[int, int]


def build_solid(gmsh: Any, housing: Housing) -> None:
    """Make the solid of a housing, or two solids with common faces if the cover is bolted on.

    Raises
    ------
    MeshError : the parts do not form one body, or OpenCASCADE cannot round the given edges
    """
    occ, wall, feet = gmsh.model.occ, housing.wall("side"), housing.feet
    shell, _ = occ.cut([_block(occ, *housing.box)], [_cavity(gmsh, housing)])
    bosses = [_cylinder_y(occ, b.x, b.z, *housing.bore_span(b), b.boss_diameter) for b in housing.bores]
    blocks = [_block(occ, *corners) for corners in housing.foot_boxes().values()]
    body, _ = occ.fuse(shell, bosses + blocks)
    if housing.fillets.foot:
        body = _round_feet(gmsh, housing, body)
    pads = _at_feet(occ, housing, feet.pad_diameter, 0.0, feet.pad_height + feet.height / 2)
    if added := pads + _flange(occ, housing) + _ribs(occ, housing):
        body, _ = occ.fuse(body, added)
    length = feet.pad_height + feet.height
    holes = _at_feet(occ, housing, feet.bolt_diameter, length / 2, 1.5 * length)
    for bore in housing.bores:
        start, end = housing.bore_span(bore)
        holes.append(_cylinder_y(occ, bore.x, bore.z, start - wall / 2, end + wall / 2, bore.diameter))
    body, _ = occ.cut(body, holes)
    if housing.bolted:
        _part_cover(occ, housing, body)
    occ.synchronize()
    if len(solids := gmsh.model.getEntities(3)) != (2 if housing.bolted else 1):
        raise MeshError(f"housing falls into {len(solids)} bodies; check bosses and feet")


def find_patches(gmsh: Any, housing: Housing) -> dict[str, list[int]]:
    """Surface tags of every ground face and bearing seat, recognised by kind and bounding box."""
    wanted: dict[str, tuple[str, np.ndarray, np.ndarray]] = {}
    ground, feet, radius = housing.ground_points(), housing.foot_boxes(), housing.feet.pad_diameter / 2
    for name, (low, high) in feet.items():
        around = np.array([radius, radius, 0.0])
        if radius:
            wanted[name] = ("Plane", ground[name] - around, ground[name] + around)
        else:
            wanted[name] = ("Plane", low, np.array([high[0], high[1], low[2]]))
    for bore in housing.bores:
        (start, end), radius = housing.bore_span(bore), bore.diameter / 2
        low = np.array([bore.x - radius, start, bore.z - radius])
        wanted[bore.name] = ("Cylinder", low, np.array([bore.x + radius, end, bore.z + radius]))
    found: dict[str, list[int]] = {name: [] for name in wanted}
    for _, tag in gmsh.model.getEntities(2):
        bounds = np.array(gmsh.model.getBoundingBox(2, tag)).reshape(2, 3) / MM
        for name, (kind, low, high) in wanted.items():
            inside = (bounds[0] > low - 1e-6).all() and (bounds[1] < high + 1e-6).all()
            if inside and gmsh.model.getType(2, tag) == kind:
                found[name].append(tag)
    if missing := [name for name, tags in found.items() if not tags]:
        raise MeshError(f"housing: no surface found for {', '.join(missing)}; check that bores and feet are not hidden")
    return found


def _block(occ: Any, low: np.ndarray, high: np.ndarray) -> _Solid:
    return 3, occ.addBox(*(MM * low), *(MM * (high - low)))


def _cylinder_y(occ: Any, x: float, z: float, start: float, end: float, diameter: float) -> _Solid:
    return 3, occ.addCylinder(MM * x, MM * start, MM * z, 0, MM * (end - start), 0, MM * diameter / 2)


def _at_feet(occ: Any, housing: Housing, diameter: float, below: float, above: float) -> list[_Solid]:
    """A cylinder at every foot from `below` its ground point to `above`; none of diameter 0."""
    if not diameter:
        return []
    return [
        (3, occ.addCylinder(MM * x, MM * y, MM * (z - below), 0, 0, MM * (below + above), MM * diameter / 2))
        for x, y, z in housing.ground_points().values()
    ]


def _cavity(gmsh: Any, housing: Housing) -> _Solid:
    """The cavity, its twelve edges rounded."""
    occ = gmsh.model.occ
    cavity, radius = _block(occ, *housing.cavity), housing.fillets.inner
    if not radius:
        return cavity
    occ.synchronize()
    edges = [tag for _, tag in gmsh.model.getBoundary([cavity], combined=False, oriented=False, recursive=False)]
    edges = sorted({e for face in edges for _, e in gmsh.model.getBoundary([(2, face)], oriented=False)})
    return _rounded(occ, [cavity], edges, radius, "inner")[0]


def _round_feet(gmsh: Any, housing: Housing, body: list[_Solid]) -> list[_Solid]:
    """Round the edges between feet and side wall, or between feet and floor for feet without overhang."""
    gmsh.model.occ.synchronize()
    level, outer, edges = -MM * housing.axis_height, MM * housing.width / 2, []
    for _, tag in gmsh.model.getEntities(1):
        low, high = np.array(gmsh.model.getBoundingBox(1, tag)).reshape(2, 3)
        if abs(low[2] - level) > _NEAR or abs(high[2] - level) > _NEAR:
            continue
        at_wall = abs(abs(low[1]) - outer) < _NEAR and abs(high[1] - low[1]) < _NEAR
        for start, end in housing.foot_boxes().values():
            over_foot = (low[:2] > MM * start[:2] - _NEAR).all() and (high[:2] < MM * end[:2] + _NEAR).all()
            if over_foot and at_wall == bool(housing.feet.overhang):
                edges.append(tag)
    return _rounded(gmsh.model.occ, body, edges, housing.fillets.foot, "foot")


def _rounded(occ: Any, solids: list[_Solid], edges: list[int], radius: float, name: str) -> list[_Solid]:
    try:
        made = occ.fillet([tag for _, tag in solids], edges, [MM * radius])
    except Exception as error:  # gmsh raises this class
        raise MeshError(
            f"OpenCASCADE cannot round the {len(edges)} edges of the {name} fillets with a radius of "
            f"{MM * radius:.4g} mm ({error}). Use a smaller radius, or 0 for sharp edges"
        ) from error
    if not made:
        raise MeshError(f"OpenCASCADE made no body with {name} fillets of {MM * radius:.4g} mm; use a smaller radius")
    return made


def _flange(occ: Any, housing: Housing) -> list[_Solid]:
    """The rim of the flange: a frame that starts inside the walls, interrupted in front of the bosses."""
    if (flange := housing.flange) is None:
        return []
    low, high = housing.box
    low[2], high[2] = flange.split - flange.height / 2, flange.split + flange.height / 2
    out = np.array([flange.width, flange.width, 0.0])
    sunk = np.array([housing.wall("end") / 2, housing.wall("side") / 2, -flange.height])
    tools = [_block(occ, low + sunk, high - sunk)]
    for bore in housing.bores:
        start, end = sorted((bore.side * housing.width / 2, bore.side * (housing.width / 2 + 2 * flange.width)))
        tools.append(_cylinder_y(occ, bore.x, bore.z, start, end, bore.boss_diameter))
    frame, _ = occ.cut([_block(occ, low - out, high + out)], tools)
    return list(frame)


def _part_cover(occ: Any, housing: Housing, body: list[_Solid]) -> None:
    """Cut the body where the cover begins; both pieces share their contact faces."""
    far, start = 10.0 * sum((housing.length, housing.width, housing.height)), housing.cover_start
    below = _block(occ, np.full(3, -far), np.array([far, far, start]))
    above = _block(occ, np.array([-far, -far, start]), np.full(3, far))
    cover, _ = occ.intersect(body, [above], removeObject=False)
    lower, _ = occ.intersect(body, [below])
    occ.fragment(lower, cover)


def _ribs(occ: Any, housing: Housing) -> list[_Solid]:
    """The ribs, each extended to the middle of its wall."""
    (low, high), solids = housing.box, []
    for a, b in housing.rib_boxes().values():
        start, end = a.copy(), b.copy()
        for axis, wall in enumerate((housing.wall("end"), housing.wall("side"), housing.wall("cover"))):
            if abs(end[axis] - low[axis]) < 1e-9:
                end[axis] += wall / 2
            if abs(start[axis] - high[axis]) < 1e-9:
                start[axis] -= wall / 2
        solids.append(_block(occ, start, end))
    return solids
