"""Tables of what is looked for in the signals."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pipelines.scene.tables.base import Number, Positive, Table, Whole, Window


class DiagnosisTable(Table):
    """What the spectra and the envelope table look at."""

    sensor: Annotated[str | None, Field(description="its signal is diagnosed; left out: the first one's")] = None
    axis: Annotated[Literal["x", "y", "z", "resultant"], Field(description="of the sensor")] = "z"
    stage: Annotated[Whole, Field(ge=1, description="stage whose mesh frequency carries the sidebands")] = 1
    gear: Annotated[Literal["pinion", "wheel"], Field(description="gear whose rotation is sought")] = "wheel"
    windows_s: dict[str, Window] = Field(
        default_factory=dict, max_length=100, description="constant-speed windows by name"
    )
    envelope_band_Hz: Annotated[
        Literal["mesh", "resonance"] | tuple[Positive, Positive],
        Field(
            description="band that is demodulated, [low, high]; mesh: f_m / 2 around f_m; resonance: where the healthy "
            "run is strongest"
        ),
    ] = "mesh"
    noise_m_s2: Annotated[Number, Field(ge=0, description="rms of white sensor noise added before diagnosis")] = 0.01
    damping_spread: Annotated[
        Number,
        Field(
            gt=0,
            le=9,
            description="error bars: damping ratios of the casing are off by a factor of up to 1 + this, 5 to 95 %; "
            "assumed",
        ),
    ] = 0.3
