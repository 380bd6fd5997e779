"""Steps `coarser casing`, `coarsest casing`, `quadratic casing`: natural modes to extrapolate a casing from.

They are those on meshes with larger elements, or of quadratic displacements on the mesh of cubic ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from fem.casing.parts.bolted_joint import BoltedJoint
from fem.elements.materials import Material

if TYPE_CHECKING:
    from fem.casing.mesh_error.extrapolation import LowestModes
    from fem.casing.meshing.mesh import CasingMesh
    from fem.casing.reduced.grounded import Attachment, Ground


@dataclass(frozen=True, kw_only=True)
class CoarserSpec:
    """The casing as its model grounds it; `static`: its inertia is condensed, too; `quadratic`: without cubic parts."""

    material: Material
    static: bool
    interfaces: Mapping[str, tuple[str, ...]]
    ground: Ground
    attachment: Attachment
    joint: BoltedJoint | None
    quadratic: bool


def build(spec: CoarserSpec, *, mesh: CasingMesh) -> LowestModes:
    """The lowest modes."""
    from fem.casing.mesh_error.extrapolation import lowest_modes

    return lowest_modes(
        replace(mesh, cubic=0) if spec.quadratic else mesh,
        spec.material,
        static=spec.static,
        interfaces=spec.interfaces,
        ground=spec.ground,
        attachment=spec.attachment,
        joint=spec.joint,
    )
