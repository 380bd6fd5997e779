"""Checks of the windows of a diagnosis that need no computation."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mbd.integrators.settings import HIGHEST_RATE
from mbd.parts.speed_drive import SpeedProfile
from pipelines.io.errors import Problem
from pipelines.machine.machine_model import Drivetrain
from pipelines.scene.scene import Scene
from pipelines.scene.tables.torques import RPM
from pipelines.signals.analysis import SPEED_TOLERANCE, DiagnosisError, DiagnosisSettings, envelope_band
from pipelines.signals.spectrum import FEWEST_REVOLUTIONS, Segment, SpectrumError, whole_revolutions

_NO_WINDOWS = "diagnosis.windows_s={} for signals without diagnosis"


def bad_windows(scene: Scene, machine: Drivetrain) -> Iterator[Problem]:
    """Reasons why the diagnosis of a scene is not possible; empty without windows."""
    if not scene.diagnosis.windows_s or not scene.sensors:
        return
    layout, known = machine.layout, scene.drive.speed_is_known
    if layout.turns == 0.0 and not known:
        yield Problem(
            "diagnosis.windows_s",
            "a diagnosis needs the approximate speed of the machine, and the drive states only the speed 0",
            "Set drive.highest_rpm, or windows_s = {} for signals without diagnosis",
        )
        return
    if layout.turns == 0.0:
        yield Problem(
            "drive.speeds_rpm", "all speeds are 0, so that there is nothing to diagnose", "Set a speed above 0"
        )
        return
    rate, drive, settings = scene.simulation.output_rate_Hz, machine.parts.profile, machine.diagnosis
    assert settings is not None, "there are windows and sensors"
    profile = SpeedProfile(times=drive.times, speeds=drive.speeds / RPM, smooth=drive.smooth)
    for name, window in settings.windows.items():
        try:
            segment = whole_revolutions(window, rate, settings.revolution_frequency)
        except SpectrumError:
            segment = None
        yield from _short_window(scene, settings, name, segment)
        if known:
            yield from _uneven_window(scene, profile, name, window, segment)
    highest = settings.highest_line
    if highest >= rate / 2:
        enough = math.ceil(4 * highest)
        lower = f"Reduce drive.speeds_rpm: {enough} would be needed, {HIGHEST_RATE:g} is possible"
        yield Problem(
            "simulation.output_rate_Hz",
            f"the diagnosis of stage {scene.diagnosis.stage} needs lines up to {highest:.4g} Hz "
            f"({max(settings.mesh_harmonics)} f_m and {settings.sideband_orders} sidebands), above half of the rate, "
            f"{rate / 2:.4g} Hz",
            f"Set {enough} or more, 4 times the highest line" if enough <= HIGHEST_RATE else lower,
            f"{rate:g}",
        )
    try:
        envelope_band(settings, [], rate)
    except DiagnosisError as error:
        yield Problem("diagnosis.envelope_band_Hz", str(error), "", '"resonance"')


def _short_window(scene: Scene, settings: DiagnosisSettings, name: str, segment: Segment | None) -> Iterator[Problem]:
    frequency, window = settings.revolution_frequency, settings.windows[name]
    revolutions = 0 if segment is None else segment.revolutions
    if revolutions >= FEWEST_REVOLUTIONS:
        return
    held = (window[1] - window[0]) * frequency
    cut = f", of which only {revolutions} fill a whole number of samples" if int(held) > revolutions else ""
    yield Problem(
        f"diagnosis.windows_s.{name}",
        f"has {held:.1f} revolutions of {_gear(scene)}{cut}; the diagnosis needs {FEWEST_REVOLUTIONS}",
        f"Set a window of {(FEWEST_REVOLUTIONS + bool(cut)) / frequency:.2f} s or more, or run with --set "
        f"{_NO_WINDOWS}. To replace a window inherited by extends, set one of the same name",
        f"[{window[0]:g}, {window[1]:g}]",
    )


def _uneven_window(
    scene: Scene, profile: SpeedProfile, name: str, window: tuple[float, float], segment: Segment | None
) -> Iterator[Problem]:
    start, end = window if segment is None else (segment.start, segment.start + segment.duration)
    mean = abs(float(np.diff(profile.angle(np.array([start, end])))[0])) / (end - start)
    if abs(mean / profile.highest - 1) > SPEED_TOLERANCE:
        yield Problem(
            f"diagnosis.windows_s.{name}",
            f"the mean speed of the motors in this window is {mean:.4g} rpm. The diagnosis of {_gear(scene)} needs the "
            f"highest speed, {profile.highest:.4g} rpm within {100 * SPEED_TOLERANCE:g} %",
            f"{_steady(scene, profile)}. Or run with --set {_NO_WINDOWS}",
            f"[{window[0]:g}, {window[1]:g}]",
        )


def _gear(scene: Scene) -> str:
    return f"the stage {scene.diagnosis.stage} {scene.diagnosis.gear}"


def _steady(scene: Scene, profile: SpeedProfile) -> str:
    """Remedy: the intervals of time in which the drive has its highest speed, or how to get one."""
    ends = [*profile.times.tolist(), max(scene.simulation.end_s, float(profile.times[-1]))]
    speeds = [*profile.speeds.tolist(), float(profile.speeds[-1])]
    found = [
        f"{ends[i]:g} to {min(ends[i + 1], scene.simulation.end_s):g} s"
        for i in range(len(speeds) - 1)
        if abs(speeds[i]) == profile.highest
        and speeds[i] == speeds[i + 1]
        and ends[i] < min(ends[i + 1], scene.simulation.end_s)
    ]
    return (
        f"Set a window at constant highest speed: {', '.join(found)}"
        if found
        else "Hold the highest speed by two equal values of drive.speeds_rpm, and set a window between their times"
    )
