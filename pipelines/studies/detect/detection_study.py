"""The study of detectability: features of the runs of its campaign, and the detection of the damaged ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipelines.datasets.campaign_scenes import scene_of
from pipelines.datasets.feature_tables import dataset_rows, stored_table
from pipelines.datasets.plan import Plan
from pipelines.datasets.rows import DONE, read_rows
from pipelines.diagnosis.deviation_statistics import FEWEST_FOR_P
from pipelines.io.errors import InputError
from pipelines.machine.machine_conversion import make_drivetrain
from pipelines.machine.scene_kinematics import kinematics_of
from pipelines.signals.features.feature_table import FeatureTable, left_out_words
from pipelines.signals.orders.kinematics import Kinematics
from pipelines.steps.verdict import known_damages
from pipelines.studies.detect.channel_detectability import DetectionChannel, channels
from pipelines.studies.detect.detection_campaign import HEALTHY, SPECIMEN, STATE, Design
from pipelines.studies.detect.probability import Damage, Detection, Machines, detection

Values = tuple[Any, ...]  # of the varied keys, in their order


@dataclass(frozen=True, kw_only=True)
class DetectionPoint:
    """Detection for one combination of `values`, by key of the scene, at one noise (m/s2 rms)."""

    values: Mapping[str, Any]
    noise: float
    detection: Detection


@dataclass(frozen=True, kw_only=True)
class Detectability:
    """Result of a study: `points` for each noise, and all `channels` alone at the first noise, the best one first.

    `shared` are the varied keys that also change the healthy machines.
    """

    name: str
    damage: str
    design: Design
    shared: tuple[str, ...]
    noises: tuple[float, ...]
    points: tuple[DetectionPoint, ...]
    channels: tuple[DetectionChannel, ...]


def study(
    plan: Plan,
    folder: Path,
    design: Design,
    windows: Mapping[str, tuple[float, float]],
    noises: Sequence[float],
    executor: Executor,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> Detectability:
    """Compute the features of all runs of a campaign and detect the damaged machines.

    Parameters
    ----------
    plan, folder : plan by `pipelines.studies.detect.detection_campaign.detection_plan`, and folder of the campaign
    design : of that plan
    windows : start and end (s) of each diagnosed window by name; the whole run if empty
    noises : rms of the added sensor noise, m/s2
    executor : of the work
    on_progress : callback with the number of finished runs and that of all, for each noise

    Raises
    ------
    InputError : too few runs were simulated, or the damaged component has no features
    """
    varied = [over.variable for over in design.over]
    # keys that also change the healthy machines: all that do not belong to the fault
    of_all = [over for over in design.over if over.first_key not in plan.table.cases[STATE][HEALTHY]]
    shared = [over.variable for over in of_all]
    runs = [row for row in read_rows(folder) if row["status"] == DONE]
    healthy = [row for row in runs if row["values"][STATE] == HEALTHY]
    damaged = [row for row in runs if row["values"][STATE] != HEALTHY]
    points = dict.fromkeys(_values(row, varied) for row in damaged)
    if not points:
        raise InputError(
            "all damaged machines failed, see the column reason of rows.parquet. Correct the scene or --over."
        )
    known: dict[Values, Kinematics] = {}
    damages: dict[int, list[Damage]] = {}
    for row in damaged:
        train = make_drivetrain(scene_of(plan, row["values"]).scene, plan.name)
        damages[row["run"]] = [(one.component, one.tooth) for one in known_damages(train)]
        known.setdefault(_values(row, shared), kinematics_of(train.layout, train.rolling))
    found = []
    first: list[Machines] = []
    for noise in noises:
        place = f"feature_tables/{noise:g}"
        rows = [*dataset_rows(folder, windows, noise, executor, on_progress, rows=place, complete=False)]
        here = {row["run"]: table for row in rows if (table := stored_table(row["table"])) is not None}
        if not here:
            raise InputError(f"no run has features. The first: {rows[0]['failure']}")
        for values in points:
            own = [row for row in damaged if _values(row, varied) == values]
            common = _values(own[0], shared)
            others = [row for row in healthy if _values(row, shared) == common and row["run"] in here]
            machines = Machines(
                kinematics=known[common],
                baseline=_baseline(others, here, design),
                healthy=[here[row["run"]] for row in others if row["values"][SPECIMEN] > design.baseline],
                damaged=[(here[row["run"]], damages[row["run"]]) for row in own if row["run"] in here],
            )
            _check_seen(machines)
            named = dict(zip((over.key for over in design.over), values, strict=True))
            found.append(DetectionPoint(values=named, noise=noise, detection=detection(machines)))
            if noise == noises[0]:
                first.append(machines)
    return Detectability(
        name=plan.name,
        damage=plan.table.title.partition(": ")[2],
        design=design,
        shared=tuple(over.key for over in of_all),
        noises=tuple(noises),
        points=tuple(found),
        channels=channels(first),
    )


def _values(row: Mapping[str, Any], variables: Sequence[str]) -> Values:
    return tuple(row["values"][name] for name in variables)


def _baseline(
    healthy: Sequence[Mapping[str, Any]], tables: Mapping[int, FeatureTable], design: Design
) -> list[FeatureTable]:
    """The features of the healthy machines with which the damaged ones are compared, from the rows of their runs."""
    baseline = [tables[row["run"]] for row in healthy if row["values"][SPECIMEN] <= design.baseline]
    if len(baseline) < FEWEST_FOR_P:
        raise InputError(
            f"{len(baseline)} healthy machines of the baseline have features; p-values need {FEWEST_FOR_P} or more. "
            "The column reason of rows.parquet gives the cause. Increase --baseline, or correct the scene."
        )
    return baseline


def _check_seen(machines: Machines) -> None:
    """Raise InputError if the damaged component makes too few revolutions for features."""
    table = machines.baseline[0]
    damaged = list(dict.fromkeys(component for _, damage in machines.damaged for component, _ in damage))
    if not set(damaged) & set(table.component):
        left_out = [one for one in table.left_out if any(name in one.partition(": ")[0] for name in damaged)]
        raise InputError(
            f"{', '.join(damaged)}: no features in these runs. {left_out_words(left_out)} Increase simulation.end_s."
        )
