"""Diagnosis of a finished run from its files: fault lines with their error bars, and the verdict."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipelines.engine.step import Step
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.runs import run_folder

if TYPE_CHECKING:
    import xarray

    from pipelines.diagnosis.control_diagnosis import Diagnosis
    from pipelines.diagnosis.uncertainty.bar_records import LineBars
    from pipelines.engine.run_graph import Work
    from pipelines.scene.load_scene import Settings


def diagnose_folder(folder: Path, settings: Settings = ()) -> Diagnosis:
    """Compare the fault lines of a run with its control; settings as ``diagnosis.axis=z`` override the scene.

    Raises
    ------
    InputError : the scene has no diagnosis, or the run has no control
    """
    from pipelines.machine.machine_conversion import make_drivetrain
    from pipelines.scene.load_scene import load_scene
    from pipelines.steps.diagnosing import CaseSpec, diagnoses

    settings = settings if isinstance(settings, Mapping) else list(settings)
    for text in settings:
        key = text.partition("=")[0].strip()
        if key.partition(".")[0] != "diagnosis":
            raise InputError(
                f"{shown(key)}: a finished run cannot be changed by this key. Set keys of [diagnosis] only, or "
                "simulate again with gearcase run."
            )
    loaded = load_scene(folder / run_folder.RESOLVED, settings)
    train = make_drivetrain(loaded.scene, loaded.source.shown)  # needs no housing file, which may have been removed
    diagnosis = train.diagnosis
    if diagnosis is None:
        raise InputError(
            f"{folder}: the scene has no diagnosis.windows_s or no sensors, so there is nothing to diagnose. "
            "Set them and repeat gearcase run."
        )
    if not (folder / run_folder.CONTROL).is_file():
        raise InputError(
            f"{folder}: there is no healthy control to compare the lines with. "
            'Set control = "without-faults" and a fault in the scene, and repeat gearcase run; or diagnose it without '
            "a control: give a window, as in --window 0.5 2.5, or healthy runs as --baseline."
        )
    with _pair(folder, train.monitored.noise) as runs:
        return diagnoses([CaseSpec(settings=diagnosis, full=True)], runs)[0]


@contextlib.contextmanager
def _pair(folder: Path, noise: float) -> Iterator[list[xarray.Dataset]]:
    """The response and the control of a run, with the stated sensor noise (m/s2)."""
    with contextlib.ExitStack() as opened:
        yield [
            opened.enter_context(run_folder.opened_run(folder / name)).assign_attrs(sensor_noise_m_s2=noise)
            for name in (run_folder.RESPONSE, run_folder.CONTROL)
        ]


def judge_folder(folder: Path) -> dict[str, Any]:
    """The verdict on a run against its control, as the step `verdict` returns it.

    Parameters
    ----------
    folder : of a run that `diagnose_folder` can read
    """
    from pipelines.diagnosis.control_diagnosis import deviation_name
    from pipelines.diagnosis.deviation_statistics import FEWEST_FOR_P
    from pipelines.diagnosis.simulated_features import FeatureSettings
    from pipelines.machine.machine_conversion import make_drivetrain
    from pipelines.machine.scene_kinematics import kinematics_of
    from pipelines.scene.load_scene import load_scene
    from pipelines.steps import features, verdict

    loaded = load_scene(folder / run_folder.RESOLVED)
    train = make_drivetrain(loaded.scene, loaded.source.shown)
    kinematics = kinematics_of(train.layout, train.rolling)
    settings = FeatureSettings(kinematics=kinematics, windows=train.monitored.windows)
    with _pair(folder, train.monitored.noise) as (own, control):
        found = [features.of_response(own, settings, 1)], [features.of_response(control, settings, FEWEST_FOR_P)]
    return verdict.build(
        kinematics,
        verdict.known_damages(train),
        ((str(train.labels["load"]), deviation_name(train.labels)),),
        exact=True,
        own=found[0],
        healthy=found[1],
    )


def folder_bars(folder: Path, diagnosis: Diagnosis, settings: Settings, work: Work) -> LineBars | str:
    """Error bars of the diagnosis of a finished run, or why there are none; steps of its casing come from the cache.

    Parameters
    ----------
    folder : of the run
    diagnosis : result of `diagnose_folder` with the same settings
    settings : those of the diagnosis; changes of the machine are ignored
    work : executor that builds the casing again if it is not in the cache

    Raises
    ------
    SceneError, WorkError : the scene is not valid any more, or a step failed
    """
    from pipelines.runs.single_results import scene_graph
    from pipelines.scene.load_scene import load_scene
    from pipelines.steps.error_bars import machine_bars
    from pipelines.steps.result_steps import casing_taken

    graph, machine = scene_graph(load_scene(folder / run_folder.RESOLVED))  # without `settings`: casing of the run
    changed = load_scene(folder / run_folder.RESOLVED, settings).scene.diagnosis
    machine = replace(machine, monitored=replace(machine.monitored, damping_spread=changed.damping_spread))
    taken = {"laws": machine.law_names, **casing_taken(graph)}
    step = Step(name="error bars", kind="error-bars", build=machine_bars, takes=taken)
    outcome = work.build(graph, step.inputs)
    with run_folder.opened_run(folder / run_folder.RESPONSE) as run:
        return machine_bars(machine, run, diagnosis, **step.received(outcome.value))
