"""Tables of the casing: its housing, its models, its sensors."""

from __future__ import annotations

import re
from typing import Annotated, ClassVar, TypeAlias

from pydantic import Field, field_validator, model_validator

from fem.casing.geometry.dimensions import Sensor
from fem.casing.models.casing_model import HousingCasing
from fem.casing.models.casing_registry import CASINGS, casing_class
from fem.casing.models.elastic_casing import ElasticCasing
from fem.casing.parts.casing_choices import COVER, FEET, JOINTS, MOUNTS
from fem.elements.materials import Material
from pipelines.scene.tables.derived import DerivedTable, choice, table
from pipelines.scene.tables.housing import HousingModel

MaterialTable: TypeAlias = table(Material)
POINTS = re.compile(
    r"(bearing|ground)_|(bearing|ground|casing|shaft|mesh|motor|load|rope|container)(_[0-9]+)?$|(origin|[xyz])$"
)


class CasingBase(DerivedTable):
    """A model of the casing."""

    elastic: ClassVar[bool] = False  # whether it has finite elements


class FlexibleBase(CasingBase):
    """What every casing with a housing has besides the options of its model."""

    housing: Annotated[HousingModel, Field(description="shape and supports of the housing")]
    material: Annotated[
        MaterialTable | None, Field(description="material of the housing; not needed for a housing of matrices")
    ] = None

    @model_validator(mode="after")
    def _hexahedra(self) -> FlexibleBase:
        of_hexahedra, given = self.element.startswith("hexahedron"), self.housing.model
        if of_hexahedra and given not in ("parametric", "mesh"):
            raise ValueError(
                f'element = "{self.element}": a STEP file is meshed with tetrahedra only; hexahedra need a parametric '
                'housing or a mesh file. Set element = "tetrahedron-10" or "tetrahedron-20"'
            )
        if of_hexahedra and given == "parametric" and (self.bore_element_size_mm or self.foot_element_size_mm):
            raise ValueError(
                f"bore_element_size_mm and foot_element_size_mm do not apply to {self.element} of a parametric "
                "housing, whose elements have one size. Delete them, or set a tetrahedron"
            )
        return self

    @model_validator(mode="after")
    def _with_shape(self) -> FlexibleBase:
        if self.housing.model == "matrices" and not self.elastic:
            raise ValueError(
                'housing.model = "matrices" has no shape for a rigid casing. Set model = "craig-bampton" or "static"'
            )
        return self


class ElasticBase(FlexibleBase):
    """What the models with finite elements ask of the housing."""

    elastic: ClassVar[bool] = True

    @model_validator(mode="after")
    def _meshed_again(self) -> ElasticBase:
        given = self.housing.model
        if self.error is not None and given in ("mesh", "matrices"):
            raise ValueError("error: the file has one element size only. Delete error, or set a STEP file")
        if self.extrapolated and given == "matrices":
            raise ValueError("extrapolated: matrices have no elements. Delete it")
        if self.extrapolated and given == "mesh" and self.element == "tetrahedron-10":
            raise ValueError(
                "extrapolated: the file has one element size only, and tetrahedron-10 needs several. Set element = "
                '"tetrahedron-20", whose error is estimated on one mesh, set a STEP file, or delete extrapolated'
            )
        return self

    @model_validator(mode="after")
    def _parts(self) -> ElasticBase:
        names = {part.name for part in self.damped_parts}
        if JOINTS in names and getattr(self.housing, "joint", None) is None:
            raise ValueError(
                "damped_parts: the housing has no joint. Set casing.housing.joint, or delete the part joints"
            )
        if self.housing.model == "matrices" and names - {MOUNTS}:
            raise ValueError("damped_parts: of matrices only the part mounts is known. Delete the other parts")
        if self.housing.model != "parametric" and (unknown := {COVER, FEET} & names):
            raise ValueError(
                f"damped_parts: {sorted(unknown)[0]} is known of a parametric housing only. Set box_mm and another name"
            )
        return self


def _base(made: type) -> type[CasingBase]:
    if issubclass(made, ElasticCasing):
        return ElasticBase
    return FlexibleBase if issubclass(made, HousingCasing) else CasingBase


CASING_TABLES = tuple(
    table(made, _base(made)) for made in map(casing_class, CASINGS) if "model" in made.__dataclass_fields__
)
CasingModel: TypeAlias = choice(CASING_TABLES, "model")


class _SensorBase(DerivedTable):
    """What a scene asks of the name of a sensor."""

    @field_validator("name", check_fields=False)
    @classmethod
    def _not_another_point(cls, name: str) -> str:
        if POINTS.match(name):
            raise ValueError(f"{name} is already the name of another point of the machine. Set another name")
        return name


SensorTable: TypeAlias = table(Sensor, _SensorBase)
