"""Base of the casing models with finite elements."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from fem.casing.models.body_stages import Recovery
from fem.casing.models.casing_model import HousingCasing, Structure
from fem.casing.models.damped_part import DampedPart
from fem.casing.models.meshing import Meshing, SizedMeshing
from fem.casing.models.reduction_stages import CasingReduction, ErrorCheck, Holding, QuadraticModes
from fem.casing.models.stage import BODY, MESH, MODES, PlannedStage
from fem.casing.parts.casing_choices import MODES_OVER_BAND, MOUNTS, Attachment, Ground
from fem.elements.solid_elements import SOLIDS
from fem.options import option

if TYPE_CHECKING:
    from fem.casing.parts.regions import Region

TRIAL = "trial casing"  # modes from which the element size is predicted
COARSER = ("coarser casing", "coarsest casing")  # modes for the extrapolation: with larger elements, or
QUADRATIC = "quadratic casing"  # with quadratic displacements on the mesh of cubic elements
MOST_ERROR = 0.05  # largest target error of frequencies


@dataclass(frozen=True, kw_only=True)
class ElasticCasing(HousingCasing):
    """A casing modelled by finite elements."""

    remedy: ClassVar[str] = "set casing.extrapolated = true and run the scene again"
    ground: Ground = option(
        "fixed", text="fixed: the undersides of the feet are held; springs: each foot stands on a mount"
    )
    mounts: tuple[tuple[float, float, float], ...] = option(
        ((2e8, 2e8, 2e8),),
        unit="N/um",
        gt=0,
        le=1e7,
        least=1,
        text='stiffnesses along x, y and z with ground = "springs": one row for all mounts, or one per foot in '
        "the order ground_1, ground_2, ...",
    )
    attachment: Attachment = option(
        "mean",
        text="how bearing and mount points are attached to their faces; mean: a point follows the mean "
        "motion of its face (RBE3); rigid: the face is rigid (RBE2)",
    )
    damped_parts: tuple[DampedPart, ...] = option(
        (),
        text="parts with a separate loss factor, weighted by strain energy; damping_ratio is that of the rest",
    )
    extrapolated: bool = option(
        False,
        text="true: the stiffness is extrapolated to zero element size. For tetrahedron-20 and "
        "hexahedron-32 this uses quadratic displacements on the same mesh, for tetrahedron-10 two "
        "coarser meshes",
    )
    error: str | None = option(
        None,
        pattern=r"^[0-9]+(\.[0-9]+)? ?%$",
        text='target error of the frequencies, e.g. "0.2%": all element sizes are reduced so that half of the modes '
        "should meet it, by one prediction, and the stiffness is extrapolated; without it: sizes as given",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.error is not None and not 0.0 < self.target_error <= MOST_ERROR:
            raise ValueError(f'error = "{self.error}" must be above 0 and at most {100 * MOST_ERROR:g} %. Correct it')
        for key, asked in (("error", self.error is not None), ("extrapolated", self.extrapolated)):
            if asked and (instead := SOLIDS[self.element].instead):
                raise ValueError(
                    f"{key}: the discretisation error of {self.element} is not estimated. Set element = "
                    f'"{instead}", or delete {key}'
                )
        names = [part.name for part in self.damped_parts]
        if repeated := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"damped_parts: {repeated[0]} occurs {names.count(repeated[0])} times. Delete all but one")
        if MOUNTS in names and self.ground != "springs":
            raise ValueError(
                'damped_parts: a casing with ground = "fixed" has no mounts. Set ground = "springs", or delete the '
                "part mounts"
            )

    @property
    def target_error(self) -> float:
        """Target of the median band of the frequencies, which sets the element size; 0.0 if that is given."""
        return 0.0 if self.error is None else float(self.error.removesuffix("%")) / 100.0

    def stages(self, structure: Structure) -> tuple[PlannedStage, ...]:
        """Mesh, modes and body; on request also the modes for its extrapolation and for its element size."""
        first, reduction = self.meshed(structure), self.reduction(structure)
        extrapolated = self.extrapolated or self.error is not None
        cubic = SOLIDS[self.element].degree == 3
        coarser: list[PlannedStage] = []
        if extrapolated and not cubic:
            assert isinstance(first.stage, Meshing)
            for name, larger in zip(COARSER, first.stage.coarser(), strict=True):
                ratio = larger.sizes.element / first.stage.sizes.element
                mesh = PlannedStage(name=f"{name} mesh", stage=larger, seconds=first.seconds / ratio**2)
                coarser += [mesh, reduction.lowest(name, mesh)]
        names = tuple(stage.name for stage in coarser[1::2])
        sized = [] if self.error is None else self._sized(first, reduction, names)
        quadratic = extrapolated and cubic
        modes = replace(reduction, quadratic=quadratic)
        lower = [PlannedStage(name=QUADRATIC, stage=QuadraticModes(), takes={"modes": MODES})] if quadratic else []
        return (
            *([] if sized else [first]),
            *coarser,
            *sized,
            PlannedStage(name=MODES, stage=modes, takes={"mesh": MESH}, seconds=18.0 if quadratic else 13.0),
            *lower,
            self.recovered(structure, names or tuple(stage.name for stage in lower)),
        )

    def _sized(self, first: PlannedStage, reduction: CasingReduction, coarser: tuple[str, ...]) -> list[PlannedStage]:
        """Stages of the mesh with the largest elements, its lowest modes, and the mesh of the size that they give.

        Without `coarser` stages the size follows from quadratic displacements on the first mesh.
        """
        trial, lower = replace(first, name=f"{TRIAL} mesh"), f"{QUADRATIC}, trial"
        band = 0.0 if self.limit is None else self.limit / MODES_OVER_BAND
        stage = SizedMeshing(**vars(first.stage), error=self.target_error, band=band)
        return [
            trial,
            reduction.lowest(TRIAL, trial),
            *([] if coarser else [reduction.lowest(lower, trial, quadratic=True)]),
            replace(first, stage=stage, takes={"trial": TRIAL, "coarser": coarser or (lower,)}),
        ]

    def held(self, structure: Structure) -> Holding:
        """Supports of the casing by its ground and its bearings."""
        assert structure.material is not None, "elements need a material"
        return Holding(
            material=structure.material,
            interfaces=structure.interfaces,
            ground=self.ground,
            attachment=self.attachment,
            joint=structure.joint,
        )

    def regions(self, structure: Structure) -> tuple[Region, ...]:
        """Boxes of the damped parts that consist of elements."""
        found = (part.region(structure.housing) for part in self.damped_parts)
        return tuple(region for region in found if region is not None)

    @abstractmethod
    def reduction(self, structure: Structure) -> CasingReduction:
        """The stage that computes the modes of a mesh."""

    def recovered(self, structure: Structure, coarser: tuple[str, ...] = ()) -> PlannedStage:
        """The stage that computes the body from its modes and those of `coarser` stages."""
        return PlannedStage(name=BODY, stage=self.recovery(structure), takes={"modes": MODES, "coarser": coarser})

    def recovery(self, structure: Structure) -> Recovery:
        """The stage that adds damping, mounts and sensors to the modes."""
        return Recovery(
            sensors=structure.sensors,
            damping=self.damping_ratio,
            loss_factors={part.name: part.loss_factor for part in self.damped_parts},
            mounts=self.mounts if self.ground == "springs" else None,
            limit=self.limit,
        )

    def error_check(self, structure: Structure, band: float) -> PlannedStage:
        """The comparison with the full model up to a band (Hz)."""
        stage = ErrorCheck(reduction=self.reduction(structure), recovery=self.recovery(structure), band=band)
        takes: Mapping[str, str | tuple[str, ...]] = {"mesh": MESH, "modes": MODES, "body": BODY}
        return PlannedStage(name="casing error", stage=stage, takes=takes, seconds=40.0)
