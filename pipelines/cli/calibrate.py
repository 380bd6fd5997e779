"""`gearcase calibrate`: estimate free keys of a scene from recordings of a healthy machine."""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterator
from pathlib import Path

from pipelines.cli.command_line import MACHINE, SCENE, argument, campaign_arguments, work_of
from pipelines.io.argument_types import count, path

ARGUMENTS = (
    *SCENE,
    argument(
        "recordings",
        metavar="RECORDING",
        type=path,
        nargs="+",
        help="recording or run, also with a window, as in bench@0.5:2.5 (default: windows of the scene)",
    ),
    MACHINE,
    argument(
        "--free",
        metavar="KEY=LOW..HIGH",
        action="append",
        default=[],
        help="key of the scene with the range of its uniform prior; repeatable",
    ),
    argument("--runs", metavar="N", type=count, default=200, help="simulated machines (default 200)"),
    *campaign_arguments("calibrate"),
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Estimate free keys of a scene from recordings of one healthy machine, at the speed and load of the scene. Print
    mean, 90 % interval and correlations of the posterior, the keys that cannot be identified, and how well simulated
    and recorded levels agree before and after calibration. Needs the extra gearcase[calibrate]. Takes minutes to
    hours: use --dry-run first.

    Example
    -------
    gearcase calibrate minimal minimal --free casing.mount_stiffness_N_per_um=100..400 --dry-run
    scenes      200
    ...
    time        about 2 minutes on 2 cores: ...
    disk        about 208 MB in 600 files, 3 for each simulation
    """
    from pipelines.datasets.campaign_scenes import sampled_scenes
    from pipelines.datasets.estimate import estimate
    from pipelines.io.errors import SceneWarning
    from pipelines.io.json_text import json_text
    from pipelines.io.user_files import write_whole
    from pipelines.machine.checks.checked_machine import checked_machine
    from pipelines.recordings.machine_file import read_machine
    from pipelines.report.figures.frame_files import save_figure
    from pipelines.scene.presets import load_requested
    from pipelines.studies.calibrate.calibration import calibrate, recorded_levels
    from pipelines.studies.calibrate.calibration_output import figure, plain, text
    from pipelines.studies.calibrate.free_keys import calibration_plan, parse_free
    from pipelines.studies.calibrate.posterior import check_installed

    check_installed()
    loaded = load_requested(options)
    if loaded.scene.faults:
        words = "its faults are simulated in all runs. For recordings of a healthy machine add --set faults=[]"
        warnings.warn(f"{loaded.source.shown}: {words}", SceneWarning, stacklevel=1)
    machine = checked_machine(loaded.scene, loaded.source.shown)
    free = [parse_free(one) for one in options.free]
    plan = calibration_plan(loaded, machine, free, options.runs)
    recorded = recorded_levels(machine, read_machine(options.machine or options.scene), options.recordings)
    if options.dry_run or not options.quiet:
        yield estimate(plan, sampled_scenes(plan)).text
    if options.dry_run:
        return
    folder = Path(options.out or f"campaigns/{plan.name}")
    found = calibrate(
        loaded,
        machine,
        recorded,
        free=free,
        count=options.runs,
        folder=folder,
        processes=options.processes,
        building=work_of(options),
        quiet=options.quiet,
    )
    yield text(found)
    write_whole(folder / "calibration.json", json_text(plain(found)))
    save_figure(figure(found), folder / "corner.png", dpi=130)
    yield f"posterior: {folder / 'calibration.json'}"
    yield f"figure: {folder / 'corner.png'}"
