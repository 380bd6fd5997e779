"""The claims of the study of the rig: measure and limit of each claim, and the physical reason if it does not hold.

The claims are stated before the computation. The study judges figures by eye. Here the limits of the diagnosis apply: a
line is visible from 6 dB over its healthy control, and levels that differ by less than 1 dB are equal.

References
----------
The study of a quay-crane hoist gearbox, Springer, 978-981-97-1876-4, chapter 15.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pipelines.diagnosis.line_words import EQUAL

if TYPE_CHECKING:
    import xarray

SHOWS = 6.0  # dB over the healthy control
SIGNALS_DIFFER = -20.0  # dB; signals that differ by a tenth


@dataclass(frozen=True, eq=False, kw_only=True)
class ClaimEvidence:
    """All measures in dB, see `pipelines.studies.verification.measures`.

    levels : (losses, load, seed, state, window, measure)
    loads : rope over constant torque (losses, seed, stretch, measure), of the faulty machine
    """

    levels: xarray.DataArray
    loads: xarray.DataArray


@dataclass(frozen=True)
class Claim:
    """The claim that a mean over seeds is at least a given level, dB.

    `compare` returns one value for each condition and seed (..., seed) from the evidence on a measure. `reasons` are
    sentences on why the claim may not hold; those of the claims of one table form a paragraph.
    """

    words: str
    measure: str
    compare: Callable[[ClaimEvidence, str], xarray.DataArray]
    least: float
    reasons: tuple[str, ...]


def over_control(evidence: ClaimEvidence, measure: str) -> xarray.DataArray:
    """Faulty over healthy (losses, load, seed), mean over lifting and lowering."""
    levels = evidence.levels.sel(measure=measure)
    return (levels.sel(state="faulty") - levels.sel(state="healthy")).mean("window")


def of_control(evidence: ClaimEvidence, measure: str) -> xarray.DataArray:
    """The healthy machine (losses, load, seed), mean over lifting and lowering."""
    return evidence.levels.sel(measure=measure, state="healthy").mean("window")


def lifting_over_lowering(evidence: ClaimEvidence, measure: str) -> xarray.DataArray:
    """Lifting over lowering (losses, load, seed) of the faulty machine."""
    levels = evidence.levels.sel(measure=measure, state="faulty")
    return levels.sel(window="lifting") - levels.sel(window="lowering")


def added_in_lifting(evidence: ClaimEvidence, measure: str) -> xarray.DataArray:
    """Increase by the fault in lifting less that in lowering (losses, load, seed)."""
    levels = evidence.levels.sel(measure=measure)
    added = levels.sel(state="faulty") - levels.sel(state="healthy")
    return added.sel(window="lifting") - added.sel(window="lowering")


def rope_over_torque(evidence: ClaimEvidence, measure: str) -> xarray.DataArray:
    """Rope over constant torque (losses, stretch, seed) of the faulty machine."""
    return evidence.loads.sel(measure=measure)


_HIDDEN = (
    "The pitch deviations of the gears repeat once per revolution of the shaft and excite the same lines in the "
    "healthy machine. The fault must exceed these lines, above all around f_m, where the response of the casing is "
    "small."
)
_REVERSED = (
    "Without friction, the excitation in lowering is that of lifting reversed in time. The response is not, because "
    "vibrations decay after a shock in both directions. This causes differences of 1 or 2 dB between lifting and "
    "lowering."
)
_SLIDING = (
    "Tooth friction reverses with the direction. Its force at mesh frequency adds to that of the transmission error in "
    "one direction and opposes it in the other. This changes the mesh line, by 13 dB at 2 f_m, and the modulation, "
    "which is relative to this line. The healthy machine shows the same change, so it is no sign of the fault."
)
_ADDED = (
    "The missing tooth interrupts the mesh force in both directions. A friction coefficient of 0.05 changes this force "
    "by about 5 %, so the interruption hardly depends on the direction."
)
_STEADY = (
    "At constant speed the rope loads the drums as the constant torque does. The container bounces on the rope at "
    "12 Hz, far below the mesh frequency. Speed ramps accelerate the container, which raises the force in the mesh. "
    "The vibration hardly changes, because the teeth excite it. The bounce makes the shaft angles "
    "oscillate, so the signals differ in phase."
)

CLAIMS: dict[str, tuple[Claim, ...]] = {
    "The missing tooth causes f_r and sidebands of f_m at sensor 3: faulty over healthy": (
        Claim("f_r and harmonics in the envelope of f_m/2 to 3 f_m/2", "envelope", over_control, SHOWS, (_HIDDEN,)),
        Claim(
            "f_r and harmonics in the envelope of 1 to 2 kHz", "envelope_1_to_2_kHz", over_control, SHOWS, (_HIDDEN,)
        ),
        Claim("sidebands around f_m", "sidebands_1", over_control, SHOWS, (_HIDDEN,)),
        Claim("sidebands around 2 f_m", "sidebands_2", over_control, SHOWS, (_HIDDEN,)),
        Claim("peak of the time-synchronous average", "tsa_peak", over_control, SHOWS, (_HIDDEN,)),
    ),
    "The healthy machine shows no such lines: margin of its lines to the limit of 10 dB over their floor": (
        Claim("f_r, its harmonics and sidebands, median of 21 lines", "under_limit", of_control, 0.0, (_HIDDEN,)),
    ),
    "Lifting shows the fault more clearly than lowering: lifting over lowering, faulty machine": (
        Claim("modulation of f_m", "modulation_1", lifting_over_lowering, EQUAL, (_REVERSED, _SLIDING)),
        Claim("modulation of 2 f_m", "modulation_2", lifting_over_lowering, EQUAL, (_REVERSED, _SLIDING)),
        Claim("f_r and harmonics in the envelope", "envelope", lifting_over_lowering, EQUAL, (_REVERSED,)),
        Claim("peak of the time-synchronous average", "tsa_peak", lifting_over_lowering, EQUAL, (_REVERSED,)),
    ),
    "Lifting shows the fault more clearly than lowering: increase by the fault, lifting over lowering": (
        Claim("sidebands around f_m", "sidebands_1", added_in_lifting, EQUAL, (_ADDED,)),
        Claim("sidebands around 2 f_m", "sidebands_2", added_in_lifting, EQUAL, (_ADDED,)),
        Claim("f_r and harmonics in the envelope", "envelope", added_in_lifting, EQUAL, (_ADDED,)),
        Claim("peak of the time-synchronous average", "tsa_peak", added_in_lifting, EQUAL, (_ADDED,)),
    ),
    "Rope and constant torque give different signals: rope over torque, faulty machine": (
        Claim(
            "difference of the signals, sample by sample", "difference", rope_over_torque, SIGNALS_DIFFER, (_STEADY,)
        ),
        Claim("level of the acceleration", "level", rope_over_torque, EQUAL, (_STEADY,)),
        Claim("largest force in the mesh of stage 1", "mesh_force", rope_over_torque, EQUAL, (_STEADY,)),
    ),
}

UNTESTED = {
    "Whether the signals with the rope are closer to those of the rig": "undecided, because no measured signals of the "
    "rig are public."
}
