"""Settings of the diagnosis, and their table in a scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from pydantic import Field

from fem.options import option
from pipelines.scene.tables.derived import DerivedTable, table
from pipelines.scene.tables.scene_table import Window


@dataclass(frozen=True, kw_only=True)
class Monitored:
    """Signal, gear and windows of the diagnosis.

    `possible` is False without windows or sensors; `speed_is_known` is True if motors prescribe the speed.
    """

    sensor: str | None = option(
        None, text="name of the sensor whose lines are listed (verdict: all sensors); without it: the first sensor"
    )
    axis: Literal["x", "y", "z", "resultant"] = option(
        "z", text="channel of that sensor; resultant: root of the sum of squares"
    )
    stage: int = option(1, ge=1, text="number of the stage whose mesh frequency carries the sidebands")
    gear: Literal["pinion", "wheel"] = option(
        "wheel", text="gear whose revolution frequency is the spacing of the sidebands"
    )
    windows: Mapping[str, tuple[float, float]]
    band: Literal["mesh", "resonance"] | tuple[float, float] = option(
        "mesh",
        key="envelope_band_Hz",
        gt=0,
        text="band that is demodulated: [low, high]; mesh: from 0.5 f_m to 1.5 f_m; "
        "resonance: the band in which the healthy control vibrates most",
    )
    noise: float = option(
        0.01,
        unit="m/s2",
        key="noise_m_s2",
        ge=0,
        text="rms of the white sensor noise that is added before diagnosis; 0: none",
    )
    damping_spread: float = option(
        0.3,
        gt=0,
        le=9,
        text="for the error bars: the damping ratios of the casing are uncertain; 90 % of their possible values differ "
        "from the given ones by a factor of at most 1 + this value",
    )
    possible: bool
    speed_is_known: bool


class _WindowsBase(DerivedTable):
    """When signals are diagnosed."""

    windows_s: dict[str, Window] = Field(
        default_factory=dict,
        max_length=100,
        description="windows of constant speed that are diagnosed, by name; empty: no diagnosis",
    )


DiagnosisTable: TypeAlias = table(Monitored, _WindowsBase)
