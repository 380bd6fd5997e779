"""CAD files in an open gmsh session: read, select solids, locate the key points, refine there.

`named` makes the content of a written file reproducible.
"""

from __future__ import annotations

import heapq
import logging
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fem.casing.geometry.locators import ByCylinder
from fem.casing.mesh.gmsh_session import face_triangles, numbered_nodes
from fem.casing.mesh.imported_housing import (
    CAD_FORMATS,
    STL_SUFFIXES,
    UNITS,
    ImportedHousing,
    check_extent,
    find_key_points,
)
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.sizes import MM, Refinement, Sizes
from fem.casing.mesh.surface import Surface
from fem.numerics.connected_parts import connected_parts
from fem.numerics.message_places import in_mm
from fem.processes.own_process import DAMAGED, bounded

_log = logging.getLogger(__name__)
_TOUCHING = 1e-3  # mm
SMALL_EDGE = 0.1  # mm: shorter ones cause needle-shaped elements
_NO_EXTENT = 1e-5  # mm
_SEWING = (1e-4, 1e-2)  # mm, between the edges of loose faces
_ENDS = {"step": r"END-ISO-10303-21\s*;", "brep": r"^[+-]\d+ \d+\s*\Z", "iges": r"^.{72}T.*\Z"}
_DECLARED = {"": "m", ".MILLI.": "mm", ".CENTI.": "cm", ".MICRO.": "um"}


def declared_unit(path: Path) -> str:
    """Unit of length that a STEP file declares ("" if none or unknown)."""
    text = re.sub(r"\s+", "", path.read_text(encoding="latin-1")).upper()
    for entity in re.findall(r"#\d+=\(([^;]*LENGTH_UNIT\(\)[^;]*)\);", text):
        if "CONVERSION_BASED_UNIT('INCH'" in entity:
            return "inch"
        if "CONVERSION_BASED_UNIT" in entity:
            return ""
        if found := re.search(r"SI_UNIT\((\.\w+\.|\$),\.METRE\.\)", entity):
            return _DECLARED.get(found[1].replace("$", ""), "")
    return ""


def named(text: str, name: str) -> str:
    """The STEP text with this name, without the parts that differ each time a solid is written.

    OpenCASCADE writes path and time into the file name. The product name has its version and a count of the files
    written by this process, which continues when gmsh is closed.
    """
    header = f"FILE_NAME('{name}','2000-01-01T00:00:00',(''),(''),'','gearcase','');"
    text = re.sub(r"FILE_NAME\(.*?\);", lambda _: header, text, count=1, flags=re.DOTALL)
    return re.sub(r"PRODUCT\(\s*'[^']*',\s*'[^']*',", lambda _: f"PRODUCT('{name}','{name}',", text, count=1)


def read_step(gmsh: Any, housing: ImportedHousing) -> None:
    """Load the selected solids of the file into the current model, in millimetres; several are bonded where they touch.

    Raises
    ------
    MeshError : unreadable, no solid, a unit other than the one stated, several solids without `glue`, or solids that do
        not touch
    """
    path = housing.file
    if path.suffix.lower() in STL_SUFFIXES:
        fill_surface(gmsh, path, housing.unit)
        return
    solids = import_solids(gmsh, path, housing.unit)
    if housing.solids:
        if unknown := [number for number in housing.solids if number > len(solids)]:
            raise MeshError(
                f"{path.name} has {len(solids)} solids, there is no solid {unknown[0]}. Correct solids; `gearcase "
                "housing "
                "FILE` shows the numbers"
            )
        chosen = [solids[number - 1] for number in sorted(set(housing.solids))]
        gmsh.model.occ.remove([(3, tag) for tag in solids if tag not in chosen], recursive=True)
        gmsh.model.occ.synchronize()
        solids = chosen
    if len(solids) == 1:
        return
    numbers = sorted(set(housing.solids)) or range(1, len(solids) + 1)
    if doubles := same_bodies(gmsh, solids):
        one, two = (numbers[place] for place in doubles[0])
        x, y, z = gmsh.model.occ.getCenterOfMass(3, solids[doubles[0][0]])
        raise MeshError(
            f"{path.name}: solids {one} and {two} are duplicates of one body, both at ({x:.5g}, {y:.5g}, {z:.5g}) mm "
            "of the file; leave one out by solids = [...]"
        )
    if not housing.glue:
        raise MeshError(
            f"{path.name} has {len(solids)} solids that belong to the housing; set glue = true to bond them where they "
            "touch, or choose some by solids = [1]. `gearcase housing` lists their numbers and which touch"
        )
    check_touching(gmsh, path.name, solids, numbers)
    gmsh.model.occ.fragment([(3, solids[0])], [(3, tag) for tag in solids[1:]])
    gmsh.model.occ.synchronize()
    _log.info("%s: %d solids, bonded where they touch", path.name, len(solids))


def import_solids(gmsh: Any, path: Path, unit: str | None) -> list[int]:
    """Tags of the solids of a STEP, IGES or BREP file in the current model, in millimetres.

    Parameters
    ----------
    gmsh : an open session
    path : the file; loose faces, as IGES has them, are sewn to solids
    unit : unit of the scene, refused if the file declares another one; None: unit of the file, mm if it declares none

    Raises
    ------
    MeshError : unreadable, no solid, or another unit
    """
    kind = CAD_FORMATS[path.suffix.lower()]
    if not re.search(_ENDS[kind], path.read_text(encoding="latin-1")[-2000:].rstrip(), re.MULTILINE):
        raise MeshError(
            f"{path.name} is not a {kind.upper()} file, or it is cut off: its last line is missing. Export it again"
        )
    declared = declared_unit(path) if kind == "step" else ""
    if declared and unit is not None and declared != unit:
        raise MeshError(
            f'{path.name} declares its unit of length as {declared}, the scene states unit = "{unit}". Set '
            f'unit = "{declared}", or export the file in {unit}'
        )
    converts = bool(declared) or kind == "iges"  # OpenCASCADE converts the unit of these
    gmsh.option.setString("Geometry.OCCTargetUnit", "MM" if kind == "step" and declared else "")  # IGES cannot set it
    try:
        with bounded(path):
            gmsh.model.occ.importShapes(str(path), highestDimOnly=False, format=kind)
            gmsh.model.occ.synchronize()
        for tolerance in _SEWING if kind == "iges" else ():
            if gmsh.model.getEntities(3):
                break
            gmsh.model.occ.healShapes(tolerance=tolerance, sewFaces=True, makeSolids=True)
            gmsh.model.occ.synchronize()
    except Exception as error:  # gmsh raises this class itself
        words = "" if str(path) in str(error) else f" ({error})"
        raise MeshError(
            f"{path.name} cannot be read as {kind.upper()}{words}; {DAMAGED}"
            + (", as AP214 or AP242" if kind == "step" else "")
        ) from error
    if not converts and unit not in (None, "mm"):
        factor = MM * UNITS[unit]
        gmsh.model.occ.dilate(gmsh.model.getEntities(3), 0, 0, 0, factor, factor, factor)
        gmsh.model.occ.synchronize()
    solids = [tag for _, tag in gmsh.model.getEntities(3)]
    if not solids:
        surfaces, curves = len(gmsh.model.getEntities(2)), len(gmsh.model.getEntities(1))
        sewn = ", which do not close when they are sewn" if kind == "iges" and surfaces else ""
        raise MeshError(
            f"{path.name} has no volume: it holds {surfaces} surfaces and {curves} curves{sewn}. Sew the surfaces to a "
            "closed solid in the CAD program and export that"
        )
    if empty := [number for number, tag in enumerate(solids, 1) if not gmsh.model.occ.getMass(3, tag) > 0.0]:
        raise MeshError(
            f"{path.name}: solid {empty[0]} has no volume (its faces are inside out or open). Repair it in the CAD "
            "program, or leave it out by solids = [...]"
        )
    return solids


def same_bodies(gmsh: Any, solids: Sequence[int]) -> list[tuple[int, int]]:
    """Pairs of indices into `solids` (tags, in mm) with equal box, volume and centre of gravity: duplicate bodies."""
    if len(solids) < 2:
        return []
    from scipy.spatial import cKDTree  # takes longer to import than most files to read

    occ = gmsh.model.occ
    marks = np.array(
        [(*gmsh.model.getBoundingBox(3, t), *occ.getCenterOfMass(3, t), np.cbrt(occ.getMass(3, t))) for t in solids]
    )
    return sorted(cKDTree(marks).query_pairs(_TOUCHING))


def small_edges(gmsh: Any, limit: float = SMALL_EDGE) -> list[tuple[float, np.ndarray, int]]:
    """Extent and middle (3,) in mm, and tag, of the edges of the current solids below `limit` (mm), the smallest first.

    The tip of a cone and the poles of a sphere are edges without extent and are ignored.
    """
    found = []
    for _, tag in gmsh.model.getEntities(1):
        box = np.array(gmsh.model.getBoundingBox(1, tag)).reshape(2, 3)
        if _NO_EXTENT < (extent := float(np.ptp(box, axis=0).max())) < limit:
            found.append((extent, box.mean(axis=0), tag))
    return sorted(found, key=lambda one: one[0])


def touching(gmsh: Any, solids: Sequence[int]) -> tuple[np.ndarray, dict[tuple[int, int], tuple[float, np.ndarray]]]:
    """Groups of touching solids, and the gaps between the groups.

    Minimum spanning tree of the solids by their distances (Kruskal). The distance between boxes is an inexpensive lower
    bound; the exact distance is computed only where this bound is the least.

    Parameters
    ----------
    gmsh : an open session with the solids in mm
    solids : their tags

    Returns
    -------
    label : int (solid,), the same for solids that touch, also through others
    gaps : (mm, position (3,) in mm) of pairs of indices into `solids`: the narrowest gaps between the groups
    """
    boxes = np.array([gmsh.model.getBoundingBox(3, tag) for tag in solids]).reshape(-1, 2, 3)
    first, second = np.triu_indices(len(solids), 1)
    apart = np.maximum(boxes[first, 0] - boxes[second, 1], boxes[second, 0] - boxes[first, 1])
    bounds = np.linalg.norm(np.maximum(apart, 0.0), axis=1)
    waiting = [(*row, None) for row in zip(bounds.tolist(), first.tolist(), second.tolist(), strict=True)]
    heapq.heapify(waiting)
    label, joined = np.arange(len(solids)), np.arange(len(solids))
    gaps: dict[tuple[int, int], tuple[float, np.ndarray]] = {}
    while waiting and joined.any():
        gap, one, two, ends = heapq.heappop(waiting)
        if joined[one] == joined[two]:
            continue
        if ends is None:
            gap, *ends = gmsh.model.occ.getDistance(3, solids[one], 3, solids[two])
            heapq.heappush(waiting, (gap, one, two, ends))
            continue
        joined[joined == max(joined[one], joined[two])] = min(joined[one], joined[two])
        if gap < _TOUCHING:
            label = joined.copy()
        else:
            gaps[one, two] = (gap, np.array(ends).reshape(2, 3).mean(axis=0))
    return np.unique(label, return_inverse=True)[1].ravel(), gaps


def check_touching(gmsh: Any, name: str, solids: Sequence[int], numbers: Sequence[int]) -> None:
    """MeshError unless all solids are connected; gives the parts and the position of the narrowest gap.

    Parameters
    ----------
    gmsh : an open session with the solids in mm
    name : of the file
    solids, numbers : tags of the solids, and their numbers in the scene
    """
    label, gaps = touching(gmsh, solids)
    if not label.any():
        return
    parts = [
        " and ".join(str(numbers[int(i)]) for i in np.flatnonzero(label == part)) for part in range(label.max() + 1)
    ]
    (one, two), (gap, (x, y, z)) = min(gaps.items(), key=lambda item: item[1][0])
    raise MeshError(
        f"{name} falls into {len(parts)} parts that do not touch: solids {'; '.join(parts)}; solids {numbers[one]} and "
        f"{numbers[two]} have a gap of {gap:.3g} mm at ({x:.5g}, {y:.5g}, {z:.5g}) mm. Choose those of "
        "one part by solids = [...], or close the gap in the CAD program"
    )


def fill_surface(gmsh: Any, path: Path, unit: str) -> None:
    """Make the volume inside a closed surface of triangles (STL) the solid of the current model, in millimetres.

    Its faces are divided along edges of more than 40 degrees and may be remeshed.

    Parameters
    ----------
    gmsh : an open session
    path : the STL file
    unit : of the file

    Raises
    ------
    MeshError : as `closed_triangles`, or not to be filled
    """
    points, triangles = closed_triangles(path, unit)
    try:
        tag = gmsh.model.addDiscreteEntity(2)
        gmsh.model.mesh.addNodes(2, tag, range(1, len(points) + 1), (MM * points).ravel())
        gmsh.model.mesh.addElementsByType(tag, 2, [], 1 + triangles.ravel())
        angle = math.radians(40.0)
        gmsh.model.mesh.classifySurfaces(angle, True, True, math.pi)
        gmsh.model.mesh.createGeometry()
        loop = gmsh.model.geo.addSurfaceLoop([tag for _, tag in gmsh.model.getEntities(2)])
        gmsh.model.geo.addVolume([loop])
        gmsh.model.geo.synchronize()
    except Exception as error:  # gmsh raises this class itself
        raise MeshError(f"{path.name} cannot be filled ({error}); repair the surface, or give a STEP file") from error


def read_triangles(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) in the unit of the file, without duplicates, and triangles (t, 3) of an STL file.

    Raises
    ------
    MeshError : unreadable, or without triangles
    """
    from scipy.spatial import cKDTree

    from fem.casing.mesh.mesh_file import read_quietly

    mesh = read_quietly(path)
    found = [block.data for block in mesh.cells if block.type == "triangle"]
    if not found or not sum(map(len, found)):
        raise MeshError(f"{path.name} holds no triangles; export the part again")
    places = np.asarray(mesh.points, float)
    same = cKDTree(places).query_pairs(1e-6 * float(np.ptp(places, axis=0).max()), output_type="ndarray")
    number = connected_parts(len(places), same[:, 0], same[:, 1])
    first = np.unique(number, return_index=True)[1]
    triangles = number[np.vstack(found)]
    flat = (triangles == np.roll(triangles, 1, axis=1)).any(axis=1)
    once = np.unique(np.sort(triangles[~flat], axis=1), axis=0, return_index=True)[1]
    return places[first], triangles[~flat][np.sort(once)]


def closed_triangles(path: Path, unit: str) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) in m and triangles (t, 3) of an STL file in that unit, whose surface must be closed.

    Raises
    ------
    MeshError : as `read_triangles`, or open (with the position of the hole)
    """
    points, triangles = read_triangles(path)
    points = UNITS[unit] * points
    if (hole := open_place(triangles)) is not None:
        raise MeshError(
            f"{path.name} is open: {len(hole) // 2} edges belong to one triangle only, around "
            f"{in_mm(points[hole].mean(axis=0))} if it is in {unit}. Close the hole in the program that wrote it; a "
            "volume needs a closed surface"
        )
    return points, triangles


def open_place(triangles: np.ndarray) -> np.ndarray | None:
    """Points (2 n,) of the edges that belong to one triangle only; None for a closed surface."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    unique, uses = np.unique(edges, axis=0, return_counts=True)
    loose = unique[uses % 2 == 1]
    return loose.ravel() if len(loose) else None


def refinements(gmsh: Any, housing: ImportedHousing, sizes: Sizes) -> list[Refinement]:
    """Refinements at the bearing seats and, if set, at the ground faces, which are located on a coarse surface mesh.

    Raises
    ------
    MeshError : wrong unit, element size out of range, or a key point that is not found
    """
    box = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
    check_extent(housing, box, 1 / MM)
    largest = float(np.ptp(box, axis=0).min()) / MM
    if sizes.element > largest:
        raise MeshError(
            f"element size {MM * sizes.element:.4g} mm is larger than the smallest side of {Path(housing.path).name}, "
            f"{MM * largest:.4g} mm; use a smaller one"
        )
    surface, face = _first_surface(gmsh, housing, sizes)
    patches, _ = find_key_points(housing, surface)
    found = []
    for seat in housing.seats:
        spread = surface.corners[patches[seat.name]].reshape(-1, 3)
        seen = float(np.ptp(spread, axis=0)[[0, 2]].max())
        diameter = seat.locator.diameter if isinstance(seat.locator, ByCylinder) else seen
        local = sizes.at_bore(diameter)
        faces = np.unique(face[patches[seat.name]]).tolist()
        found.append(Refinement(faces, local, near=0.2 * diameter, far=0.2 * diameter + 2 * (sizes.element - local)))
    if sizes.foot is not None:
        feet = np.concatenate([chosen for name, chosen in patches.items() if name.startswith("ground_")])
        local = sizes.at_foot(0.0)
        found.append(Refinement(np.unique(face[feet]).tolist(), local, local, local + 2 * (sizes.element - local)))
    return [one for one in found if one.size < sizes.element]


def _first_surface(gmsh: Any, housing: ImportedHousing, sizes: Sizes) -> tuple[Surface, np.ndarray]:
    """A coarse mesh of the outer faces in the frame of the scene, and the face of each triangle."""
    gmsh.option.setNumber("Mesh.MeshSizeMax", MM * sizes.element)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)
    seats = [one.locator.diameter for one in housing.seats if isinstance(one.locator, ByCylinder)]
    gmsh.option.setNumber("Mesh.MeshSizeMin", MM * min(sizes.element, *seats) / 20)  # the tip of a cone has no radius
    gmsh.model.mesh.generate(2)
    points, row = numbered_nodes(gmsh)
    triangles, face = face_triangles(gmsh, [tag for _, tag in gmsh.model.getEntities(2)], row)
    if Path(housing.path).suffix.lower() in STL_SUFFIXES:
        gmsh.model.mesh.generate(1)  # starts again; clearing would delete the triangles of the geometry
    else:
        gmsh.model.mesh.clear()
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0)
    return Surface(housing.placed(points, 1 / MM), triangles), face
