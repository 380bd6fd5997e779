"""Step `casing mesh`: solid elements of the housing. Sensors do not enter here."""

from __future__ import annotations

from dataclasses import dataclass

from fem.casing.meshing.mesh import CasingMesh
from fem.casing.meshing.sizes import Sizes
from fem.casing.meshing.source import Geometry, mesh_geometry


@dataclass(frozen=True, kw_only=True)
class CasingMeshSpec:
    """A housing without sensors, the wanted edge lengths of the elements and their kind."""

    housing: Geometry
    sizes: Sizes
    element: str


def build(spec: CasingMeshSpec) -> CasingMesh:
    """The mesh."""
    return mesh_geometry(spec.housing, spec.sizes, spec.element)
