"""Stage `casing modes`: factorise and reduce the meshed casing, and check it up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fem.elements.materials import Material
from pipelines.border.errors import WorkError

if TYPE_CHECKING:
    from fem.casing.meshing.mesh import CasingMesh
    from fem.casing.reduced.checkup import CheckUp
    from fem.casing.reduced.grounded import Coupling, Ground
    from fem.casing.reduced.modes import CasingModes


@dataclass(frozen=True, kw_only=True)
class CasingModesSpec:
    """Material, rung, ground, and which bearings carry loads along which axes.

    `band` (Hz) is read by craig-bampton alone, else 0. Modes to a higher band serve a lower one, too.
    """

    material: Material
    model: str  # "static" | "craig-bampton"
    band: float
    ground: Ground
    coupling: Coupling
    interfaces: Mapping[str, tuple[str, ...]]


def build(spec: CasingModesSpec, mesh: CasingMesh) -> tuple[CasingModes, CheckUp]:
    """The reduced matrices with their check-up; WorkError names the items of the check-up that fail."""
    from fem.casing.reduced.models import CraigBamptonCasing, StaticCasing

    options: dict[str, Any] = {"ground": spec.ground, "coupling": spec.coupling, "interfaces": spec.interfaces}
    static = spec.model == "static"
    rung = StaticCasing(**options) if static else CraigBamptonCasing(band=spec.band, **options)
    modes, found = rung.modes(mesh, spec.material)
    if found.failures:
        raise WorkError(
            f"casing: the check-up of the reduced body fails in {', '.join(found.failures)}. Use a finer "
            f"casing.element_size_mm, or another casing model.\n{found.report(0)}"
        )
    return modes, found
