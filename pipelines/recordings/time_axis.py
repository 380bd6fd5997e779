"""Time axis of a recording: even steps, with the sampling rate from a time channel, the file or the machine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.recordings.recording_channels import RecordedChannel
from pipelines.recordings.units import TIMES, plain_units

NAMES = ("time", "t", "zeit", "times", "timestamp", "time_s", "seconds", "x_value")
AGREEMENT = 1e-4  # relative difference of the rates of the file and the machine
JITTER = 0.05  # of a step: largest deviation of an instant from the even steps
LOST = 0.4  # of a step: one lost sample shifts instants by at least half a step
_DIGITS = 12


def is_time(channel: RecordedChannel) -> bool:
    """Whether a channel contains time stamps, or has the name of a time; only the last part of a path matters."""
    return channel.stamps or (channel.name.lower().replace(" ", "_").rpartition(".")[2] in NAMES and channel.is_numeric)


def sampling(
    signals: Sequence[RecordedChannel], clock: RecordedChannel | None, rate: float | None, source: str
) -> tuple[float, float]:
    """Sampling rate (Hz) and time of the first sample (s); the rate of the machine if the file agrees with it.

    Parameters
    ----------
    signals : the channels in use, of equal length
    clock : the channel of the time, if there is one
    rate : that of the machine, Hz
    source : of the recording, for messages

    Raises
    ------
    InputError : uneven time, rates that contradict each other, or no rate at all
    """
    given = {f'"{shown(one.name, 60)}"': one.rate for one in signals if one.rate is not None}
    start = 0.0
    if clock is not None:
        measured, start = _even_steps(clock, source)
        given = {f'the time in "{shown(clock.name, 60)}"': measured, **given}
    if rate is not None:
        given = {"rate_Hz": rate, **given}
    if not given:
        raise InputError(f"{source}: holds neither the time nor the sampling rate. Set rate_Hz in the machine file.")
    (first, found), *others = given.items()
    for other, value in others:
        if abs(value / found - 1.0) > AGREEMENT:
            raise InputError(
                f"{source}: {first} gives {found:.8g} Hz, {other} {value:.8g} Hz; the largest "
                f"difference allowed is {AGREEMENT:.2%}. Correct rate_Hz, or set sensors to channels of one rate."
            )
    return found, start


def _even_steps(clock: RecordedChannel, source: str) -> tuple[float, float]:
    """Rate and start of a time channel with even steps."""
    seconds = TIMES.get(plain_units(clock.units) or "s")
    where = f'{source}: the time in "{shown(clock.name, 60)}"'
    if seconds is None:
        raise InputError(f"{where} has the units {shown(clock.units)}, allowed are {', '.join(TIMES)}. Correct them.")
    start, end = (float(clock.read(slice(at, at + 1))[0]) for at in (0, clock.size - 1))
    step = (end - start) / (clock.size - 1)
    if not step > 0.0:
        raise InputError(
            f"{where} goes from {start:g} to {end:g}; it must increase. Set time = false and rate_Hz in the machine "
            "file."
        )
    grain = max(_last_digit(clock.read(slice(0, 1000)).astype(float)), _spacing(clock.dtype, end))
    allowed = min(JITTER * step + grain, LOST * step)
    for first, times in clock.blocks():
        even = start + step * np.arange(first, first + len(times))
        off = np.abs(times - even)
        worst = int(np.argmax(off))
        if not off[worst] <= allowed:
            raise InputError(
                f"{where} is uneven: sample {first + worst + 1} deviates from even steps by {off[worst] / step:.3g} "
                f"steps, {allowed / step:.2g} are allowed.{_first_jump(clock)} "
                "Resample it; if the time only has too few digits, set time = false "
                "and rate_Hz in the machine file."
            )
    return 1.0 / (step * seconds), start * seconds


def _first_jump(clock: RecordedChannel) -> str:
    """The first place where the step between two samples is not the usual one, in words; "" without one."""
    for first, times in clock.blocks():
        steps = np.diff(times)
        usual = float(np.median(steps)) if len(steps) else 0.0
        jumps = np.flatnonzero(np.abs(steps - usual) > LOST * abs(usual))
        if len(jumps):
            at = int(jumps[0])
            return (
                f" The first jump is from sample {first + at + 1} ({times[at]:.6g}) to the next ({times[at + 1]:.6g})."
            )
    return ""


def _last_digit(times: np.ndarray) -> float:
    """Step of the last decimal digit of the instants, 0.0 if they have too many digits."""
    for digits in range(_DIGITS):
        if np.allclose(times, np.round(times, digits), rtol=0.0, atol=1e-13 * max(1.0, float(np.abs(times).max()))):
            return 10.0**-digits
    return 0.0


def _spacing(kind: np.dtype, value: float) -> float:
    """Distance between neighbouring numbers of a floating-point type at a value."""
    return float(np.spacing(kind.type(abs(value)))) if kind.kind == "f" else 0.0
