"""Step `coarser casing`: natural frequencies on a mesh with larger elements, to extrapolate the stiffness from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fem.elements.materials import Material

if TYPE_CHECKING:
    from fem.casing.meshing.mesh import CasingMesh
    from fem.casing.reduced.extrapolation import LowestFrequencies
    from fem.casing.reduced.grounded import Attachment, Ground


@dataclass(frozen=True, kw_only=True)
class CoarserSpec:
    """The casing as its model grounds it; `static`: its inertia is condensed, too."""

    material: Material
    static: bool
    interfaces: Mapping[str, tuple[str, ...]]
    ground: Ground
    attachment: Attachment


def build(spec: CoarserSpec, mesh: CasingMesh) -> LowestFrequencies:
    """The lowest frequencies."""
    from fem.casing.reduced.extrapolation import lowest_frequencies

    return lowest_frequencies(
        mesh,
        spec.material,
        static=spec.static,
        interfaces=spec.interfaces,
        ground=spec.ground,
        attachment=spec.attachment,
    )
