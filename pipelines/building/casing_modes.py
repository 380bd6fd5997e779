"""Stage `casing modes`: factorise and reduce the meshed casing, and check it up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fem.materials import Material
from pipelines.errors import WorkError

if TYPE_CHECKING:
    from fem.casing.checkup import CheckUp
    from fem.casing.mesh import CasingMesh
    from fem.casing.modes import CasingModes


@dataclass(frozen=True, kw_only=True)
class CasingModesSpec:
    """Material and rung; `band` (Hz) is read by craig-bampton alone, else 0."""

    material: Material
    model: str  # "static" | "craig-bampton"
    band: float


def build(spec: CasingModesSpec, mesh: CasingMesh) -> tuple[CasingModes, CheckUp]:
    """The reduced matrices with their check-up; WorkError names the items of the check-up that fail."""
    from fem.casing.rungs import CraigBamptonCasing, StaticCasing

    rung = StaticCasing() if spec.model == "static" else CraigBamptonCasing(band=spec.band)
    modes, found = rung.modes(mesh, spec.material)
    if found.failures:
        raise WorkError(
            f"casing: the check-up of the reduced body fails in {', '.join(found.failures)}. Use a finer "
            f"casing.element_size_mm, or another casing model.\n{found.report(0)}"
        )
    return modes, found
