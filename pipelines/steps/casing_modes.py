"""Step `casing modes`: factorise and reduce the meshed casing, or matrices of another program, and check it up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fem.casing.foreign.casing import ForeignHousing
from fem.elements.materials import Material
from pipelines.border.errors import InputError, WorkError

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


def build(spec: CasingModesSpec, *, mesh: CasingMesh) -> tuple[CasingModes, CheckUp]:
    """The reduced matrices with their check-up; WorkError names the items of the check-up that fail."""
    modes, found = spec.model.modes(mesh, spec.material)
    if found.failures:
        raise WorkError(
            f"casing: the check-up of the reduced body fails in {', '.join(found.failures)}. Use a finer "
            f"casing.element_size_mm, or another casing model.\n{found.report(0)}"
        )
    return modes, found


@dataclass(frozen=True, kw_only=True)
class ForeignCasingSpec:
    """A housing of matrices without sensors, and the casing model with its options."""

    housing: ForeignHousing
    model: ElasticCasing


def build_foreign(spec: ForeignCasingSpec) -> tuple[CasingModes, CheckUp]:
    """The reduced matrices with their check-up.

    Raises
    ------
    InputError : the matrices cannot be used
    WorkError : the reduction fails
    """
    from fem.casing.foreign.body import ForeignError
    from fem.casing.foreign.casing import foreign_casing
    from fem.casing.reduced.reduction import ReductionError
    from fem.numerics.linear_solver import SingularMatrixError

    model = spec.model
    if model.forced:
        raise InputError("excitations of the model casing-force need a meshed casing, not matrices. Leave them out.")
    try:
        return foreign_casing(
            spec.housing,
            model=model.model,
            interfaces=model.interfaces or {},
            ground=model.ground,
            attachment=model.attachment,
            limit=model.limit,
        )
    except ForeignError as error:
        raise InputError(str(error)) from error
    except (ReductionError, SingularMatrixError) as error:
        raise WorkError(f"casing of matrices: {error}") from error
