"""A STEP file -> tetrahedra, in an open gmsh session: read, locate the key points, refine there, mesh.

And what names the content of a file that was written.
"""

from __future__ import annotations

import logging
import re
from pathlib import Path
from typing import Any

import numpy as np

from fem.casing.meshing.imported import UNITS, ImportedHousing, check_extent, find_key_points
from fem.casing.meshing.locate import ByCylinder
from fem.casing.meshing.mesh import MeshError
from fem.casing.meshing.sizes import MM, Refinement, Sizes
from fem.casing.meshing.surface import Surface

_log = logging.getLogger(__name__)
_DECLARED = {"": "m", ".MILLI.": "mm", ".CENTI.": "cm", ".MICRO.": "um"}


def declared_unit(path: Path) -> str:
    """Unit of length that a STEP file declares ("" if it declares none that is known)."""
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
    """The STEP text under this name, without what differs from one writing of a solid to the next.

    OpenCASCADE names the file by its path and the time, and the product by its own version and a count of the files
    that this process has written; the count stays when gmsh is closed.
    """
    header = f"FILE_NAME('{name}','2000-01-01T00:00:00',(''),(''),'','gearcase','');"
    text = re.sub(r"FILE_NAME\(.*?\);", lambda _: header, text, count=1, flags=re.DOTALL)
    return re.sub(r"PRODUCT\(\s*'[^']*',\s*'[^']*',", lambda _: f"PRODUCT('{name}','{name}',", text, count=1)


def read_step(gmsh: Any, housing: ImportedHousing) -> None:
    """Bring the solids of the file into the current model, in millimetres; several solids are bonded where they touch.

    Raises
    ------
    MeshError : unreadable, no solid, or a unit other than the one stated
    """
    path = housing.file
    declared = declared_unit(path)
    if declared and declared != housing.unit:
        raise MeshError(
            f'{path.name} declares its unit of length as {declared}, the scene states unit = "{housing.unit}". Set '
            f'unit = "{declared}", or export the file in {housing.unit}'
        )
    gmsh.option.setString("Geometry.OCCTargetUnit", "MM" if declared else "")
    try:
        gmsh.model.occ.importShapes(str(path), format="step")
    except Exception as error:  # gmsh raises this class itself
        raise MeshError(f"{path.name} cannot be read as STEP ({error}); export it again, as AP214 or AP242") from error
    gmsh.model.occ.synchronize()
    if not declared and housing.unit != "mm":
        factor = MM * UNITS[housing.unit]
        gmsh.model.occ.dilate(gmsh.model.getEntities(3), 0, 0, 0, factor, factor, factor)
        gmsh.model.occ.synchronize()
    solids = gmsh.model.getEntities(3)
    if not solids:
        surfaces, curves = len(gmsh.model.getEntities(2)), len(gmsh.model.getEntities(1))
        raise MeshError(
            f"{path.name} has no volume: it holds {surfaces} surfaces and {curves} curves. Sew the surfaces to a "
            "closed solid in the CAD program and export that"
        )
    if len(solids) > 1:
        gmsh.model.occ.fragment(solids[:1], solids[1:])
        gmsh.model.occ.synchronize()
        _log.info("%s: %d solids, bonded where they touch", path.name, len(solids))


def refinements(gmsh: Any, housing: ImportedHousing, sizes: Sizes) -> list[Refinement]:
    """Finer elements at the bearing seats and, if asked, at the ground faces, which are found on a first surface mesh.

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
    """A coarse mesh of the outer faces in the frame of the scene, and the face each triangle belongs to."""
    gmsh.option.setNumber("Mesh.MeshSizeMax", MM * sizes.element)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)
    gmsh.model.mesh.generate(2)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    number = np.zeros(int(tags.max()) + 1, np.int64)
    number[tags] = np.arange(len(tags))
    triangles, face = [], []
    for _, tag in gmsh.model.getEntities(2):
        for corners in gmsh.model.mesh.getElements(2, tag)[2]:
            triangles.append(number[corners.reshape(-1, 3)])
            face.append(np.full(len(triangles[-1]), tag))
    gmsh.model.mesh.clear()
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 0)
    points = housing.placed(coordinates.reshape(-1, 3), 1 / MM)
    return Surface(points, np.vstack(triangles)), np.concatenate(face)
