"""Tables of the casing: its housing, its models, its sensors."""

from __future__ import annotations

import re
from typing import Annotated, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from fem.casing.parts.names import JOINTS, LARGEST_LOSS_FACTOR, MOUNTS
from pipelines.scene.tables.base import MaterialTable, NotNegative, Number, Positive, Table
from pipelines.scene.tables.housing import (
    Axes,
    HousingModel,
    HousingTable,
    MatricesHousingTable,
    MeshHousingTable,
    Vector,
)

Damping = Annotated[Number, Field(ge=0, lt=1)]
Spring = Annotated[Number, Field(gt=0, le=1e7)]
COVER, FEET = "cover", "feet"
KNOWN_PARTS = (COVER, FEET, MOUNTS, JOINTS)
POINTS = re.compile(
    r"(bearing|ground)_|(bearing|ground|casing|shaft|mesh|motor|load|rope|container)(_[0-9]+)?$|(origin|[xyz])$"
)


class DampedPartTable(Table):
    """A part of the casing that damps a mode in proportion to its share of the strain energy."""

    name: Annotated[
        str,
        Field(
            pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,39}$",
            description="cover or feet of a parametric housing, mounts, joints (bolts), or any other name "
            "together with box_mm",
        ),
    ]
    loss_factor: Annotated[
        Number,
        Field(
            ge=0,
            lt=LARGEST_LOSS_FACTOR,
            description="loss factor of its material: twice the damping ratio of a body of this material alone",
        ),
    ]
    box_mm: Annotated[
        tuple[Vector, Vector] | None,
        Field(description="lower and upper corner of a box; the part is all elements whose centre is inside"),
    ] = None

    @model_validator(mode="after")
    def _placed(self) -> DampedPartTable:
        if (self.box_mm is None) != (self.name in KNOWN_PARTS):
            if self.name in KNOWN_PARTS:
                raise ValueError(
                    f'name = "{self.name}" is a part of the parametric housing, found without box_mm. For a part in a '
                    "box set another name"
                )
            raise ValueError(f'name = "{self.name}" needs box_mm. Set it, or a name of {", ".join(KNOWN_PARTS)}')
        if self.box_mm is not None and not all(a < b for a, b in zip(*self.box_mm, strict=True)):
            raise ValueError(
                f"box_mm: the second of the corners {self.box_mm} must be above the first in x, y and z. Correct them"
            )
        return self


MOST_ERROR = 0.05  # that can be asked of frequencies
NOT_EXTRAPOLATED = {  # elements whose error is not told, and what to take instead
    "tetrahedron-4": "tetrahedron-10",
    "hexahedron-20": "hexahedron-32",
    "hexahedron-27": "hexahedron-32",
}


def percent(text: str) -> float:
    """0.002 of "0.2%"."""
    return float(text.removesuffix("%")) / 100.0


class NoCasingTable(Table):
    """The ground holds the bearings. The signals are bearing forces and shaft motions; there are no sensors."""

    modes: ClassVar[int] = 0  # that it adds to the machine, about
    model: Literal["none"] = "none"


class FlexibleBase(Table):
    """What every casing with a housing has."""

    housing: Annotated[HousingModel, Field(description="shape and supports of the housing")]
    material: Annotated[MaterialTable, Field(description="material of the housing")]
    element_size_mm: Annotated[
        Number,
        Field(
            gt=0,
            description="edge length of the elements; the model rigid needs a mesh only if the "
            "housing is not a plain box",
        ),
    ] = 22.0
    element: Annotated[
        Literal["tetrahedron-4", "tetrahedron-10", "tetrahedron-20", "hexahedron-20", "hexahedron-27", "hexahedron-32"],
        Field(
            description="element type. tetrahedron-4 is too stiff in thin walls: for comparison only. "
            "tetrahedron-20 and hexahedron-32 have cubic displacements: for walls one element thick. "
            "Hexahedra need a parametric housing without flange, ribs, fillets and pads, or a mesh "
            "file"
        ),
    ] = "tetrahedron-10"
    bore_element_size_mm: Annotated[
        Positive | None, Field(description="edge length at the bearing seats, where smaller")
    ] = None
    foot_element_size_mm: Annotated[
        Positive | None, Field(description="edge length at the ground faces, where smaller")
    ] = None
    damping_ratio: Annotated[
        Damping | tuple[tuple[NotNegative, Damping], ...],
        Field(
            description="modal damping ratio: one number, or rows [frequency in Hz, ratio] with rising "
            "frequencies, linear in between"
        ),
    ] = 0.01

    @model_validator(mode="after")
    def _hexahedra(self) -> FlexibleBase:
        of_hexahedra, parametric = self.element.startswith("hexahedron"), isinstance(self.housing, HousingTable)
        if of_hexahedra and not parametric and not isinstance(self.housing, MeshHousingTable):
            raise ValueError(
                f'element = "{self.element}": a STEP file is meshed with tetrahedra only; hexahedra need a parametric '
                'housing or a mesh file. Set element = "tetrahedron-10" or "tetrahedron-20"'
            )
        if of_hexahedra and parametric and (self.bore_element_size_mm or self.foot_element_size_mm):
            raise ValueError(
                f"bore_element_size_mm and foot_element_size_mm do not apply to {self.element} of a parametric "
                "housing, "
                "whose elements have one size. Delete them, or set a tetrahedron"
            )
        return self

    @model_validator(mode="after")
    def _rising(self) -> FlexibleBase:
        if isinstance(self.damping_ratio, tuple):
            places = [row[0] for row in self.damping_ratio]
            if not places or any(a >= b for a, b in zip(places, places[1:], strict=False)):
                raise ValueError(f"damping_ratio: the frequencies {places} Hz must rise from row to row. Correct them")
        return self


class RigidCasingTable(FlexibleBase):
    """A rigid body on mounts, one per foot: 6 coordinates and no finite elements."""

    @model_validator(mode="after")
    def _with_shape(self) -> RigidCasingTable:
        if isinstance(self.housing, MatricesHousingTable):
            raise ValueError(
                'housing.model = "matrices" has no shape for a rigid casing. Set model = "craig-bampton" or "static"'
            )
        return self

    modes: ClassVar[int] = 6
    model: Literal["rigid"] = "rigid"
    mount_stiffness_N_per_um: Annotated[
        Number, Field(gt=0, le=1e7, description="stiffness of each mount along x, y and z")
    ] = 200.0


class ElasticBase(FlexibleBase):
    """What the models with finite elements have."""

    ground: Annotated[
        Literal["fixed", "springs"],
        Field(description="fixed: the undersides of the feet are held; springs: each foot stands on a mount"),
    ] = "fixed"
    mounts_N_per_um: Annotated[
        tuple[tuple[Spring, Spring, Spring], ...],
        Field(
            min_length=1,
            description='stiffnesses along x, y and z with ground = "springs": one row for all mounts, or one per foot',
        ),
    ] = ((200.0, 200.0, 200.0),)
    attachment: Annotated[
        Literal["mean", "rigid"],
        Field(
            description="how bearing and mount points are attached to their faces; mean: a point "
            "follows the mean motion of its face (RBE3); rigid: the face is rigid (RBE2)"
        ),
    ] = "mean"
    damped_parts: Annotated[
        tuple[DampedPartTable, ...],
        Field(
            description="parts with a separate loss factor, weighted by strain energy; damping_ratio is that of "
            "the rest"
        ),
    ] = ()
    extrapolated: Annotated[
        bool,
        Field(
            description="true: the stiffness is extrapolated to zero element size. For tetrahedron-20"
            " and hexahedron-32 this uses quadratic displacements on the same mesh, for "
            "tetrahedron-10 two coarser meshes"
        ),
    ] = False

    error: Annotated[
        str | None,
        Field(
            pattern=r"^[0-9]+(\.[0-9]+)? ?%$",
            description='target error of the frequencies, e.g. "0.2%": all element sizes are reduced until half '
            "of the modes meet it, and the stiffness is extrapolated; without it: sizes as given",
        ),
    ] = None

    @model_validator(mode="after")
    def _meshed_again(self) -> ElasticBase:
        if self.error is not None and not 0.0 < percent(self.error) <= MOST_ERROR:
            raise ValueError(f'error = "{self.error}" must be above 0 and at most {100 * MOST_ERROR:g} %. Correct it')
        if self.error is not None and isinstance(self.housing, MeshHousingTable | MatricesHousingTable):
            raise ValueError("error: the file has one element size only. Delete error, or set a STEP file")
        for key, asked in (("error", self.error is not None), ("extrapolated", self.extrapolated)):
            if asked and self.element in NOT_EXTRAPOLATED:
                raise ValueError(
                    f"{key}: the discretisation error of {self.element} is not estimated. Set element = "
                    f'"{NOT_EXTRAPOLATED[self.element]}", or delete {key}'
                )
        if self.extrapolated and isinstance(self.housing, MatricesHousingTable):
            raise ValueError("extrapolated: matrices have no elements. Delete it")
        if self.extrapolated and isinstance(self.housing, MeshHousingTable) and self.element == "tetrahedron-10":
            raise ValueError(
                "extrapolated: the file has one element size only, and tetrahedron-10 needs several. Set element = "
                '"tetrahedron-20", whose error is estimated on one mesh, set a STEP file, or delete extrapolated'
            )
        return self

    @model_validator(mode="after")
    def _parts(self) -> ElasticBase:
        names = [part.name for part in self.damped_parts]
        if repeated := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"damped_parts: {repeated[0]} occurs {names.count(repeated[0])} times. Delete all but one")
        if JOINTS in names and getattr(self.housing, "joint", None) is None:
            raise ValueError(
                "damped_parts: the housing has no joint. Set casing.housing.joint, or delete the part joints"
            )
        if MOUNTS in names and self.ground != "springs":
            raise ValueError(
                'damped_parts: a casing with ground = "fixed" has no mounts. Set ground = "springs", or delete the '
                "part mounts"
            )
        if isinstance(self.housing, MatricesHousingTable) and set(names) - {MOUNTS}:
            raise ValueError("damped_parts: of matrices only the part mounts is known. Delete the other parts")
        if not isinstance(self.housing, HousingTable) and (unknown := {COVER, FEET} & set(names)):
            raise ValueError(
                f"damped_parts: {sorted(unknown)[0]} is known of a parametric housing only. Set box_mm and another name"
            )
        return self


class StaticCasingTable(ElasticBase):
    """Finite elements condensed statically (Guyan) to the bearing points."""

    modes: ClassVar[int] = 40
    model: Literal["static"] = "static"


class CraigBamptonCasingTable(ElasticBase):
    """Finite elements reduced to the bearing points and the fixed-interface modes (Craig-Bampton)."""

    modes: ClassVar[int] = 280
    model: Literal["craig-bampton"] = "craig-bampton"
    band_Hz: Annotated[
        Number,
        Field(
            gt=0, le=20000, description="highest frequency of interest; modes up to 1.5 times this frequency are kept"
        ),
    ] = 5000.0
    frequency_error: Annotated[
        Number | None,
        Field(
            gt=0,
            lt=0.1,
            description="modes are left out as long as no frequency of the band changes by more than "
            "this share; without it: no mode is left out",
        ),
    ] = None
    elements_per_wavelength: Annotated[
        Positive | None,
        Field(
            description="least elements per bending wavelength of the thinnest wall at band_Hz; reduces the "
            "element size where needed"
        ),
    ] = None


CasingModel = Annotated[
    NoCasingTable | RigidCasingTable | StaticCasingTable | CraigBamptonCasingTable, Field(discriminator="model")
]


class SensorTable(Table):
    """A triaxial accelerometer on the casing."""

    name: Annotated[
        str,
        Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,39}$", description="letters, digits, _ and -, at most 40"),
    ]
    position_mm: Annotated[
        tuple[Number, Number, Number],
        Field(description="x, y, z of the sensor, which is moved to the nearest point of the surface"),
    ]
    axes: Annotated[
        Axes, Field(description="directions of its channels x, y, z in the coordinate system of the scene")
    ] = (
        (1.0, 0.0, 0.0),
        (0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0),
    )

    @field_validator("name")
    @classmethod
    def _not_another_point(cls, name: str) -> str:
        if POINTS.match(name):
            raise ValueError(f"{name} is already the name of another point of the machine. Set another name")
        return name
