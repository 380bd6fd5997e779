"""`gearcase diagnose`: the lines of a fault in a finished run, looked for anew."""

from __future__ import annotations

import argparse
import contextlib
import sys


def main(options: argparse.Namespace) -> int:
    """Print verdict and envelope tables; --set diagnosis.... looks elsewhere without running anything."""
    from pipelines import results
    from pipelines.building.diagnosing import CaseSpec, diagnoses, words
    from pipelines.errors import InputError
    from pipelines.looked_for import diagnosis_settings
    from pipelines.scene_file import load_scene

    folder = results.find_run(options.run)
    scene = load_scene(folder / results.RESOLVED, options.settings).scene
    settings = diagnosis_settings(scene)
    if settings is None:
        raise InputError(
            f"{folder}: the scene gives no diagnosis.windows_s or no sensors; there is nothing to look at."
        )
    if not (folder / results.CONTROL).is_file():
        raise InputError(
            f"{folder}: no healthy control was run, so no line can be told from those of a healthy gearbox. "
            "Name a control in the scene and run it again."
        )
    with contextlib.ExitStack() as opened:
        runs = [
            opened.enter_context(results.opened_run(folder / name)).assign_attrs(
                sensor_noise_m_s2=scene.diagnosis.noise_m_s2
            )
            for name in (results.RESPONSE, results.CONTROL)
        ]
        found = diagnoses([CaseSpec(settings=settings, full=True)], runs)
    sys.stdout.write(words(found, found))
    return 0
