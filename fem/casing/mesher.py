"""Housing -> CasingMesh through gmsh and OpenCASCADE: the one module that imports gmsh.

Geometry is built in millimetres (the tolerances of OpenCASCADE are absolute) and returned in metres. One thread and a
fixed seed: the same input gives the same mesh. Mid-side nodes lie on the curved surfaces unless `curved=False`.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from fem.casing.housing import Housing
from fem.casing.mesh import CasingMesh, MeshError
from fem.ledger import count

_log = logging.getLogger(__name__)
_lock = threading.Lock()  # gmsh keeps one global model
_TO_VTK = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]  # gmsh stores the mid-sides 23 and 13 the other way round
QUALITY_LIMIT = 0.05
_MM = 1000.0


def mesh_housing(housing: Housing, *, element_size: float = 0.022, curved: bool = True) -> CasingMesh:
    """Mesh a housing with ten-node tetrahedra.

    Parameters
    ----------
    housing : Housing
    element_size : m, wanted edge length; bores get at least twelve elements around
    curved : mid-side nodes on the true cylinders (else straight edges)

    Raises
    ------
    MeshError : element size out of range, an element below the quality limit (with its place), a missing surface
    """
    smallest = housing.wall_thickness / 10
    if not smallest <= element_size <= min(housing.length, housing.width, housing.height):
        raise MeshError(
            f"element size {_MM * element_size:.4g} mm is out of range; give {_MM * smallest:.4g} mm (a tenth of the "
            f"wall) to {_MM * min(housing.length, housing.width, housing.height):.4g} mm (the smallest side)"
        )
    with _session() as gmsh:
        _build(gmsh, housing)
        patches = _find_patches(gmsh, housing)
        _set_sizes(gmsh, housing, patches, element_size)
        gmsh.option.setNumber("Mesh.SecondOrderLinear", 0 if curved else 1)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        if curved:
            gmsh.model.mesh.optimize("HighOrder")  # acts on elements that curving has distorted
        mesh = _extract(gmsh, housing, patches, element_size, curved)
    count("casing_meshes")
    _log.info("casing mesh: %d nodes, %d tetrahedra", len(mesh.nodes), len(mesh.elements))
    return mesh


@contextmanager
def _session() -> Iterator[Any]:
    """A fresh gmsh, alone in this process, closed whatever happens; works outside the main thread."""
    import gmsh

    with _lock:
        gmsh.initialize(["gearcase", "-v", "0"], readConfigFiles=False, interruptible=False)
        try:
            for option, value in {
                "General.Terminal": 0,
                "General.NumThreads": 1,
                "Mesh.MaxNumThreads3D": 1,
                "Mesh.RandomSeed": 1,
                "Mesh.Algorithm": 6,
                "Mesh.Algorithm3D": 10,  # HXT: of gmsh's algorithms the one with the best worst element here
                "Mesh.Optimize": 1,
                "Mesh.ElementOrder": 1,
                "Mesh.MeshSizeFromPoints": 0,
                "Mesh.MeshSizeExtendFromBoundary": 0,
            }.items():
                gmsh.option.setNumber(option, value)
            gmsh.model.add("housing")
            yield gmsh
        except Exception as error:
            if isinstance(error, MeshError):
                raise
            raise MeshError(f"gmsh could not mesh the housing: {error}. Try another element size") from error
        finally:
            gmsh.finalize()


def _build(gmsh: Any, housing: Housing) -> None:
    """One solid: (box minus cavity) plus bosses and feet, minus bores."""
    occ, wall = gmsh.model.occ, housing.wall_thickness
    low, high = housing.box

    def block(a: np.ndarray, b: np.ndarray) -> tuple[int, int]:
        return 3, occ.addBox(*(_MM * a), *(_MM * (b - a)))

    def cylinder(x: float, z: float, start: float, end: float, diameter: float) -> tuple[int, int]:
        return 3, occ.addCylinder(_MM * x, _MM * start, _MM * z, 0, _MM * (end - start), 0, _MM * diameter / 2)

    shell, _ = occ.cut([block(low, high)], [block(low + wall, high - wall)])
    bosses = [cylinder(b.x, b.z, *housing.bore_span(b), b.boss_diameter) for b in housing.bores]
    feet = [block(*corners) for corners in housing.foot_boxes().values()]
    body, _ = occ.fuse(shell, bosses + feet)
    bores = []
    for bore in housing.bores:
        start, end = housing.bore_span(bore)
        bores.append(cylinder(bore.x, bore.z, start - wall / 2, end + wall / 2, bore.diameter))
    occ.cut(body, bores)
    occ.synchronize()
    if len(solids := gmsh.model.getEntities(3)) != 1:
        raise MeshError(f"housing falls into {len(solids)} bodies; check bosses and feet")


def _find_patches(gmsh: Any, housing: Housing) -> dict[str, list[int]]:
    """Surface tags of every bearing seat and foot underside, recognised by kind and bounding box."""
    wanted: dict[str, tuple[str, np.ndarray, np.ndarray]] = {}
    for name, (low, high) in housing.foot_boxes().items():
        wanted[name] = ("Plane", low, np.array([high[0], high[1], low[2]]))
    for bore in housing.bores:
        (start, end), radius = housing.bore_span(bore), bore.diameter / 2
        low = np.array([bore.x - radius, start, bore.z - radius])
        wanted[bore.name] = ("Cylinder", low, np.array([bore.x + radius, end, bore.z + radius]))
    found: dict[str, list[int]] = {name: [] for name in wanted}
    for _, tag in gmsh.model.getEntities(2):
        bounds = np.array(gmsh.model.getBoundingBox(2, tag)).reshape(2, 3) / _MM
        for name, (kind, low, high) in wanted.items():
            inside = (bounds[0] > low - 1e-6).all() and (bounds[1] < high + 1e-6).all()
            if inside and gmsh.model.getType(2, tag) == kind:
                found[name].append(tag)
    if missing := [name for name, tags in found.items() if not tags]:
        raise MeshError(f"housing: no surface found for {', '.join(missing)}; check that bores and feet are not hidden")
    return found


def _set_sizes(gmsh: Any, housing: Housing, patches: dict[str, list[int]], element_size: float) -> None:
    """Uniform size, finer at bores where the circle asks for it."""
    fields = []
    for bore in housing.bores:
        local = min(element_size, np.pi * bore.diameter / 12)
        distance = gmsh.model.mesh.field.add("Distance")
        gmsh.model.mesh.field.setNumbers(distance, "SurfacesList", patches[bore.name])
        gmsh.model.mesh.field.setNumber(distance, "Sampling", 20)
        field = gmsh.model.mesh.field.add("Threshold")
        for key, value in {
            "InField": distance,
            "SizeMin": _MM * local,
            "SizeMax": _MM * element_size,
            "DistMin": _MM * (bore.boss_diameter - bore.diameter) / 2,
            "DistMax": _MM * bore.boss_diameter,
        }.items():
            gmsh.model.mesh.field.setNumber(field, key, value)
        fields.append(field)
    least = gmsh.model.mesh.field.add("Min")
    gmsh.model.mesh.field.setNumbers(least, "FieldsList", fields)
    gmsh.model.mesh.field.setAsBackgroundMesh(least)


def _extract(
    gmsh: Any, housing: Housing, patches: dict[str, list[int]], element_size: float, curved: bool
) -> CasingMesh:
    kinds, tags, connectivity = gmsh.model.mesh.getElements(3)
    if list(kinds) != [11]:
        raise MeshError(f"gmsh made elements of type {list(kinds)}, expected ten-node tetrahedra (11)")
    quality = np.asarray(gmsh.model.mesh.getElementQualities(tags[0], "minSICN"))
    node_tags, coordinates, _ = gmsh.model.mesh.getNodes()
    elements = connectivity[0].reshape(-1, 10)[:, _TO_VTK]
    used = np.unique(elements)
    place = np.zeros(int(node_tags.max()) + 1, np.int64)
    place[node_tags] = np.arange(len(node_tags))
    nodes = coordinates.reshape(-1, 3)[place[used]] / _MM
    number = np.full(len(place), -1, np.int64)
    number[used] = np.arange(len(used))
    elements = number[elements]
    if quality.min() < QUALITY_LIMIT:
        bad = int((quality < QUALITY_LIMIT).sum())
        x, y, z = nodes[elements[int(quality.argmin()), :4]].mean(axis=0)
        raise MeshError(
            f"casing mesh: {bad} of {len(elements)} tetrahedra have quality below {QUALITY_LIMIT:g} (worst "
            f"{quality.min():.3g} near x=({x:.4g}, {y:.4g}, {z:.4g}) m). "
            f"Use an element size below {_MM * element_size:.4g} mm"
        )
    owner = {tag: index for index, name in enumerate(patches) for tag in patches[name]}
    facets, facet_patch = [], []
    for _, tag in gmsh.model.getEntities(2):
        for kind, _, corners in zip(*gmsh.model.mesh.getElements(2, tag), strict=True):
            if kind != 9:
                raise MeshError(f"gmsh made surface elements of type {kind}, expected six-node triangles (9)")
            facets.append(number[corners.reshape(-1, 6)])
            facet_patch.append(np.full(len(facets[-1]), owner.get(tag, -1)))
    points = housing.ground_points() | {bore.name: housing.bore_centre(bore) for bore in housing.bores}
    return CasingMesh(
        nodes=nodes,
        elements=elements,
        facets=np.vstack(facets),
        facet_patch=np.concatenate(facet_patch),
        patch_names=tuple(patches),
        patch_points=np.array([points[name] for name in patches]),
        element_size=element_size,
        quality=float(quality.min()),
        curved=int(curved),
    )
