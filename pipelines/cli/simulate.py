"""`gearcase simulate`: the signals of a scene alone."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pipelines.cli.command_line import RUN_FOLDER, WORK, announce, scene_and_work

ARGUMENTS = (
    *WORK,
    RUN_FOLDER,
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Simulate the machine and write its signals to response.nc in a result folder, by default under ./runs. There
    is no healthy control, no diagnosis and no report. Takes seconds for the scene `minimal`, and up to minutes
    for the scenes `rig-...`.

    Example
    -------
    gearcase simulate minimal
    signals: runs/minimal/2026-11-25_00-50-21/response.nc
    """
    announce(options)
    from pipelines.runs.run import run_scene
    from pipelines.runs.run_folder import RESPONSE

    loaded, work = scene_and_work(options)
    finished = run_scene(loaded, out=options.out, with_control=False, with_report=False, work=work)
    yield f"signals: {finished.folder / RESPONSE}"
