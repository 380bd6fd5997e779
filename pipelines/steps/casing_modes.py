"""Step `casing modes`: factorise and reduce the meshed casing, and check it up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fem.elements.materials import Material
from pipelines.border.errors import WorkError

if TYPE_CHECKING:
    from fem.casing.meshing.mesh import CasingMesh
    from fem.casing.models.elastic_casing import ElasticCasing
    from fem.casing.reduced.checkup import CheckUp
    from fem.casing.reduced.modes import CasingModes


@dataclass(frozen=True, kw_only=True)
class CasingModesSpec:
    """Material, and the casing model with its options. Modes to a higher band serve a lower one, too."""

    material: Material
    model: ElasticCasing


def build(spec: CasingModesSpec, mesh: CasingMesh) -> tuple[CasingModes, CheckUp]:
    """The reduced matrices with their check-up; WorkError names the items of the check-up that fail."""
    modes, found = spec.model.modes(mesh, spec.material)
    if found.failures:
        raise WorkError(
            f"casing: the check-up of the reduced body fails in {', '.join(found.failures)}. Use a finer "
            f"casing.element_size_mm, or another casing model.\n{found.report(0)}"
        )
    return modes, found
