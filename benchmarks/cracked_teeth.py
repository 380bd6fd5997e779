"""Added deflection of cracked teeth by ten-node tetrahedra: `python -m benchmarks.cracked_teeth [OUTPUT.json]`.

A segment of a few teeth is meshed by gmsh around the crack front, held at the bore and at its two cuts, and solved by
scikit-fem with the crack open (doubled nodes) and closed, on one mesh. Loads and displacements are means over patches
of a flank, 0.4 m_n across, at three heights on both halves of the face: six places, and the change of compliance
between all of them, to be held against `fem.contact.wheels.crack_surface` by `benchmarks.added_by_cracks`.
"""

from __future__ import annotations

import json
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.gear_pairs import gear_pair
from fem.gears.gear import Gear
from fem.gears.profile import form_radius, half_tooth_profile
from fem.gears.sector_mesh import root_chord

YOUNG, POISSON = 206e9, 0.3


@dataclass(frozen=True, kw_only=True)
class Crack:
    """depth (m) at the end of the face z = b/2 and at the other end of the extent (m), angle to the centre line."""

    depth: float
    far_depth: float
    extent: float
    angle: float

    def depth_at(self, z: np.ndarray, face: float) -> np.ndarray:
        """Depth (m), 0 beyond the extent."""
        inwards = face / 2 - z
        covered = (inwards < self.extent) | (self.extent >= face)
        return np.where(covered, self.depth + (self.far_depth - self.depth) * inwards / self.extent, 0.0)


def case_gear(name: str) -> Gear:
    """The gear of one of `CASES`."""
    return _gear(CASES[name]["helix_deg"])


def _gear(helix_deg: float) -> Gear:
    return gear_pair((20, 55), 2, helix_deg, 12, bores_mm=(12.5, 17.5)).pinion


def _crack(helix_deg: float, depth: float, far_depth: float, extent: float) -> Crack:
    """A crack at 70 degrees; depths in root chords of the gear, extent in m."""
    chord = root_chord(_gear(helix_deg))[1]
    return Crack(depth=depth * chord, far_depth=far_depth * chord, extent=extent, angle=math.radians(70.0))


CASES: dict[str, dict[str, Any]] = {
    f"{kind}, {helix:g} deg": {"helix_deg": helix, "crack": _crack(helix, *sizes)}
    for kind, sizes in {
        "half the face": (0.4, 0.4, 6e-3),
        "corner": (0.5, 0.0, 6e-3),
        "whole face": (0.4, 0.4, 12e-3),
    }.items()
    for helix in (0.0, 12.0)
}
SIZES = (0.16, 0.11)  # of the elements at the crack front, in m_n
BESIDE = 2  # teeth on either side; with one, held cuts take 2.7 % of what is added at the root of the sound half


def places(gear: Gear) -> list[tuple[float, float, float]]:
    """Arc length on the flank and both ends along the face (m) of the six loads."""
    m, half = gear.normal_module, gear.face_width / 2
    low = max(form_radius(gear), gear.base_radius) + 0.3 * m
    radii = np.linspace(low, gear.tip_radius - 0.25 * m, 3)
    arcs = (radii**2 - gear.base_radius**2) / (2 * gear.base_radius)
    return [(float(arc), *ends) for arc in arcs for ends in ((-half, 0.0), (0.0, half))]


def added_compliance(gear: Gear, crack: Crack, size: float) -> tuple[np.ndarray, np.ndarray, int]:
    """Added and sound compliance (place, place), m/N, and the number of nodes.

    Parameters
    ----------
    gear, crack : the tooth with its slit from the middle of the loaded fillet
    size : of the elements at the crack front, in m_n
    """
    import skfem

    nodes, tetrahedra, in_tooth, side = _mesh(gear, crack, size)
    found = []
    for open_ in (True, False):
        points, cells = (nodes, tetrahedra) if not open_ else _opened(gear, crack, nodes, tetrahedra, in_tooth, side)
        straight = skfem.MeshTet(points.T, cells.T)
        found.append(_compliance(gear, straight))
    return found[0] - found[1], found[1], len(nodes)


def _slit(gear: Gear, crack: Crack) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mouth, unit vector along the slit, and the middle of the other fillet, (2,) each."""
    radius, chord = root_chord(gear)
    mouth = np.array([math.sqrt(radius**2 - chord**2 / 4), chord / 2])
    return mouth, -np.array([math.cos(crack.angle), math.sin(crack.angle)]), mouth * (1.0, -1.0)


def _outline(gear: Gear) -> list[np.ndarray]:
    """Pieces of the outline of the teeth from low to high angle, the middle tooth cut at both mid fillets."""
    points = half_tooth_profile(gear, 24, 16, 4)[:, ::-1]  # centre line along +x
    radius, _ = root_chord(gear)
    mouth = _slit(gear, Crack(depth=0, far_depth=0, extent=1, angle=1))[0]
    fillet = np.flatnonzero(np.hypot(*points.T) < radius - 1e-9)
    low = np.vstack([points[: fillet[-1] + 1], mouth])
    rest = np.vstack([mouth, points[fillet[-1] + 1 :]])
    corner = 24 - fillet[-1]
    flank_end = len(rest) - 5
    pieces = [low, rest[: corner + 1], rest[corner : flank_end + 1], rest[flank_end:]]  # root to tip, y > 0
    mirrored = [piece * (1.0, -1.0) for piece in pieces]
    tooth = [*mirrored, *(piece[::-1] for piece in pieces[::-1])]
    out = []
    for turn in range(-BESIDE, BESIDE + 1):
        a = 2 * math.pi * turn / gear.teeth
        matrix = np.array([[math.cos(a), -math.sin(a)], [math.sin(a), math.cos(a)]])
        out += [piece @ matrix.T for piece in tooth]
    return out


def _mesh(gear: Gear, crack: Crack, size: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, Any]:
    """Nodes (n, 3), tetrahedra (t, 4), which of them lie in the tooth above the slit, and None."""
    import gmsh

    m, b = gear.normal_module, gear.face_width
    mouth, along, other = _slit(gear, crack)
    tip = mouth + max(crack.depth, crack.far_depth) * along
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        occ = gmsh.model.occ
        made: dict[tuple[int, int], int] = {}

        def point(p: np.ndarray) -> int:
            key = tuple(np.round(p * 1e9).astype(int))
            if key not in made:
                made[key] = occ.addPoint(*p, -b / 2)
            return made[key]

        curves = [occ.addSpline([point(p) for p in piece]) for piece in _outline(gear)]
        per_tooth = len(curves) // (2 * BESIDE + 1)
        low, high = BESIDE * per_tooth + 1, (BESIDE + 1) * per_tooth - 1  # mid fillets of the middle tooth
        first, middle, last = curves[:low], curves[low:high], curves[high:]
        body_start, body_end = _outline(gear)[0][0], _outline(gear)[-1][-1]
        inner = [p * gear.bore_radius / np.hypot(*p) for p in (body_start, body_end)]
        angles = np.linspace(math.atan2(*inner[1][::-1]), math.atan2(*inner[0][::-1]), 12 * BESIDE)
        ring = [gear.bore_radius * np.array([math.cos(a), math.sin(a)]) for a in angles]
        bore = occ.addSpline([point(inner[1]), *(point(p) for p in ring[1:-1]), point(inner[0])])
        sides = [occ.addLine(point(body_end), point(inner[1])), occ.addLine(point(inner[0]), point(body_start))]
        slit = [occ.addLine(point(other), point(tip)), occ.addLine(point(tip), point(mouth))]
        body_loop = occ.addCurveLoop([*first, *slit, *last, sides[0], bore, sides[1]])
        tooth_loop = occ.addCurveLoop([*middle, -slit[1], -slit[0]])
        faces = [occ.addPlaneSurface([loop]) for loop in (body_loop, tooth_loop)]
        volumes = [next(tag for d, tag in occ.extrude([(2, face)], 0, 0, b) if d == 3) for face in faces]
        corners = [
            (0.0, b / 2),
            (crack.depth, b / 2),
            (crack.far_depth, b / 2 - crack.extent),
            (0.0, b / 2 - crack.extent),
        ]
        distinct = [c for i, c in enumerate(corners) if i == 0 or c != corners[i - 1]]
        marks = [occ.addPoint(*(mouth + s * along), z) for s, z in distinct]
        lines = [occ.addLine(marks[i - 1], marks[i]) for i in range(len(marks))]
        mark = occ.addPlaneSurface([occ.addCurveLoop(lines)])
        _, parts = occ.fragment([(3, v) for v in volumes], [(2, mark)])
        occ.synchronize()
        front = np.array([[*(mouth + s * along), z] for s, z in corners[1:]])
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
        gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)

        def wanted(dim: int, tag: int, x: float, y: float, z: float, _: float) -> float:
            near = _distance(np.array([x, y, z]), front)
            plane = abs((x - mouth[0]) * along[1] - (y - mouth[1]) * along[0])
            high = math.hypot(x, y) > np.hypot(*mouth) - 0.3 * m and abs(y) < 1.3 * m
            return min(m * size + 0.35 * near, (0.35 * m if high else 0.35 * m + 0.5 * plane), 1.5 * m)

        gmsh.model.mesh.setSizeCallback(wanted)
        gmsh.model.mesh.generate(3)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        number = np.zeros(int(tags.max()) + 1, dtype=int)
        number[tags] = np.arange(len(tags))
        cells, above = [], []
        for which, part in enumerate(parts[:2]):
            for d, tag in part:
                if d == 3:
                    types, _, found = gmsh.model.mesh.getElements(3, tag)
                    four = number[np.concatenate([f for t, f in zip(types, found, strict=True) if t == 4])]
                    cells.append(four.reshape(-1, 4))
                    above.append(np.full(len(cells[-1]), which == 1))
    finally:
        gmsh.finalize()
    nodes, elements = coordinates.reshape(-1, 3), np.concatenate(cells).astype(int)
    used = np.unique(elements)
    return nodes[used], np.searchsorted(used, elements), np.concatenate(above), None


def _distance(place: np.ndarray, line: np.ndarray) -> float:
    """Distance (m) of a point from the line through the points (n, 3)."""
    start, step = line[:-1], np.diff(line, axis=0)
    length = np.maximum((step**2).sum(axis=1), 1e-18)
    share = np.clip(((place - start) * step).sum(axis=1) / length, 0.0, 1.0)
    return float(np.linalg.norm(start + share[:, None] * step - place, axis=1).min())


def _opened(
    gear: Gear, crack: Crack, nodes: np.ndarray, tetrahedra: np.ndarray, in_tooth: np.ndarray, _: Any
) -> tuple[np.ndarray, np.ndarray]:
    """The mesh with the nodes of the crack doubled; the tetrahedra below it take the doubles."""
    mouth, along, _ = _slit(gear, crack)
    shared = np.intersect1d(tetrahedra[in_tooth], tetrahedra[~in_tooth])
    into = (nodes[shared, :2] - mouth) @ along
    cracked = shared[into < crack.depth_at(nodes[shared, 2], gear.face_width) - 1e-6 * gear.normal_module]
    double = np.arange(len(nodes))
    double[cracked] = len(nodes) + np.arange(len(cracked))
    cells = tetrahedra.copy()
    cells[~in_tooth] = double[cells[~in_tooth]]
    return np.vstack([nodes, nodes[cracked]]), cells


def _compliance(gear: Gear, straight: Any) -> np.ndarray:
    """Compliance (place, place) of the mesh, whose section is turned along the helix."""
    import skfem
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    from fem.numerics.linear_solver import factorize

    twist = math.tan(gear.helix_angle) / gear.reference_radius
    flat = skfem.MeshTet2.from_mesh(straight)
    x, y, z = flat.doflocs
    angle = twist * z
    turned = np.array([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle), z])
    mesh = skfem.MeshTet2(turned, flat.t)
    element = skfem.ElementVector(skfem.ElementTetP2())
    basis = skfem.CellBasis(mesh, element, intorder=4)
    matrix = linear_elasticity(*lame_parameters(YOUNG, POISSON)).assemble(basis)
    end = (2 * BESIDE + 1) * math.pi / gear.teeth

    def is_held(p: np.ndarray) -> np.ndarray:
        theta, r = np.arctan2(p[1], p[0]), np.hypot(p[0], p[1])
        return (np.abs(theta) > end - 1e-6) | (r < gear.bore_radius * (1 + 1e-3))

    held = basis.get_dofs(straight.facets_satisfying(is_held, boundaries_only=True)).all()
    free = np.setdiff1d(np.arange(matrix.shape[0]), held)
    loads = _loads(gear, straight, mesh, element, twist)
    answer = factorize(matrix[free][:, free].tocsc()).solve(loads[free])
    return loads[free].T @ answer


def _loads(gear: Gear, straight: Any, mesh: Any, element: Any, twist: float) -> np.ndarray:
    """Forces (unknowns, place) of unit transverse size, normal to the flank in space, into the tooth."""
    import skfem

    r_b, m, b = gear.base_radius, gear.normal_module, gear.face_width
    lowest = max(form_radius(gear), r_b)

    def is_flank(p: np.ndarray) -> np.ndarray:
        theta, r = np.arctan2(p[1], p[0]), np.hypot(p[0], p[1])
        expected = np.array([gear.half_thickness_angle(max(v, lowest)) for v in r])
        return (r > lowest) & (np.abs(theta - expected) * r < 0.02 * m) & (np.abs(p[2]) < b / 2 * (1 - 1e-9))

    facets = straight.facets_satisfying(is_flank, boundaries_only=True)
    flat = skfem.FacetBasis(straight, skfem.ElementVector(skfem.ElementTetP2()), facets=facets, intorder=10)
    place = np.asarray(flat.global_coordinates())
    r = np.hypot(place[0], place[1])
    arc = (r**2 - r_b**2) / (2 * r_b)
    roll = np.sqrt(np.maximum(r**2 - r_b**2, 0.0)) / r_b
    pressure = np.arctan(roll)
    out_of = np.arctan2(place[1], place[0]) + math.pi / 2 - pressure
    normal = np.array([np.cos(out_of), np.sin(out_of)])
    axial = twist * (place[0] * normal[1] - place[1] * normal[0])
    angle = twist * place[2]
    turned = np.array(
        [
            -(normal[0] * np.cos(angle) - normal[1] * np.sin(angle)),
            -(normal[0] * np.sin(angle) + normal[1] * np.cos(angle)),
            axial,
        ]
    )
    columns = []
    for centre, low, high in places(gear):
        weight = np.sqrt(np.clip(1 - ((arc - centre) / (0.2 * m)) ** 2, 0.0, None))
        weight = weight * ((place[2] > low) & (place[2] < high))
        total = (weight * flat.dx).sum()
        form = skfem.LinearForm(lambda v, w: sum(w.pull[i] * v[i] for i in range(3)))
        columns.append(form.assemble(flat, pull=turned * weight / total))
    return np.array(columns).T


def main(arguments: list[str]) -> None:
    """Solve all cases on all meshes and write them down."""
    found: dict[str, Any] = {}
    for name, case in CASES.items():
        meshes = []
        for size in SIZES:
            added, sound, nodes = added_compliance(case_gear(name), case["crack"], size)
            meshes.append(
                {
                    "size_mn": size,
                    "corner_nodes": nodes,
                    "added_m_per_N": added.tolist(),
                    "sound_m_per_N": sound.tolist(),
                }
            )
            print(f"{name}, {size} m_n: {nodes} corner nodes, added under even load {added.sum():.4g} m/N")
        found[name] = {"meshes": meshes}
    if arguments:
        Path(arguments[0]).write_text(json.dumps(found, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
