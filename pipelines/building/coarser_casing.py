"""Stage `coarser casing`: natural frequencies on a mesh with larger elements, to extrapolate the stiffness from."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipelines.building.casing_modes import CasingModesSpec

if TYPE_CHECKING:
    from fem.casing.extrapolation import LowestFrequencies
    from fem.casing.mesh import CasingMesh


def build(spec: CasingModesSpec, mesh: CasingMesh) -> LowestFrequencies:
    """The lowest frequencies; `spec.band` does not matter."""
    from fem.casing.extrapolation import lowest_frequencies

    return lowest_frequencies(
        mesh,
        spec.material,
        static=spec.model == "static",
        interfaces=spec.interfaces,
        ground=spec.ground,
        coupling=spec.coupling,
    )
