"""`gearcase diagnose`: the lines of a fault in a finished run, looked for anew."""

from __future__ import annotations

import argparse
import contextlib
import sys


def main(options: argparse.Namespace) -> int:
    """Print verdict and envelope tables; --set diagnosis.... looks elsewhere without running anything."""
    from pipelines.border.errors import InputError
    from pipelines.plant.plant import make_drivetrain
    from pipelines.runs import run_folder
    from pipelines.scene.file import load_scene
    from pipelines.steps.diagnosing import CaseSpec, diagnoses, words

    folder = run_folder.find_run(options.run)
    loaded = load_scene(folder / run_folder.RESOLVED, options.settings)
    train = make_drivetrain(loaded.scene, loaded.source.shown)  # the file of a housing may be gone
    settings = train.diagnosis
    if settings is None:
        raise InputError(
            f"{folder}: the scene gives no diagnosis.windows_s or no sensors; there is nothing to look at."
        )
    if not (folder / run_folder.CONTROL).is_file():
        raise InputError(
            f"{folder}: no healthy control was run, so no line can be told from those of a healthy gearbox. "
            "Name a control in the scene and run it again."
        )
    with contextlib.ExitStack() as opened:
        runs = [
            opened.enter_context(run_folder.opened_run(folder / name)).assign_attrs(
                sensor_noise_m_s2=train.looked_for.noise
            )
            for name in (run_folder.RESPONSE, run_folder.CONTROL)
        ]
        found = diagnoses([CaseSpec(settings=settings, full=True)], runs)
    sys.stdout.write(words(found, found))
    return 0
