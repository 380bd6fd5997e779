"""Linear FE of a whole gear, all teeth, by ten-node tetrahedra of scikit-fem: the reference for gear bodies.

gmsh meshes the transverse section with triangles, fine at the tooth that is loaded. The triangles are drawn along the
helix, layer by layer, and every prism is split into three tetrahedra. Nothing is shared with the model `solid` but the
tooth's outline. Frame: axis z, mid face at z = 0, loaded tooth on +x, its loaded flank at positive angles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from skfem import Basis, ElementTetP2, ElementVector, FacetBasis, LinearForm, MeshTet, condense
from skfem.models.elasticity import lame_parameters, linear_elasticity

from fem.gears.gear import Gear
from fem.gears.profile import half_tooth_profile
from fem.numerics.linear_solver import factorize


@dataclass(frozen=True, kw_only=True)
class Ring:
    """A ring of the section under the teeth: radii and ends along the axis, m."""

    inner: float
    outer: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class Patch:
    """A unit force on the flank: an ellipse of pressure across it, even along the axis. Lengths m."""

    arc: float  # middle, arc length of the involute from its base circle
    half_width: float
    low: float
    high: float
    tooth: int = 0


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """Element sizes in m: at the loaded flank, on the other teeth, and in the body."""

    flank: float
    teeth: float
    body: float


def compliance(
    gear: Gear,
    rings: list[Ring],
    held: str,
    patches: list[Patch],
    layers: np.ndarray,
    sizes: Sizes,
    young: float,
    poisson: float,
) -> tuple[np.ndarray, int]:
    """Displacement along each patch by the force on each other, per unit transverse force, m/N; and the unknowns.

    Parameters
    ----------
    gear : toothed over its face width
    rings : of the body from the root inwards; the first carries the teeth
    held : "bore", the innermost circle, or "end", the face of the last ring at the lowest z
    patches : on the flank of the loaded tooth
    layers : ends of the layers, m; those of rings, face and patches among them
    sizes : of the elements
    young, poisson : Pa, 1
    """
    points, triangles, where = _section(gear, rings, sizes)
    twist = math.tan(gear.helix_angle) / gear.reference_radius
    mesh = _drawn(points, triangles, where, rings, layers, twist)
    element = ElementVector(ElementTetP2())
    basis = Basis(mesh, element, intorder=2)
    stiffness = linear_elasticity(*lame_parameters(young, poisson)).assemble(basis)
    radius, z = np.hypot(mesh.p[0], mesh.p[1]), mesh.p[2]
    if held == "bore":
        on = np.flatnonzero(radius < 1.01 * rings[-1].inner)
    else:
        on = np.flatnonzero(z < rings[-1].low + 1e-9)
    facets = mesh.facets_satisfying(lambda x: np.isin(x[0], x[0]), boundaries_only=True)
    fixed = basis.get_dofs(facets[np.isin(mesh.facets[:, facets], on).all(axis=0)]).flatten()
    loads = np.column_stack([_load(mesh, element, facets, gear, patch, twist) for patch in patches])
    matrix, _, _, inside = condense(stiffness, loads[:, 0], D=fixed)
    seen = factorize(matrix.tocsc(), block=3).solve(loads[inside])
    return loads[inside].T @ seen, len(inside)


def _outline(gear: Gear, sizes: Sizes) -> tuple[np.ndarray, np.ndarray]:
    """Closed outline (n, 2) of all teeth, tooth 0 on +x, and the element size at every point."""
    half = half_tooth_profile(gear, 400, 400, 60)[:, ::-1]  # (x, y), tooth centre line on +x, from mid space
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(half, axis=0).T))])
    out, size = [], []
    for tooth in range(gear.teeth):
        for side in (-1, 1):
            wanted = sizes.teeth
            if tooth == 0:
                wanted = sizes.flank if side > 0 else 2 * sizes.flank
            elif (tooth, side) in ((1, -1), (gear.teeth - 1, 1)):
                wanted = 0.5 * (sizes.flank + sizes.teeth)
            place = np.linspace(0.0, arc[-1], math.ceil(arc[-1] / wanted) + 1)[:-1]
            if side > 0:
                place = arc[-1] - place
            x, y = np.interp(place, arc, half[:, 0]), side * np.interp(place, arc, half[:, 1])
            turn = 2 * math.pi * tooth / gear.teeth
            out.append(
                np.column_stack([x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn)])
            )
            size.append(np.full(len(place), wanted))
    return np.vstack(out), np.concatenate(size)


def _section(gear: Gear, rings: list[Ring], sizes: Sizes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (n, 2), triangles (m, 3) and the number of the ring of every triangle (teeth: 0)."""
    import gmsh

    outline, size = _outline(gear, sizes)
    gmsh.initialize(["gear", "-v", "0"], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("Mesh.Algorithm", 6)
        gmsh.option.setNumber("Mesh.RandomSeed", 1)
        geo = gmsh.model.geo

        def loop(places: np.ndarray, lengths: np.ndarray) -> int:
            corners = [geo.addPoint(1000 * x, 1000 * y, 0, 1000 * h) for (x, y), h in zip(places, lengths, strict=True)]
            lines = [geo.addLine(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]
            return geo.addCurveLoop(lines)

        outside = loop(outline, size)
        for number, ring in enumerate(rings):  # polygons of the circle's area
            angle = np.arange(max(12, math.ceil(2 * math.pi * ring.inner / sizes.body))) + 0.0
            angle *= 2 * math.pi / len(angle)
            near = 1.0 - 0.5 * np.exp(-((np.angle(np.exp(1j * angle)) * gear.teeth / (3 * math.pi)) ** 2))
            step = 2 * math.pi / len(angle)
            circle = ring.inner * math.sqrt(step / math.sin(step)) * np.column_stack([np.cos(angle), np.sin(angle)])
            inside = loop(circle, sizes.body * (near if number == 0 else np.ones(len(angle))))
            geo.addPlaneSurface([outside, inside], number + 1)
            outside = inside
        geo.synchronize()
        gmsh.model.mesh.generate(2)
        tags, flat, _ = gmsh.model.mesh.getNodes()
        triangles, where = [], []
        for number in range(len(rings)):
            _, _, nodes = gmsh.model.mesh.getElements(2, number + 1)
            triangles.append(np.searchsorted(np.sort(tags), nodes[0]).reshape(-1, 3))
            where.append(np.full(len(triangles[-1]), number))
        points = flat.reshape(-1, 3)[np.argsort(tags), :2] / 1000
    finally:
        gmsh.finalize()
    return points, np.vstack(triangles), np.concatenate(where)


def _drawn(
    points: np.ndarray, triangles: np.ndarray, where: np.ndarray, rings: list[Ring], layers: np.ndarray, twist: float
) -> MeshTet:
    """Tetrahedra of the section drawn along the helix; a face between prisms runs from its lower node upwards."""
    a, b, c = np.sort(triangles, axis=1).T
    tetrahedra = []
    for k, middle in enumerate((layers[1:] + layers[:-1]) / 2):
        there = np.array([ring.low < middle < ring.high for ring in rings])[where]
        low, high = k * len(points), (k + 1) * len(points)
        for split in ((a + low, b + low, c + low, c + high), (a + low, b + low, b + high, c + high)):
            tetrahedra.append(np.stack(split)[:, there])
        tetrahedra.append(np.stack((a + low, a + high, b + high, c + high))[:, there])
    cells = np.hstack(tetrahedra)
    angle = twist * layers[:, None]
    x = points[:, 0] * np.cos(angle) - points[:, 1] * np.sin(angle)
    y = points[:, 0] * np.sin(angle) + points[:, 1] * np.cos(angle)
    nodes = np.stack([x.ravel(), y.ravel(), np.repeat(layers, len(points))])
    used, cells = np.unique(cells, return_inverse=True)
    return MeshTet(nodes[:, used], cells.reshape(4, -1))


def _load(
    mesh: MeshTet, element: ElementVector, boundary: np.ndarray, gear: Gear, patch: Patch, twist: float
) -> np.ndarray:
    """Nodal forces of a patch: transverse sum 1 normal to the flank, the axial part that of the helix."""
    base, pitch = gear.base_radius, math.pi / gear.teeth

    def arc_and_angle(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        angle = np.angle((x[0] + 1j * x[1]) * np.exp(-1j * (twist * x[2] + 2 * pitch * patch.tooth)))
        return (x[0] ** 2 + x[1] ** 2 - base**2).clip(0.0) / (2 * base), angle

    corners = mesh.p[:, mesh.facets[:, boundary]]
    arc, angle = arc_and_angle(corners)
    z = corners[2]
    here = (z > patch.low - 1e-9).all(axis=0) & (z < patch.high + 1e-9).all(axis=0) & (np.ptp(z, axis=0) > 1e-9)
    here &= (np.abs(angle) < pitch).all(axis=0) & (angle.mean(axis=0) > 0)
    here &= (arc.max(axis=0) > patch.arc - patch.half_width) & (arc.min(axis=0) < patch.arc + patch.half_width)
    flank = FacetBasis(mesh, element, facets=boundary[here], intorder=10)

    def pressure(x: np.ndarray) -> np.ndarray:
        distance = (arc_and_angle(x)[0] - patch.arc) / patch.half_width
        return np.sqrt((1.0 - distance**2).clip(0.0))

    def force(v: np.ndarray, w: dict) -> np.ndarray:
        x = w["x"]
        radius = np.hypot(x[0], x[1])
        sine = np.sqrt((1.0 - (base / radius) ** 2).clip(0.0))
        along, around = sine, base / radius
        e_r, e_t = (x[0] / radius, x[1] / radius), (-x[1] / radius, x[0] / radius)
        inwards = [-(along * e_r[i] + around * e_t[i]) for i in range(2)]
        return pressure(x) * (inwards[0] * v[0] + inwards[1] * v[1] + twist * base * v[2])

    total = float(np.sum(pressure(flank.global_coordinates().value) * flank.dx))
    return LinearForm(force).assemble(flank) / total
