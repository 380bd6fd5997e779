"""Features of a recording: each window is cut into turns of each shaft, from which the features of components follow.

Each window is evaluated separately, so that lifting and lowering are not averaged. The values of the table are means
over the windows.

Envelopes are taken of the whole range above half of the lowest mesh frequency. Below, the beat of a few strong shaft
orders would look like impulses. A narrow band with the largest kurtosis of its envelope (Antoni 2007, Mech. Syst.
Signal Process. 21(1), 108-124) increases the features of a damaged gear more, but differs between healthy machines: a
missing tooth is 15 standard deviations above healthy test benches in the best of 24 bands, and 56 in the whole range.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from pipelines.signals.features.average_features import meshing, synchronous
from pipelines.signals.features.definitions import BY_NAME
from pipelines.signals.features.envelope_features import (
    FINE,
    envelope_orders,
    impact_place,
    tooth_contrast,
    tooth_energies,
)
from pipelines.signals.features.feature_table import WHOLE, FeatureTable
from pipelines.signals.features.passing import PASSING, pass_levels
from pipelines.signals.features.shaft_turns import Turns, cut_turns
from pipelines.signals.features.statistics import kurtosis, squared_magnitude, statistics
from pipelines.signals.features.synchronous_averages import FEWEST_TURNS, Average, average_power
from pipelines.signals.features.unresolved_passes import unresolved_passes
from pipelines.signals.orders.kinematics import GUARD_ORDER, Kinematics, Shaft
from pipelines.signals.orders.revolutions import HIGHEST, within
from pipelines.signals.orders.rotation import Rotation
from pipelines.signals.orders.whitening import banded

if TYPE_CHECKING:
    import xarray

Lines = dict[tuple[str, str], np.ndarray]  # (component, feature) -> (channel,)

OF_SIGNAL = ("rms", "crest_factor", "kurtosis")
OF_SHAFT = {"order_1": 1, "order_2": 2}
OF_AVERAGE = ("tsa_rms", "tsa_peak_to_peak", "tsa_kurtosis")
OF_PLAIN_SHAFT = ("tsa_rms", "tsa_kurtosis", "envelope_orders")  # of a shaft without known gears
OF_GEAR = ("difference_rms", "fm4", "envelope_orders", "whitened_kurtosis", "fm0", "sideband_ratio")
OF_MESH = (*(name for name in BY_NAME if name.startswith("mesh_")), "residual_rms")
CONTRASTS = ("tooth_contrast", "whitened_contrast", "average_contrast")
OF_WHITENED = ("whitened_kurtosis", *CONTRASTS[1:])
QUARTER = 0.25  # turns, largest uncertainty of the angle over the window for averages over turns
WHITE = 0.25  # of the lowest mesh order of a shaft: width of whitening


class FeatureError(ValueError):
    """A recording has no features: all shafts make too few turns, or no channel contains a signal."""


def recording_features(
    recording: xarray.Dataset,
    kinematics: Kinematics,
    rotation: Rotation,
    windows: Mapping[str, tuple[float, float]] | None = None,
    complete: bool = False,
) -> FeatureTable:
    """Features of a recording.

    Parameters
    ----------
    recording : `acceleration` (time, sensor, axis), m/s2
    kinematics : of the machine
    rotation : angle of its first shaft at the same samples
    windows : name -> start and end (s) within the recording, all of which is evaluated if None
    complete : all features of `definitions`; otherwise those that are evidence in a diagnosis

    Raises
    ------
    FeatureError : no shaft has a known speed or makes FEWEST_TURNS turns in a window, or no channel contains a signal
    """
    time = np.asarray(recording.time.values, dtype=float)
    sensors, axes, signal = recorded_channels(recording)
    given = dict(windows) if windows else {"the whole recording": (float(time[0]), float(time[-1]))}
    found = []
    for name, window in given.items():
        turning = _turning_shafts(signal, time, kinematics, rotation, name, window)
        found.append(_window_features(signal, time, window, turning, kinematics, rotation, complete))
    lines, powers, marks, bands, speeds = zip(*found, strict=True)
    values, power = _mean(lines), _mean(list(chain.from_iterable(powers)))
    teeth = {gear: tooth for marked in reversed(marks) for gear, tooth in marked.items()}  # the first window counts
    none = np.outer([0.0, 1.0, 1.0], np.ones(len(sensors)))
    retained, of_average, repeating = np.stack([power.get(line, none) for line in values], axis=-1)
    conditional = {
        shaft: f"{_named(shaft, kinematics, bearings=True)}: {reason}" for shaft, reason in rotation.conditional.items()
    }
    return FeatureTable(
        sensor=sensors,
        axis=axes,
        component=tuple(component for component, _ in values),
        feature=tuple(feature for _, feature in values),
        value=np.stack(list(values.values()), axis=1),
        retained=retained,
        of_average=of_average,
        repeating=repeating,
        conditional=tuple(conditional.get(kinematics.shaft_of(component), "") for component, _ in values),
        gear=tuple(teeth),
        tooth=np.array(list(teeth.values()), dtype=int),
        window=tuple(given),
        band_low=np.array([low for low, _ in bands]),
        band_high=np.array([high for _, high in bands]),
        speed=np.array(speeds),
        left_out=_left_out(kinematics, rotation, time, set(values), given),
    )


def _turning_shafts(
    signal: np.ndarray,
    time: np.ndarray,
    kinematics: Kinematics,
    rotation: Rotation,
    name: str,
    window: tuple[float, float],
) -> list[tuple[Shaft, Turns]]:
    """The shafts that make enough turns in a window, with the signal in turns; FeatureError without a known speed."""
    known = {shaft.name for shaft in kinematics.shafts} - rotation.conditional.keys()
    cuts = {shaft: cut_turns(signal, time, rotation, shaft.ratio, window) for shaft in kinematics.shafts}
    turning = [(shaft, cut) for shaft, cut in cuts.items() if cut is not None and cut.count >= FEWEST_TURNS]
    if any(shaft.name in known for shaft, _ in turning):
        return turning
    reasons = "".join(f" {shaft}: {reason}." for shaft, reason in rotation.conditional.items())
    known_speed = "correct teeth, set speed with its uncertainty, or record a tachometer."
    if not known:
        raise FeatureError(f"{name}: no shaft has a confirmed speed.{reasons} Use a longer recording, {known_speed}")
    confirmed, remedy = "", " or one at a higher speed."
    if rotation.conditional:
        confirmed, remedy = " with a confirmed speed", f", {known_speed}"
    raise FeatureError(
        f"no shaft{confirmed} makes {FEWEST_TURNS} revolutions between {window[0]:g} and "
        f"{min(window[1], float(time[-1])):g} s.{reasons} Set a longer window{remedy}"
    )


def _window_features(
    signal: np.ndarray,
    time: np.ndarray,
    window: tuple[float, float],
    turning: Sequence[tuple[Shaft, Turns]],
    kinematics: Kinematics,
    rotation: Rotation,
    complete: bool,
) -> tuple[Lines, list[Lines], dict[str, int], tuple[float, float], float]:
    """Features of the whole machine and its turning shafts in a window.

    With them, for each shaft the power and the share that repeat, the marked teeth, the band (Hz) and the speed (Hz) of
    the first shaft.
    """
    speed = turning[0][1].frequency / turning[0][0].ratio
    band = envelope_band(kinematics, time, speed)
    whole = statistics(signal[:, within(time, window)])
    found: Lines = {(WHOLE, name): value for name, value in whole.items() if complete or name in OF_SIGNAL}
    powers: list[Lines] = []
    teeth: dict[str, int] = {}
    for shaft, cut in turning:
        lines, power, marks = _shaft_lines(cut, band, shaft, kinematics, rotation, complete)
        if rotation.error * cut.count > QUARTER:  # no averages over turns, and pass orders allow slip
            strikes = {strike for bearing in kinematics.bearings for strike in bearing.strikes}
            lines, marks = {line: value for line, value in lines.items() if line[0] in strikes}, {}
        found |= lines
        powers.append(power)
        teeth = (marks if rotation.places_teeth(shaft.name) else {}) | teeth
    return found, powers, teeth, band, speed


def recorded_channels(recording: xarray.Dataset) -> tuple[tuple[str, ...], tuple[str, ...], np.ndarray]:
    """Sensor and axis of every channel with a signal, and the signals (channel, time) less their means.

    Raises
    ------
    FeatureError : no channel contains a signal
    """
    name = "acceleration" if "acceleration" in recording else "journal_acceleration"
    signal = recording[name].rename(bearing="sensor") if "bearing" in recording[name].dims else recording[name]
    laid = signal.transpose("sensor", "axis", "time")
    pairs = [(str(sensor), str(axis)) for sensor in laid.sensor.values for axis in laid.axis.values]
    values = laid.values.reshape(len(pairs), -1).astype(float)
    there = [i for i, one in enumerate(values) if np.isfinite(one).all() and one.any()]
    if not there:
        raise FeatureError("no channel holds a signal: all are zero or not numbers. Check the sensors")
    values = values[there] - values[there].mean(axis=-1, keepdims=True)
    return tuple(pairs[i][0] for i in there), tuple(pairs[i][1] for i in there), values


def envelope_band(kinematics: Kinematics, time: np.ndarray, frequency: float) -> tuple[float, float]:
    """Band of the envelopes (Hz): from half of the lowest mesh frequency to HIGHEST of the sampling rate.

    Parameters
    ----------
    kinematics : of the machine
    time : of the recording, s
    frequency : of the first shaft, Hz

    Raises
    ------
    FeatureError : the band is empty
    """
    guard, high = kinematics.envelope_order, HIGHEST * (len(time) - 1) / float(time[-1] - time[0])
    if not guard * frequency < high:
        raise FeatureError(
            f"the envelope band begins at {guard * frequency:.4g} Hz, the recording holds up to {high:.4g} Hz. "
            "Increase the sampling rate."
        )
    return guard * frequency, high


def _shaft_lines(
    cut: Turns, band: tuple[float, float], shaft: Shaft, kinematics: Kinematics, rotation: Rotation, complete: bool
) -> tuple[Lines, Lines, dict[str, int]]:
    """Features of a shaft, its gears and bearings, power and share that repeat, and the marked tooth of each gear."""
    gears = kinematics.gears_on(shaft.name)
    averaged = Average(values=cut.values.mean(axis=1), orders=cut.orders, teeth=[gear.teeth for gear in gears])
    found = synchronous(averaged)
    irregular = cut.values - averaged.regular[:, None, :]
    laid = irregular.reshape(len(irregular), -1)
    low, high = (end / cut.frequency / cut.values.shape[2] for end in band)  # of the sampling rate of the turns
    orders = WHITE * min(gear.teeth for gear in gears) if gears else GUARD_ORDER
    width = orders / cut.values.shape[2]
    ratios = [other.ratio / shaft.ratio for other in kinematics.shafts]
    plain, white = (one.reshape(cut.values.shape) for one in banded(laid, (low, high), width))
    envelope = squared_magnitude(plain)
    found |= {"envelope_orders": envelope_orders(envelope), "whitened_kurtosis": kurtosis(white.mean(axis=1).real)}
    lines: Lines = {(shaft.name, name): cut.order(order) for name, order in OF_SHAFT.items()}
    of_shaft = (*(() if gears else OF_PLAIN_SHAFT), *(OF_AVERAGE if complete else ()))
    lines |= {(shaft.name, name): found[name] for name in of_shaft}
    squares = envelope, squared_magnitude(white), squared_magnitude(white.mean(axis=1, keepdims=True))
    marks = {}
    for gear in gears:
        of_gear = found | meshing(averaged, gear.teeth)
        energies = (tooth_energies(one, gear.teeth) for one in squares)
        of_gear |= {name: tooth_contrast(one) for name, one in zip(CONTRASTS, energies, strict=True)}
        names = (*OF_GEAR, *(OF_MESH if complete else ()), *CONTRASTS)
        lines |= {(gear.name, name): of_gear[name] for name in names}
        place = impact_place(tooth_energies(squares[2], FINE * gear.teeth), cut.backwards)
        marks[gear.name] = round(place + gear.cycle) % gear.teeth  # at the pitch point when the impact begins
    share = squares[2].mean(axis=(1, 2)) / squares[1].mean(axis=(1, 2))
    repeating = np.stack([*average_power(plain), share])
    power = dict.fromkeys([line for line in lines if line[1] not in OF_SHAFT], repeating)
    for bearing in kinematics.bearings:
        if bearing.shaft == shaft.name:
            repeats = [order / shaft.ratio for order in kinematics.tooth_repeats().values()]
            lines |= pass_levels(squares[1], bearing.strikes, ratios, rotation, bearing.sidebands, repeats)
    return lines, power, marks


def _mean(windows: Sequence[Lines]) -> Lines:
    """Mean of each line over the windows that have it; lines with orders beyond the spectrum are omitted."""
    named = dict.fromkeys(name for lines in windows for name in lines)
    means = {name: np.mean([lines[name] for lines in windows if name in lines], axis=0) for name in named}
    return {name: value for name, value in means.items() if np.isfinite(value).all()}


def _left_out(
    kinematics: Kinematics,
    rotation: Rotation,
    time: np.ndarray,
    there: set[tuple[str, str]],
    windows: Mapping[str, tuple[float, float]],
) -> tuple[str, ...]:
    """Shafts without features and bearing parts without a level, with the reason and the window that is needed."""
    start, end = max(windows.values(), key=lambda window: window[1] - window[0])
    first, last = np.searchsorted(time, start), min(int(np.searchsorted(time, end)), len(time) - 1)
    turns = abs(float(rotation.angle[last] - rotation.angle[first])) / (2.0 * math.pi)
    words = []
    components = {component for component, _ in there}
    for shaft in kinematics.shafts:
        if shaft.name not in components:
            needed = (FEWEST_TURNS + 1) * (end - start) / max(turns * shaft.ratio, 1e-9)
            reason = f"{turns * shaft.ratio:.2g} turns in a window, {needed:.3g} s would be needed"
            if (uncertain := rotation.error * turns * shaft.ratio) > QUARTER:
                remedy = ", or set speed_rpm in place of speed if the speed can be found from the lines of the teeth"
                reason = (
                    f"its angle is known to {uncertain:.2g} turns, and averages need {QUARTER:g}: record a tachometer"
                    f"{remedy if kinematics.gears else ''}"
                )
            words.append(f"{_named(shaft.name, kinematics)}: {rotation.conditional.get(shaft.name, reason)}")
    seconds, rate = float(time[last] - time[first]), (len(time) - 1) / float(time[-1] - time[0])
    why = unresolved_passes(kinematics, turns * rotation.likely / seconds, seconds, rate, rotation.error)
    parts = [part for bearing in kinematics.bearings for part in bearing.strikes if (part, PASSING) not in there]
    return (*words, *(f"{part}: {why.get(part, 'too few of its lines are in the spectrum')}" for part in parts))


def _named(shaft: str, kinematics: Kinematics, bearings: bool = False) -> str:
    """A shaft with its gears, also with the parts of its `bearings`, as text."""
    on_it = [gear.name for gear in kinematics.gears_on(shaft)]
    on_it += [part for one in kinematics.bearings if bearings and one.shaft == shaft for part in one.strikes]
    return f"{shaft} ({', '.join(on_it)})" if on_it else shaft
