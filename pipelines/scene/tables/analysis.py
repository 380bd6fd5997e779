"""Tables of what is looked for in the signals."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pipelines.scene.tables.base import Number, Positive, Table, Whole, Window


class DiagnosisTable(Table):
    """Signal, gear and windows that are diagnosed."""

    sensor: Annotated[
        str | None, Field(description="name of the sensor whose signal is diagnosed; without it: the first sensor")
    ] = None
    axis: Annotated[
        Literal["x", "y", "z", "resultant"],
        Field(description="channel of that sensor; resultant: root of the sum of squares"),
    ] = "z"
    stage: Annotated[
        Whole, Field(ge=1, description="number of the stage whose mesh frequency carries the sidebands")
    ] = 1
    gear: Annotated[
        Literal["pinion", "wheel"], Field(description="gear whose shaft frequency is the spacing of the sidebands")
    ] = "wheel"
    windows_s: dict[str, Window] = Field(
        default_factory=dict,
        max_length=100,
        description="windows of constant speed that are diagnosed, by name; empty: no diagnosis",
    )
    envelope_band_Hz: Annotated[
        Literal["mesh", "resonance"] | tuple[Positive, Positive],
        Field(
            description="band that is demodulated: [low, high]; mesh: from 0.5 f_m to 1.5 f_m; "
            "resonance: the band in which the healthy control vibrates most"
        ),
    ] = "mesh"
    noise_m_s2: Annotated[
        Number, Field(ge=0, description="rms of the white sensor noise that is added before diagnosis; 0: none")
    ] = 0.01
    damping_spread: Annotated[
        Number,
        Field(
            gt=0,
            le=9,
            description="for the error bars: the damping ratios of the casing are uncertain; 90 % of "
            "their possible values differ from the given ones by a factor of at most 1 + "
            "this value",
        ),
    ] = 0.3
