"""Tables of the losses: what makes driving differ from being driven; and of the oil film between flanks."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pipelines.scene.tables.base import Number, Table


class NoLosses(Table):
    """Meshes and bearings without friction."""

    model: Literal["none"] = "none"


class EfficiencyLosses(Table):
    """Every mesh passes on the given share of its input power."""

    model: Literal["efficiency"] = "efficiency"
    mesh_efficiency: Annotated[
        Number, Field(gt=0.5, le=1, description="output power divided by input power of every mesh")
    ] = 0.99


class CoulombLosses(Table):
    """Sliding friction of the teeth, which reverses at the pitch point, and drag torque of the bearings."""

    model: Literal["coulomb"] = "coulomb"
    tooth_friction: Annotated[Number, Field(ge=0, le=0.5, description="coefficient of friction of a tooth pair")] = 0.05
    bearing_friction: Annotated[
        Number, Field(ge=0, le=0.1, description="coefficient of friction of the bearings, at half the shaft diameter")
    ] = 0.0015


class NoFilm(Table):
    """Dry flanks."""

    model: Literal["none"] = "none"


class SqueezeFilm(Table):
    """Squeeze film of oil between approaching flanks, in all meshes."""

    model: Literal["squeeze"] = "squeeze"
    viscosity_mPa_s: Annotated[
        Number, Field(gt=0, le=1e5, description="dynamic viscosity at the temperature of the oil")
    ] = 50.0
    roughness_um: Annotated[Number, Field(ge=0.05, le=100, description="least film thickness")] = 1.0


FilmModel = Annotated[NoFilm | SqueezeFilm, Field(discriminator="model")]
LossModel = Annotated[NoLosses | EfficiencyLosses | CoulombLosses, Field(discriminator="model")]
