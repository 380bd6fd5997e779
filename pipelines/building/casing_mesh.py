"""Stage `casing mesh`: tetrahedra of the housing. Sensors do not enter here."""

from __future__ import annotations

from dataclasses import dataclass

from fem.casing.housing import Housing
from fem.casing.mesh import CasingMesh


@dataclass(frozen=True, kw_only=True)
class CasingMeshSpec:
    """A housing without sensors, and the wanted edge length of the elements (m)."""

    housing: Housing
    element_size: float


def build(spec: CasingMeshSpec) -> CasingMesh:
    """The mesh."""
    from fem.casing.mesher import mesh_housing

    return mesh_housing(spec.housing, element_size=spec.element_size)
