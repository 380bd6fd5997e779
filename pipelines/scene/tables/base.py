"""What every table of a scene is made of: strict numbers, refused unknown keys, and materials."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

# as written: text is no number, true is not 1
Number = Annotated[float, Field(strict=True)]
Whole = Annotated[int, Field(strict=True)]
Flag = Annotated[bool, Field(strict=True)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
Window = Annotated[tuple[Number, Number], Field(description="start and end of the window")]


class Table(BaseModel):
    """Base of all tables: unknown keys, NaN and infinity are refused, values cannot be edited."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class MaterialTable(Table):
    """An isotropic linear elastic material."""

    elastic_modulus_GPa: Annotated[Number, Field(ge=1e-3, le=1e6, description="Young's modulus; steel: 206")]
    poisson_ratio: Annotated[Number, Field(ge=0, lt=0.5, description="Poisson's ratio")]
    density_kg_m3: Annotated[Number, Field(ge=1, le=1e5, description="density; steel: 7850")]
