"""The calibration of a scene: recordings, campaign, posterior, and agreement on the windows that were not used."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipelines.datasets.campaign import run_campaign
from pipelines.datasets.feature_tables import dataset_rows, stored_table
from pipelines.datasets.plan import Plan
from pipelines.datasets.rows import read_row
from pipelines.datasets.workers import local_workers
from pipelines.engine.progress import reported_count
from pipelines.engine.run_graph import Work
from pipelines.engine.storage import digest
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.machine.machine_model import MachineModel
from pipelines.machine.scene_kinematics import kinematics_of
from pipelines.recordings.machine_file import MeasuredMachine
from pipelines.runs.judged_recording import SAME_SPEED
from pipelines.runs.recorded_file import read_features, recording_and_window, requested_windows
from pipelines.scene.load_scene import LoadedScene
from pipelines.signals.features.feature_table import WHOLE
from pipelines.studies.calibrate.free_keys import AFTER, BEFORE, FEWEST, STATE, Free, agreement_plan, calibration_plan
from pipelines.studies.calibrate.posterior import emulator, sample
from pipelines.studies.spread.population_spread import MEAN, line_levels

_LOG = logging.getLogger(__name__)
IDENTIFIABLE = 1.0 / 3.0  # greatest width of the posterior over that of the prior
_SHARES = (0.05, 0.95)
_GROUPS = {"mesh orders and sidebands": "mesh_", "shaft orders": "order_", "all lines": ""}  # beginnings of features
Line = tuple[str, ...]  # sensor, axis, component, feature, unit
Levels = dict[Line, float]


@dataclass(frozen=True, eq=False, kw_only=True)
class Calibration:
    """Result of a calibration.

    `samples` (sample, key) of the posterior are in the units of the `free` keys. `agreement` has, by group of lines,
    the median absolute difference (dB) between recording and model before and after the calibration, in the second
    halves of the windows. `inside` of `lines` lines of the recording are within the range of the `runs` of the
    campaign.
    """

    name: str
    free: tuple[Free, ...]
    samples: np.ndarray
    agreement: Mapping[str, tuple[float, float]]
    inside: int
    lines: int
    runs: int

    @property
    def mean(self) -> np.ndarray:
        """Mean (key,) of the posterior."""
        return np.asarray(self.samples.mean(axis=0))

    @property
    def interval(self) -> np.ndarray:
        """Ends (2, key) of the 90 % intervals."""
        return np.asarray(np.quantile(self.samples, _SHARES, axis=0))

    @property
    def width(self) -> np.ndarray:
        """Width (key,) of the 90 % intervals over those of the priors."""
        ranges = np.array([one.high - one.low for one in self.free])
        return np.asarray(np.diff(self.interval, axis=0)[0] / (ranges * (_SHARES[1] - _SHARES[0])))

    @property
    def correlation(self) -> np.ndarray:
        """Correlations (key, key) of the posterior."""
        return np.atleast_2d(np.corrcoef(self.samples.T))


def calibrate(
    loaded: LoadedScene,
    machine: MachineModel,
    recorded: tuple[Levels, Levels],
    *,
    free: Sequence[Free],
    count: int,
    folder: Path,
    processes: int | None,
    building: Work,
    quiet: bool = True,
) -> Calibration:
    """Estimate free keys of a scene from recordings of one healthy machine at the speed and load of the scene.

    Parameters
    ----------
    loaded, machine : the scene and its machine model
    recorded : of `recorded_levels`
    free : the free keys
    count : number of runs of the campaign
    folder : of the results; a campaign in it is continued, and used again for other recordings
    processes : runs computed in parallel, all cores if None
    building : how laws and casing of the first run are built
    quiet : show no progress

    Raises
    ------
    InputError : a free key cannot be used, too few runs have features, or no feature of the
        recordings is in all of them
    SceneError, WorkError : see `pipelines.datasets.campaign.run_campaign`
    """
    plan = calibration_plan(loaded, machine, free, count)
    windows, (observed, unused) = _windows(machine), recorded
    noise = machine.monitored.noise

    def simulated(plan: Plan, place: Path, part: int) -> dict[int, Levels]:
        """Levels of the runs of a campaign in a half of the windows."""
        run_campaign(plan, place, local_workers(processes), building, quiet=quiet)
        with local_workers(processes) as workers, reported_count("runs", quiet=quiet) as report:
            rows = list(dataset_rows(place, _halves(windows, part), noise, workers.executor, report))
        return {row["run"]: line_levels(table) for row in rows if (table := stored_table(row["table"])) is not None}

    campaign = folder / "campaign"
    found = simulated(plan, campaign, 0)
    if len(found) < FEWEST:
        raise InputError(f"{len(found)} runs have features, {FEWEST} are needed. Increase --runs, or narrow --free.")
    lines = [one for one in observed if all(one in levels for levels in found.values())]
    if not lines:
        raise InputError("no feature of the recordings is in all simulated runs. Set longer windows, or narrow --free.")
    levels = np.array([[one[line] for line in lines] for one in found.values()])
    given = np.array([observed[line] for line in lines])
    values = [read_row(campaign, run)["values"] for run in found]
    low, high = (np.array([getattr(one, end) for one in free]) for end in ("low", "high"))
    points = np.array([[row[one.variable] for one in free] for row in values])
    emulated = emulator((points - low) / (high - low), levels)
    samples = low + (high - low) * sample(emulated, emulated.summaries(given[None])[0])
    after = {one.key: float(value) for one, value in zip(free, samples.mean(axis=0), strict=True)}
    checks = agreement_plan(loaded, machine, after)
    place = folder / f"agreement-{digest(checks.text)[:8]}"
    models = simulated(checks, place, 1)
    states = {run: read_row(place, run)["values"][STATE] for run in models}
    return Calibration(
        name=loaded.name,
        free=tuple(free),
        samples=samples,
        agreement=_agreement(unused, models, states),
        inside=int(np.sum((given >= levels.min(axis=0)) & (given <= levels.max(axis=0)))),
        lines=len(lines),
        runs=len(found),
    )


def recorded_levels(
    machine: MachineModel, measured: MeasuredMachine, sources: Sequence[str | Path]
) -> tuple[Levels, Levels]:
    """Levels in the first and in the second halves of the windows; logs a warning for another speed than the scene's.

    Parameters
    ----------
    machine : machine model of the scene
    measured : the machine of the recordings
    sources : recordings or runs, also with a window; by default the windows of the scene

    Raises
    ------
    InputError : a recording cannot be used, or the scene has none of its channels and components
    """
    windows = _windows(machine)
    first, second = (_recorded(sources, measured, windows, part, _turns(machine)) for part in (0, 1))
    kinematics = kinematics_of(machine.layout, machine.rolling)
    channels = {(sensor.name, axis) for sensor in machine.sensors for axis in "xyz"}
    parts = [one.name for group in (kinematics.shafts, kinematics.gears) for one in group]
    parts += [f"{bearing.name} {label}" for bearing in kinematics.bearings for label in bearing.orders]
    if not any(line[:2] in channels and line[2] in (WHOLE, *parts) for line in first):
        own = ", ".join(sorted({" ".join(line[:2]) for line in first}))
        raise InputError(
            f"the recordings and the scene have no feature in common. The recordings have the channels {own}, the "
            f"scene {', '.join(' '.join(one) for one in sorted(channels)) or 'none'}. Give the sensors of the scene "
            "the names and axes of the recordings, or give --machine FILE with sensors of these names."
        )
    return first, second


def _turns(machine: MachineModel) -> float | None:
    """Mean speed (1/s) of the first shaft of the scene in its first window; None if it follows from the motion."""
    if not machine.monitored.speed_is_known or machine.parts.profile is None:
        return None
    start, end = next(iter(_windows(machine).values()))
    speed = machine.parts.profile.speed(np.linspace(start, end, 1000)).mean() * machine.layout.shaft_ratios[0]
    return abs(float(speed)) / (2.0 * np.pi)


def _windows(machine: MachineModel) -> dict[str, tuple[float, float]]:
    return dict(machine.monitored.windows) or {"whole": (0.0, machine.motion.end)}


def _halves(windows: Mapping[str, tuple[float, float]], part: int) -> dict[str, tuple[float, float]]:
    """The first (0) or second (1) half of each window."""
    return {
        name: (start + 0.5 * part * (end - start), end - 0.5 * (1 - part) * (end - start))
        for name, (start, end) in windows.items()
    }


def _recorded(
    sources: Sequence[str | Path],
    measured: MeasuredMachine,
    windows: Mapping[str, tuple[float, float]],
    part: int,
    turns: float | None,
) -> Levels:
    """Levels of the lines that all recordings have, in a half of the windows, mean over the recordings.

    `turns` (1/s) is the speed of the first shaft in the scene.
    """
    found = []
    for source in sources:
        path, asked = recording_and_window(source)
        chosen = requested_windows(source, asked, windows) or {}
        table = read_features(path, measured, _halves(chosen, part), 0.0).table
        if part == 0 and turns and abs(table.speed[0] / turns - 1.0) > SAME_SPEED:
            _LOG.warning(
                "%s: shaft 1 turns at %.5g rpm, in the scene at %.5g rpm. Levels depend on the speed, so the posterior "
                "may be wrong. Set drive.speeds_rpm to the speed of the recording",
                shown(source), 60.0 * table.speed[0], 60.0 * turns,
            )  # fmt: skip
        found.append(
            {line: value for line, value in line_levels(table).items() if line[0] != MEAN and line[-1] == "dB"}
        )
    return {line: float(np.mean([one[line] for one in found])) for line in found[0] if all(line in o for o in found)}


def _agreement(
    recorded: Levels, models: Mapping[int, Levels], states: Mapping[int, str]
) -> dict[str, tuple[float, float]]:
    """By group: median over the lines of the difference between the recording and the mean of the models, dB."""
    lines = [line for line in recorded if all(line in one for one in models.values())]
    differences = {
        state: np.array(
            [
                abs(np.mean([one[line] for run, one in models.items() if states[run] == state]) - recorded[line])
                for line in lines
            ]
        )
        for state in (BEFORE, AFTER)
    }
    found = {}
    for name, beginning in _GROUPS.items():
        chosen = [line[3].startswith(beginning) for line in lines]
        if any(chosen):
            found[name] = (float(np.median(differences[BEFORE][chosen])), float(np.median(differences[AFTER][chosen])))
    return found
