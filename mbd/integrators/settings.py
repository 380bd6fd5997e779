"""Settings of a simulation: length, output rate, time step, method; defaults of the scene's [simulation]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from fem.options import check_options, option
from mbd.elements.channel_reading import FURTHER

if TYPE_CHECKING:
    FurtherChannel = str
else:
    FurtherChannel = Literal[tuple(FURTHER)]

HIGHEST_RATE = 200e3  # Hz, of the results


@dataclass(frozen=True, kw_only=True)
class MotionSettings:
    """Time integration and output."""

    end: float = option(unit="s", gt=0, le=3600, text="simulated time")
    output_rate: float = option(
        10e3,
        unit="Hz",
        gt=0,
        le=HIGHEST_RATE,
        text="sampling rate of the results, after the anti-alias filter",
    )
    step: float = option(
        33.4e-6,
        unit="us",
        gt=0,
        le=1000,
        text="time step, which is rounded down to a whole fraction of the sampling interval",
    )
    start: int = option(
        0,
        ge=0,
        le=1_000_000,
        text="0: start at rest in static equilibrium; 1, 2, ...: other initial states, with all modal displacements "
        "changed by about 0.01 %, to show how much a chaotic motion depends on them",
    )
    band: float = option(
        20e3,
        unit="Hz",
        ge=1000,
        text="modes of the whole machine above this frequency are represented by their static response only",
    )
    integrator: Literal["exponential", "trapezoidal", "generalised-alpha"] = option(
        "exponential", text="time integration method, see docs/choosing-a-model.md"
    )

    channels: tuple[FurtherChannel, ...] = option(
        (),
        text="further signals to record; bearing-misalignment: rotation of the shaft in every bearing relative to its "
        "seat, about x and z",
    )

    def __post_init__(self) -> None:
        check_options(self, ValueError)
        if self.end * self.output_rate < 1:
            raise ValueError(
                f"end_s = {self.end:g} is shorter than one sample at output_rate_Hz = {self.output_rate:g}. Set at "
                f"least {1.0 / self.output_rate:g}, or raise output_rate_Hz"
            )

    @property
    def n_samples(self) -> int:
        """Samples at 0, 1/output_rate, ... before ``end``."""
        return round(self.end * self.output_rate)

    @property
    def steps(self) -> float:
        """Number of time steps, as far as none is cut."""
        return self.end / self.step
