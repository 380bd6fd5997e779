"""The claims of the study of the rig, each with its measure and limit, and where it fails the physical reason.

Stated before anything is computed. The study looks at pictures; what counts as "shows" or "clearer" here are the limits
of the diagnosis: a line shows at 6 dB over its healthy control, and what differs by less than 1 dB is equal.

References
----------
The study of a quay-crane hoist gearbox, Springer, 978-981-97-1876-4, chapter 15.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pipelines.signals.verdict import EQUAL

if TYPE_CHECKING:
    import xarray

SHOWS = 6.0  # dB over the healthy control
FLOOR = 10.0  # dB over the local floor
APART = -20.0  # dB; signals that differ by a tenth


@dataclass(frozen=True, eq=False, kw_only=True)
class Evidence:
    """All measures in dB, see `pipelines.verification.measures`.

    levels : (losses, load, seed, state, window, measure)
    loads : rope over constant torque (losses, seed, stretch, measure), of the faulty machine
    """

    levels: xarray.DataArray
    loads: xarray.DataArray


@dataclass(frozen=True, kw_only=True)
class Claim:
    """`compare` takes one value per condition and seed (..., seed) from the evidence on a measure.

    The claim is a mean over seeds of at least, or of at most, so many dB; `reason` is why it may not hold.
    """

    words: str
    measure: str
    compare: Callable[[Evidence, str], xarray.DataArray]
    least: float | None = None
    most: float | None = None
    reason: str

    @property
    def limit(self) -> str:
        """The limit in words."""
        return f"at least {self.least:g} dB" if self.least is not None else f"at most {self.most:g} dB"


def over_control(evidence: Evidence, measure: str) -> xarray.DataArray:
    """Faulty over healthy (losses, load, seed), mean over lifting and lowering."""
    levels = evidence.levels.sel(measure=measure)
    return (levels.sel(state="faulty") - levels.sel(state="healthy")).mean("window")


def of_control(evidence: Evidence, measure: str) -> xarray.DataArray:
    """The healthy machine (losses, load, seed), mean over lifting and lowering."""
    return evidence.levels.sel(measure=measure, state="healthy").mean("window")


def lifting_over_lowering(evidence: Evidence, measure: str) -> xarray.DataArray:
    """Lifting over lowering (losses, load, seed) of the faulty machine."""
    levels = evidence.levels.sel(measure=measure, state="faulty")
    return levels.sel(window="lifting") - levels.sel(window="lowering")


def rope_over_torque(evidence: Evidence, measure: str) -> xarray.DataArray:
    """Rope over constant torque (losses, stretch, seed) of the faulty machine."""
    return evidence.loads.sel(measure=measure)


_HIDDEN = (
    "The pitch deviations of the gears repeat with the same turn of the shaft and fill the same lines in the healthy "
    "machine; the fault must rise over them."
)
_REVERSED = (
    "Without losses and at constant speed lowering is lifting run backwards: the same forces in reversed order have the "
    "same amplitudes. Friction makes lifting the more heavily loaded direction, but by 1 to 2 % per mesh only."
)
_PROMPT = (
    "An impulse is a sum of many lines whose phases count as well as their amplitudes: friction adds to the force of "
    "approaching flanks in one direction and to that of receding ones in the other, and does not make every line larger."
)
_STEADY = (
    "At constant speed the rope carries the weight of the container as the constant torque does; its bounce of 12 Hz "
    "is small and lies far below the mesh."
)

CLAIMS: dict[str, tuple[Claim, ...]] = {
    "With the missing tooth, sensor 3 shows f_r and the sidebands of f_m: faulty over healthy": (
        Claim(
            words="f_r and its harmonics rise in the envelope of f_m/2 to 3 f_m/2",
            measure="envelope", compare=over_control, least=SHOWS, reason=_HIDDEN,
        ),
        Claim(
            words="f_r and its harmonics rise in the envelope of 1 to 2 kHz",
            measure="envelope_1_to_2_kHz", compare=over_control, least=SHOWS, reason=_HIDDEN,
        ),
        Claim(
            words="the sidebands around f_m rise",
            measure="sidebands_1", compare=over_control, least=SHOWS, reason=_HIDDEN,
        ),
        Claim(
            words="the sidebands around 2 f_m rise",
            measure="sidebands_2", compare=over_control, least=SHOWS, reason=_HIDDEN,
        ),
        Claim(
            words="the peak of the time-synchronous average rises",
            measure="tsa_peak", compare=over_control, least=SHOWS, reason=_HIDDEN,
        ),
        Claim(
            words="the healthy machine shows none of these lines: they stay near their floor",
            measure="over_floor", compare=of_control, most=FLOOR, reason=_HIDDEN,
        ),
    ),
    "Lifting shows the fault more clearly than lowering: lifting over lowering, faulty machine": (
        Claim(
            words="modulation of f_m: sidebands over the mesh line",
            measure="modulation_1", compare=lifting_over_lowering, least=EQUAL, reason=_REVERSED,
        ),
        Claim(
            words="modulation of 2 f_m: sidebands over the mesh line",
            measure="modulation_2", compare=lifting_over_lowering, least=EQUAL, reason=_REVERSED,
        ),
        Claim(
            words="f_r and its harmonics in the envelope of f_m/2 to 3 f_m/2",
            measure="envelope", compare=lifting_over_lowering, least=EQUAL, reason=_REVERSED,
        ),
        Claim(
            words="peak of the time-synchronous average",
            measure="tsa_peak", compare=lifting_over_lowering, least=EQUAL, reason=f"{_REVERSED} {_PROMPT}",
        ),
        Claim(
            words="peak of the average over its root mean square",
            measure="tsa_crest", compare=lifting_over_lowering, least=EQUAL, reason=f"{_REVERSED} {_PROMPT}",
        ),
    ),
    "Rope and constant torque give different signals: rope over torque, faulty machine": (
        Claim(
            words="the signals differ by a tenth or more, sample by sample",
            measure="difference", compare=rope_over_torque, least=APART, reason=_STEADY,
        ),
        Claim(
            words="the level at the sensor is higher with the rope",
            measure="level", compare=rope_over_torque, least=EQUAL, reason=_STEADY,
        ),
        Claim(
            words="the largest mesh force of stage 1 is higher with the rope",
            measure="mesh_force", compare=rope_over_torque, least=EQUAL, reason=_STEADY,
        ),
    ),
}  # fmt: skip

UNTESTED = {
    "The signals with the rope are closer to those of the rig.": "No measured signals of the rig are public: cannot be told."
}
