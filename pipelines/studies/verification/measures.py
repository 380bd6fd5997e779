"""Measures of the claims of the study, in dB, from pairs of runs that differ in one condition.

Of a faulty run and its healthy control, in a window of constant speed, on the channel of the diagnosis with its noise:

sidebands_1, sidebands_2      eight sidebands n f_m + k f_r, k = -4..4, root sum square, dB re 1 m/s2
modulation_1, modulation_2    the same over the mesh line n f_m
envelope                      five harmonics of f_r in the envelope of f_m/2 to 3 f_m/2, root sum square, dB re 1 m/s2
envelope_1_to_2_kHz           the same in the envelope of 1 to 2 kHz, above the mesh lines that carry most energy
tsa_peak                      range of the time-synchronous average over the turns of the faulty shaft, dB re 1 m/s2
under_limit                   10 dB less the median of the 21 lines of envelope and sidebands over their local floor

Of the same machine with the load on its rope and as a constant torque, without noise, in any stretch of time:

level             root mean square of the acceleration with the rope over that with the torque
difference        root mean square of the difference of both over that with the torque
mesh_force        largest force in the mesh of the first stage with the rope over that with the torque

References
----------
McFadden (1986), J. Vib. Acoust. 108(2), 165-170 (sidebands, envelope); McFadden (1987), Mech. Syst. Signal Process.
1(1), 83-95 (time-synchronous average).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pipelines.diagnosis.control_diagnosis import STATES, diagnose
from pipelines.diagnosis.line_words import modulation
from pipelines.signals.analysis import DiagnosisSettings, channel, noisy_signal
from pipelines.signals.features.statistics import root_mean_square
from pipelines.signals.line_table import LineTable
from pipelines.signals.orders.revolutions import revolutions
from pipelines.signals.orders.rotation import Rotation

if TYPE_CHECKING:
    import xarray

HIGH_BAND = (1000.0, 2000.0)  # Hz
PLACES = 2048  # in a turn of the faulty shaft, which has 1833 samples
STREAM = {"healthy": 0, "faulty": 1}  # of the noise, as in `pipelines.diagnosis.control_diagnosis.diagnose`

Levels = dict[str, float]


def fault_levels(
    faulty: xarray.Dataset, healthy: xarray.Dataset, settings: DiagnosisSettings
) -> dict[tuple[str, str], Levels]:
    """Measures of both runs by (state, window), dB.

    Parameters
    ----------
    faulty, healthy : runs that differ in the fault alone, see `pipelines.diagnosis.control_diagnosis.diagnose`
    settings : channel, windows and lines; one axis; `shaft` is that of the faulty gear

    Raises
    ------
    DiagnosisError, SpectrumError : as `pipelines.diagnosis.control_diagnosis.diagnose`
    """
    lines = diagnose(faulty, healthy, settings).lines
    high = diagnose(faulty, healthy, replace(settings, band=HIGH_BAND)).lines
    found = {}
    for state, run in zip(STATES, (faulty, healthy), strict=True):
        for name, window in settings.windows.items():
            levels = _line_levels(lines.where(window=name), state, settings.floor_limit)
            levels["envelope_1_to_2_kHz"] = _sum(high.where(window=name, kind="envelope"), state)
            levels["tsa_peak"] = _average_peak(run, settings, state, window)
            found[state, name] = levels
    return found


def load_levels(
    rope: xarray.Dataset, torque: xarray.Dataset, sensor: str, axis: str, times: tuple[float, float]
) -> Levels:
    """Measures of two runs that differ in the load alone, dB.

    Parameters
    ----------
    rope, torque : the runs
    sensor, axis : whose acceleration is compared
    times : start and end of a stretch, s
    """
    cut = [run.sel(time=slice(*times)) for run in (rope, torque)]
    signals = [channel(run, sensor).sel(axis=axis).values.astype(float) for run in cut]
    force = [float(np.abs(run.mesh_force.isel(stage=0).values).max()) for run in cut]
    with_rope, with_torque = (float(signal.std()) for signal in signals)
    difference = float(root_mean_square(signals[0] - signals[1]))
    return {
        "level": decibel(with_rope, with_torque),
        "difference": decibel(difference, with_torque),
        "mesh_force": decibel(force[0], force[1]),
    }


def decibel(value: float, reference: float = 1.0) -> float:
    """20 log10 of a ratio of amplitudes; 0 is replaced by the smallest number."""
    tiny = np.finfo(float).tiny
    return float(20.0 * np.log10(max(value, tiny) / max(reference, tiny)))


def _line_levels(lines: LineTable, state: str, limit: float) -> Levels:
    floors = lines.of("envelope", "sideband")
    over = floors.over_floor if state == "faulty" else floors.healthy_over_floor
    levels = {"envelope": _sum(lines.where(kind="envelope"), state), "under_limit": limit - float(np.median(over))}
    for n in (1, 2):
        levels[f"sidebands_{n}"] = _sum(lines.where(kind="sideband", mesh_harmonic=n), state)
        levels[f"modulation_{n}"] = modulation(lines, state, n)
    return levels


def _sum(lines: LineTable, state: str) -> float:
    return decibel(float(np.linalg.norm(getattr(lines, state))))


def _average_peak(run: xarray.Dataset, settings: DiagnosisSettings, state: str, window: tuple[float, float]) -> float:
    """Range of the average over the turns of the faulty shaft, dB."""
    angle = run.shaft_angle.sel(shaft=settings.shaft).values.astype(float)
    rotation = Rotation(angle=angle, source="recorded angle", error=0.0, absolute=True)
    signal = noisy_signal(run, settings, STREAM[state])[:, 0]
    turns = revolutions(signal, run.time.values, rotation, 1.0, PLACES, window)
    return decibel(float(np.ptp(turns.mean(axis=0))))
