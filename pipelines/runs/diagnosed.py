"""The lines of a fault in a finished run, looked for anew in its files."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.border.errors import InputError
from pipelines.runs import run_folder

if TYPE_CHECKING:
    from pipelines.scene.file import Settings
    from pipelines.signals.diagnosis import Diagnosis


def diagnose_folder(folder: Path, settings: Settings = ()) -> Diagnosis:
    """The run of a result folder against its control; settings as in ``diagnosis.sensor=sensor_5`` look elsewhere.

    Raises
    ------
    InputError : the scene names nothing to look at, or no control was run
    """
    from pipelines.plant.plant import make_drivetrain
    from pipelines.scene.file import load_scene
    from pipelines.steps.diagnosing import CaseSpec, diagnoses

    loaded = load_scene(folder / run_folder.RESOLVED, settings)
    train = make_drivetrain(loaded.scene, loaded.source.shown)  # the file of a housing may be gone
    wanted = train.diagnosis
    if wanted is None:
        raise InputError(
            f"{folder}: the scene has no diagnosis.windows_s or no sensors, so there is nothing to diagnose. "
            "Set them and repeat gearcase run."
        )
    if not (folder / run_folder.CONTROL).is_file():
        raise InputError(
            f"{folder}: there is no healthy control to compare the lines with. "
            'Set control = "without-faults" in the scene and repeat gearcase run.'
        )
    with contextlib.ExitStack() as opened:
        runs = [
            opened.enter_context(run_folder.opened_run(folder / name)).assign_attrs(
                sensor_noise_m_s2=train.looked_for.noise
            )
            for name in (run_folder.RESPONSE, run_folder.CONTROL)
        ]
        return diagnoses([CaseSpec(settings=wanted, full=True)], runs)[0]
