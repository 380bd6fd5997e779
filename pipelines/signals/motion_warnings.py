"""Warnings of a motion: its time step, its repeatability and its energy balance."""

from __future__ import annotations

import json
import logging
import math
from collections import Counter
from collections.abc import Container, Iterable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray

    from mbd.output.trajectory import Trajectory

_LOG = logging.getLogger(__name__)
KINDS = ("step", "repeat", "energy")
LARGEST_STEP_ERROR = 0.05
ATTRIBUTE = "warnings"  # of a response
MOSTLY_OPEN = 0.5  # of the time; a pair that is out of contact for longer rattles freely in its backlash


def motion_warnings(trajectory: Trajectory) -> dict[str, str]:
    """Warnings by kind, see KINDS; empty for a run without any."""
    found = {}
    if trajectory.step_error > LARGEST_STEP_ERROR:
        found["step"] = _step_sentence(trajectory)
    if trajectory.diverged_at > 0.0:
        found["repeat"] = (
            f"The motion is chaotic and cannot be repeated sample by sample: an initial difference of a millionth "
            f"reaches the size of the signal at {trajectory.diverged_at:.3g} s (it doubles every "
            f"{math.log(2.0) / trajectory.parting_rate * 1000:.2g} ms). A smaller time step does not help. Use levels, "
            'spectra and lines, not the waveform; "gearcase starts SCENE" estimates their spread over several initial '
            "states."
        )
    for text in trajectory.unbalanced():
        found["energy"] = (
            f"{text[:1].upper()}{text[1:]} The motion is not accurate: set a smaller "
            "simulation.step_us, or a larger simulation.band_Hz."
        )
    return found


def chance_of_run(run: xarray.Dataset, end: float) -> str:
    """Why the difference of a run from its control up to `end` (s) can be chance and no effect of a fault, or "".

    Chaos is observed only while a neighbouring motion is followed, so that it can be missed. Teeth that hardly touch
    have no load that determines their position; this is the second criterion.

    Parameters
    ----------
    run : response of the machine
    end : s, of the last evaluated window
    """
    until = run.attrs.get("repeatable_until_s", "the end")
    if until != "the end" and until < end:
        return f"the motion is chaotic and cannot be repeated after {until:.3g} s"
    for name, value in json.loads(run.attrs.get("counters", "{}")).items():
        share = 1e-6 * value / float(run.time[-1])
        if name.endswith(":microseconds_open") and share > MOSTLY_OPEN:
            return f"the teeth of {name.partition(':')[0]} are out of contact for {100 * share:.0f} % of the time"
    return ""


def _step_sentence(trajectory: Trajectory) -> str:
    needed = needed_step_us(trajectory.step_error, trajectory.step, trajectory.output_rate)
    other = "" if trajectory.integrator == "exponential" else ', or simulation.integrator = "exponential"'
    return (
        f"The time step of {trajectory.step * 1e6:.4g} us (simulation.step_us, rounded down to a fraction of the "
        f"output interval) is too long: the error of the accelerations is about "
        f"{100 * trajectory.step_error:.2g} % (RMS of the difference, sample by sample; limit "
        f"{100 * LARGEST_STEP_ERROR:g} %). Set simulation.step_us = {needed}{other}."
    )


def needed_step_us(error: float, step: float, rate: float) -> str:
    """The longest step (us), as text, that keeps the error within its limit and divides the output interval.

    It is rounded up: rounded down, one step more would be needed for the interval.

    Parameters
    ----------
    error : of the accelerations with `step`, relative to their rms
    step : s
    rate : output samples per second, Hz
    """
    from mbd.output.step_error import ORDER

    every = math.ceil((error / LARGEST_STEP_ERROR) ** (1.0 / ORDER) / (rate * step))
    exact = 1e6 / (rate * every)
    digits = max(0, 2 - math.floor(math.log10(exact)))
    return f"{math.ceil(exact * 10**digits - 1e-9) / 10**digits:.{digits}f}"


def log_warnings(motions: Iterable[Trajectory], kinds: Container[str] = KINDS) -> None:
    """Log the warnings of the motions of a command, each kind once, for computed and for cached motions."""
    for text in gathered(map(motion_warnings, motions), kinds):
        _LOG.warning("%s", text)


def stored_warnings(attributes: Mapping[str, Any]) -> dict[str, str]:
    """The warnings in the attributes of a response."""
    return json.loads(attributes.get(ATTRIBUTE, "{}"))


def gathered(warnings: Iterable[Mapping[str, str]], kinds: Container[str] = KINDS) -> tuple[str, ...]:
    """The warnings of several motions: each kind once, with the number of motions that have it."""
    every = list(warnings)
    counts = Counter(kind for one in every for kind in one if kind in kinds)
    first = {kind: next(one[kind] for one in every if kind in one) for kind in counts}
    if len(every) == 1:
        return tuple(first.values())
    many = {kind: "all" if count == len(every) else f"{count} of" for kind, count in counts.items()}
    return tuple(f"{text} ({many[kind]} {len(every)} motions)" for kind, text in first.items())
