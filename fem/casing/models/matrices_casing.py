"""A casing of imported matrices, reduced by the method of one of the models with finite elements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from fem.casing.models.casing_model import CasingModel, Structure
from fem.casing.models.elastic_casing import ElasticCasing
from fem.casing.models.stage import MODES, CasingError, CasingInputError, PlannedStage, Stage

if TYPE_CHECKING:
    from fem.casing.imported.imported_casing import ImportedMatrices
    from fem.casing.parts.casing_choices import Attachment, Ground
    from fem.casing.reduced.casing_modes import CasingModes
    from fem.casing.reduced.checkup import CheckUp


@dataclass(frozen=True, kw_only=True)
class MatricesReduction(Stage):
    """Imported matrices and the options of their reduction; `limit` (Hz) of the modes, None: static condensation."""

    kind: ClassVar[str] = "casing-matrices"
    libraries: ClassVar[tuple[str, ...]] = ("numpy", "scipy", "pyyeti")
    housing: ImportedMatrices
    model: str
    interfaces: Mapping[str, Sequence[str]]
    ground: Ground
    attachment: Attachment
    limit: float | None

    def build(self) -> tuple[CasingModes, CheckUp]:
        """The reduced matrices with their check-up.

        Raises
        ------
        CasingInputError : the matrices cannot be used
        CasingError : the reduction fails
        """
        from fem.casing.imported.imported_body import MatrixError
        from fem.casing.imported.imported_casing import imported_casing
        from fem.casing.reduced.reduction import ReductionError
        from fem.numerics.linear_solver import SingularMatrixError

        try:
            return imported_casing(**vars(self))
        except MatrixError as error:
            raise CasingInputError(str(error)) from error
        except (ReductionError, SingularMatrixError) as error:
            raise CasingError(f"casing of matrices: {error}") from error


@dataclass(frozen=True, kw_only=True)
class MatricesCasing(CasingModel):
    """Imported matrices in place of finite elements, reduced with the options `of` a model."""

    of: ElasticCasing
    remedy: ClassVar[str] = "the matrices come from another program"

    @property
    def model(self) -> str:  # type: ignore[override]
        """Model of its options."""
        return self.of.model

    @property
    def limit(self) -> float | None:
        """Frequency (Hz) up to which modes are kept."""
        return self.of.limit

    @property
    def no_full_model(self) -> str:
        """Why there is no `error_check`."""
        return "imported matrices have no full model. Set casing.housing to a shape, a CAD file or a mesh"

    def stages(self, structure: Structure) -> tuple[PlannedStage, ...]:
        """Modes and body."""
        assert not structure.forced, "external forces act on a mesh"
        modes = MatricesReduction(
            housing=structure.bare,
            model=self.of.model,
            interfaces=structure.interfaces or {},
            ground=self.of.ground,
            attachment=self.of.attachment,
            limit=self.limit,
        )
        return PlannedStage(name=MODES, stage=modes, seconds=10.0), self.of.recovered(structure)
