"""Casing models, which connect the bearings of a machine to the ground. Each is a frozen dataclass of options.

A model plans the stages from a structure to its reduced body. `reduce` runs them in order; a pipeline also stores their
results.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from fem.casing.models.meshing import Meshing
from fem.casing.models.stage import MESH, PlannedStage, body_of
from fem.elements.solid_elements import CHOICES, SOLIDS
from fem.options import Option, option

if TYPE_CHECKING:
    from fem.casing.geometry.dimensions import Sensor
    from fem.casing.imported.imported_casing import ImportedMatrices
    from fem.casing.mesh.choose_mesher import Geometry
    from fem.casing.mesh.sizes import Sizes
    from fem.casing.parts.bolted_joint import BoltedJoint
    from fem.casing.reduced.grounded import ForcedPoint
    from fem.casing.reduced.reduced_body import ReducedBody
    from fem.elements.materials import Material

    ElementName = str
else:
    ElementName = Literal[CHOICES]
Frequency = Annotated[float, Option(text="Hz", ge=0)]


@dataclass(frozen=True, kw_only=True)
class Structure:
    """Input of a casing model.

    `housing` is a geometry or imported matrices, with its sensors. The model `none` needs only the positions of the
    `bearings` by name (m). Every bearing loads the casing along the axes `interfaces`, all by default; external forces
    act on the `forced` points. `wall` is the thickness (m) of the thinnest wall, None if unknown; `joint` are the bolts
    between two halves.
    """

    housing: Geometry | ImportedMatrices | None = None
    material: Material | None = None
    bearings: Mapping[str, Sequence[float]] = field(default_factory=dict)
    interfaces: Mapping[str, Sequence[str]] | None = None
    forced: tuple[ForcedPoint, ...] = ()
    joint: BoltedJoint | None = None
    wall: float | None = None

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """The accelerometers on the casing."""
        return () if self.housing is None else self.housing.sensors

    @property
    def bare(self) -> Any:
        """The housing without its sensors."""
        assert self.housing is not None, "the model needs one"
        return replace(self.housing, sensors=())


class CasingModel(ABC):
    """A casing model. Modes up to `limit` (Hz) are kept; None for a model without modes."""

    model: str
    added_modes: ClassVar[int]  # approximate number of modes added to those of the machine
    remedy: ClassVar[str] = 'it has no finite elements; set casing.model = "craig-bampton"'  # for an unknown error

    @property
    def limit(self) -> float | None:
        """Frequency (Hz) up to which modes are kept."""
        return None

    @property
    def no_full_model(self) -> str:
        """Why there is no `error_check`."""
        return (
            f'casing.model = "{self.model}" has no finite elements to compare with. Set casing.model = "craig-bampton"'
        )

    @abstractmethod
    def stages(self, structure: Structure) -> tuple[PlannedStage, ...]:
        """The stages in order; the last one returns the reduced body."""

    def error_check(self, structure: Structure, band: float) -> PlannedStage | None:
        """The stage that compares the body with the full model up to a band (Hz); None without a full model."""
        return None

    def reduce(self, housing: Geometry | None = None, material: Material | None = None, **given: Any) -> ReducedBody:
        """The reduced body of a structure, given by its fields."""
        return body_of(self.stages(Structure(housing=housing, material=material, **given)))


@dataclass(frozen=True, kw_only=True)
class HousingCasing(CasingModel):
    """Base of the models with a housing: its elements, if any, and its damping."""

    element_size: float = option(
        0.022,
        unit="mm",
        gt=0,
        text="edge length of the elements; the model rigid needs a mesh only if the housing is not a plain box",
    )
    element: ElementName = option(
        "tetrahedron-10",
        text="element type. tetrahedron-4 is too stiff in thin walls: for comparison only. tetrahedron-20 and "
        "hexahedron-32 have cubic displacements: for walls one element thick. Hexahedra need a parametric housing "
        "without flange, ribs, fillets and pads, or a mesh file",
    )
    bore_element_size: float | None = option(
        None, unit="mm", gt=0, text="edge length at the bearing seats, if smaller than element_size_mm"
    )
    foot_element_size: float | None = option(
        None, unit="mm", gt=0, text="edge length at the ground faces, if smaller than element_size_mm"
    )
    damping_ratio: float | tuple[tuple[Frequency, float], ...] = option(
        0.01,
        ge=0,
        lt=1,
        text="modal damping ratio: one number, or rows [frequency in Hz, ratio] with ascending frequencies, linear in "
        "between",
    )

    def __post_init__(self) -> None:
        if isinstance(self.damping_ratio, tuple):
            places = [row[0] for row in self.damping_ratio]
            if not places or any(a >= b for a, b in zip(places, places[1:], strict=False)):
                raise ValueError(f"damping_ratio: the frequencies {places} Hz must increase by row. Correct them")

    def needs_mesh(self, structure: Structure) -> bool:
        """Whether a mesh of the housing is needed."""
        return True

    def sizes(self, structure: Structure) -> Sizes:
        """Edge lengths of the elements."""
        from fem.casing.mesh.sizes import Sizes

        return Sizes(element=self.element_size, bore=self.bore_element_size, foot=self.foot_element_size)

    def meshed(self, structure: Structure) -> PlannedStage:
        """The stage that generates the mesh."""
        stage = Meshing(housing=structure.bare, sizes=self.sizes(structure), element=self.element)
        tetrahedra = SOLIDS[self.element].corners == 4
        return PlannedStage(name=MESH, stage=stage, seconds=8.0 if tetrahedra else 3.0)
