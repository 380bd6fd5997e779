"""Stage `coarser casing`: natural frequencies on a mesh with larger elements, to extrapolate the stiffness from."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipelines.steps.casing_modes import CasingModesSpec

if TYPE_CHECKING:
    from fem.casing.meshing.mesh import CasingMesh
    from fem.casing.reduced.extrapolation import LowestFrequencies


def build(spec: CasingModesSpec, mesh: CasingMesh) -> LowestFrequencies:
    """The lowest frequencies; `spec.band` does not matter."""
    from fem.casing.reduced.extrapolation import lowest_frequencies

    return lowest_frequencies(
        mesh,
        spec.material,
        static=spec.model == "static",
        interfaces=spec.interfaces,
        ground=spec.ground,
        coupling=spec.coupling,
    )
