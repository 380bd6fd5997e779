"""Geometry recognition of a file: CAD through gmsh (faces as in the file), meshes and STL by their edges."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import numpy as np

from fem.casing.mesh.cad_file import closed_triangles, declared_unit, import_solids, open_place, touching
from fem.casing.mesh.gmsh_session import face_triangles, numbered_nodes, session
from fem.casing.mesh.imported_housing import CAD_SUFFIXES, STL_SUFFIXES, UNITS
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.mesh_file import read_mesh_file
from fem.casing.mesh.sizes import MM
from fem.casing.recognition.bores_and_faces import bolt_patterns, faces_of
from fem.casing.recognition.faces import split
from fem.casing.recognition.housing_contents import FoundSolid, GeometryContents
from fem.elements.facets import corner_triangles, outer_facets
from fem.elements.solid_elements import SOLIDS, converted, solid_element
from fem.numerics.connected_parts import connected_parts, shared_sides
from fem.processes.own_process import DAMAGED, READER, call_in_own_process

_log = logging.getLogger(__name__)
_AROUND = 16  # elements of a full turn; with 12, short bores cannot be distinguished from cones
_COARSE, _FINE = 10, 400  # least and largest number of elements along the diagonal of the box


def geometry_contents(path: Path, unit: str | None = None) -> GeometryContents:
    """Solids, bores, flat faces and bolt patterns of a CAD or mesh file.

    Parameters
    ----------
    path : the file
    unit : of length; None: the declared one, mm if the file declares none

    Raises
    ------
    MeshError : unreadable, of no known kind, without a volume, or open
    """
    suffix = path.suffix.lower()
    if suffix in STL_SUFFIXES:
        return _of_triangles(path, unit or "mm")
    if suffix in CAD_SUFFIXES:
        return call_in_own_process(READER.format(path.name), MeshError, DAMAGED, _of_solids, path, unit)
    return _of_mesh(path, unit or "mm")


def _of_solids(path: Path, unit: str | None) -> GeometryContents:
    declared = declared_unit(path) if path.suffix.lower() in (".step", ".stp") else ""
    with session() as gmsh:
        tags = import_solids(gmsh, path, unit)
        label, gaps = touching(gmsh, tags)
        volumes = [gmsh.model.occ.getMass(3, tag) / MM**3 for tag in tags]
        points, triangles, face, solid = _surface(gmsh, tags)
    solids = []
    for n in range(1, len(tags) + 1):
        own = triangles[solid == n]
        loose = open_place(own)
        solids.append(
            FoundSolid(
                number=n,
                volume=volumes[n - 1],
                box=_box(points[own]),
                part=1 + int(label[n - 1]),
                open_at=None if loose is None else points[loose].mean(axis=0),
            )
        )
    apart = tuple((one + 1, two + 1, gap / MM, place / MM) for (one, two), (gap, place) in gaps.items())
    return _contents(
        path,
        unit=unit or declared or "mm",
        declared=declared,
        points=points,
        triangles=triangles,
        face=face,
        solid=solid,
        solids=tuple(solids),
        gaps=apart,
    )


def _surface(gmsh: Any, tags: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Points (n, 3) m, outward triangles (t, 3), face and solid (t,) of a coarse mesh of the faces of all solids."""
    box = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
    diagonal = float(np.linalg.norm(box[1] - box[0]))
    gmsh.option.setNumber("Mesh.MeshSizeMax", diagonal / _COARSE)
    gmsh.option.setNumber("Mesh.MeshSizeMin", diagonal / _FINE)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", _AROUND)
    gmsh.option.setNumber("Mesh.Algorithm", 5)  # Delaunay: faster than frontal, sufficient for recognition
    try:
        gmsh.model.mesh.generate(2)
    except Exception as error:  # gmsh raises this class itself
        _log.info("some faces cannot be meshed: %s", error)
    points, place = numbered_nodes(gmsh)
    points = points / MM
    triangles, face, solid = [], [], []
    for number, tag in enumerate(tags, 1):
        faces = [surface for _, surface in gmsh.model.getBoundary([(3, tag)], oriented=False)]
        own, of_face = face_triangles(gmsh, faces, place)
        if not len(own):
            raise MeshError(f"solid {number} has no face that can be shown; correct it in the CAD program")
        triangles.append(outward(points, own))
        face.append(of_face)
        solid.append(np.full(len(triangles[-1]), number))
    return points, np.vstack(triangles), np.concatenate(face), np.concatenate(solid)


def outward(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The triangles (t, 3) of the surface of one body, oriented counter-clockwise as seen from outside."""
    sides, others = shared_sides(triangles)
    one, two = sides // 3, others // 3
    forward = (triangles < np.roll(triangles, -1, axis=1)).ravel()
    against = forward[sides] == forward[others]
    # every triangle is present in both orientations; the search from the first one of a part reaches one of them
    count = len(triangles)
    rows = np.concatenate([one, one + count])
    columns = np.concatenate([two + count * against, two + count * ~against])
    either = connected_parts(2 * count, rows, columns).reshape(2, count)
    label = np.unique(either.min(axis=0), return_inverse=True)[1].ravel()
    first = np.unique(label, return_index=True)[1]
    turned = either[0] != either[0, first][label]
    triangles = np.where(turned[:, None], triangles[:, [0, 2, 1]], triangles)
    volume = np.bincount(label, weights=np.linalg.det(points[triangles] - points[triangles].mean(axis=(0, 1))))
    hollow = np.arange(len(volume)) != np.abs(volume).argmax()  # cavities inside the outermost part
    return np.where(((volume < 0.0) ^ hollow)[label][:, None], triangles[:, [0, 2, 1]], triangles)


def _of_triangles(path: Path, unit: str) -> GeometryContents:
    points, triangles = closed_triangles(path, unit)
    solid = 1 + _connected(triangles, len(points))
    triangles = np.vstack([outward(points, triangles[solid == n]) for n in range(1, solid.max() + 1)])
    return _by_edges(path, unit, points, triangles, np.sort(solid))


def _of_mesh(path: Path, unit: str) -> GeometryContents:
    raw = read_mesh_file(path, MM * UNITS[unit])
    linear = SOLIDS["tetrahedron-4" if solid_element(raw.elements).corners == 4 else "hexahedron-8"]
    nodes, elements = converted(UNITS[unit] * raw.nodes, raw.elements, linear)
    facets = outer_facets(nodes, elements)
    triangles = corner_triangles(facets)
    part = _connected(elements, len(nodes))
    of_node = np.zeros(len(nodes), np.int64)
    of_node[elements] = part[:, None]
    flat = triangles.reshape(-1, 3)
    return _by_edges(path, unit, nodes, flat, 1 + of_node[flat[:, 0]])


def _connected(cells: np.ndarray, count: int) -> np.ndarray:
    """Number (c,) from 0 of the part of each cell; parts share no point."""
    rows = np.repeat(cells[:, 0], cells.shape[1] - 1)
    return np.unique(connected_parts(count, rows, cells[:, 1:].ravel())[cells[:, 0]], return_inverse=True)[1].ravel()


def _by_edges(path: Path, unit: str, points: np.ndarray, triangles: np.ndarray, solid: np.ndarray) -> GeometryContents:
    face = split(points, triangles)
    solids = tuple(
        FoundSolid(
            number=n,
            volume=float(np.linalg.det(points[triangles[solid == n]]).sum() / 6.0),
            box=_box(points[triangles[solid == n]]),
            part=n,
        )
        for n in range(1, int(solid.max()) + 1)
    )
    return _contents(path, unit=unit, points=points, triangles=triangles, face=face, solid=solid, solids=solids)


def _contents(
    path: Path,
    *,
    unit: str,
    declared: str = "",
    points: np.ndarray,
    triangles: np.ndarray,
    face: np.ndarray,
    solid: np.ndarray,
    solids: tuple[FoundSolid, ...],
    gaps: tuple[tuple[int, int, float, np.ndarray], ...] = (),
) -> GeometryContents:
    bores, flats = faces_of(points, triangles, face, solid)
    return GeometryContents(
        name=path.name,
        unit=unit,
        declared=declared,
        points=points,
        triangles=triangles,
        solid=solid,
        solids=solids,
        gaps=gaps,
        bores=bores,
        flats=flats,
        patterns=bolt_patterns(bores),
    )


def _box(corners: np.ndarray) -> np.ndarray:
    return np.array([corners.reshape(-1, 3).min(axis=0), corners.reshape(-1, 3).max(axis=0)])
