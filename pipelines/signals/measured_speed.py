"""Monitored lines at the measured speed of the shafts, for machines that are driven by torques.

The speed of such a machine is known only after its run. The lines are placed at the mean speed of the shaft of the
monitored gear over all windows of both runs, from the recorded angle. A line of order n stays on its bin if the angle
deviates from uniform rotation by at most a quarter of the period of the line, pi/(2 n). The highest monitored order
gives the limit. It bounds both a drift within a window and a difference between windows or runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from pipelines.signals.analysis import DiagnosisError, DiagnosisSettings

if TYPE_CHECKING:
    import xarray

QUARTER_PERIOD = math.pi / 2  # rad, phase of the highest line


def at_measured_speed(settings: DiagnosisSettings, runs: Sequence[xarray.Dataset]) -> DiagnosisSettings:
    """The settings with the frequencies of all lines of shafts scaled to the mean speed in the windows of the runs.

    Raises
    ------
    DiagnosisError : the angle of the shaft is not recorded, the shaft does not turn, or its speed varies too much for
        the highest line
    """
    pieces = list(_pieces(settings, runs))
    speed = float(np.mean([own for *_, own in pieces]))
    if speed == 0.0:
        raise DiagnosisError(
            f"{settings.shaft} does not turn in the windows of the diagnosis. Set windows in which it turns."
        )
    highest = settings.highest_line / settings.revolution_frequency
    limit = QUARTER_PERIOD / highest
    for window, time, angle, own in pieces:
        deviation = angle - speed * time
        most = float(np.ptp(deviation)) / 2
        if most > limit:
            raise DiagnosisError(
                f"window {window!r}: {settings.shaft} turns at {own / (2 * math.pi):.5g} Hz in the mean "
                f"and its angle deviates by up to {most:.3g} rad from an even rotation at {speed / (2 * math.pi):.5g} "
                "Hz, the mean of all windows and both runs. The highest line, of the order "
                f"{highest:.4g}, allows {limit:.3g} rad. "
                "Choose a later or shorter window, in which the speed has settled."
            )
    factor = speed / (2 * math.pi) / settings.revolution_frequency
    return replace(
        settings,
        speed_is_known=True,
        revolution_frequency=factor * settings.revolution_frequency,
        mesh_frequency=factor * settings.mesh_frequency,
        bearings={name: factor * value for name, value in settings.bearings.items()},
        passes=tuple(
            replace(lines, frequency=factor * lines.frequency, spacing=factor * lines.spacing)
            for lines in settings.passes
        ),
        turning=tuple(replace(lines, frequency=factor * lines.frequency) for lines in settings.turning),
    )


def _pieces(
    settings: DiagnosisSettings, runs: Sequence[xarray.Dataset]
) -> Iterator[tuple[str, np.ndarray, np.ndarray, float]]:
    """Every window with times (s), angle (rad) of the shaft in its sense of rotation and its mean speed (rad/s)."""
    for run in runs:
        if "shaft_angle" not in run or settings.shaft not in run.shaft.values:
            raise DiagnosisError(
                f"the angle of {settings.shaft} is not recorded, so that its speed is not known. Repeat the run"
            )
        angle = run.shaft_angle.sel(shaft=settings.shaft)
        for name, (start, end) in settings.windows.items():
            inside = angle.sel(time=slice(start, end))
            time, turned = (np.asarray(x, dtype=float) for x in (inside.time.values, inside.values))
            if len(time) < 2:
                raise DiagnosisError(f"window {name!r}: fewer than two samples. Choose a window inside the record.")
            speed = float(np.polyfit(time - time.mean(), turned, 1)[0])
            yield name, time, turned if speed >= 0.0 else -turned, abs(speed)
