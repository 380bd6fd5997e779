"""`gearcase design`: flank modifications with the least transmission error, levels at sensors and stress."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

from pipelines.cli.command_line import WORK, argument, scene_and_work
from pipelines.io.argument_types import count, from_zero, path, positive

ARGUMENTS = (  # defaults are those of `DesignOptions`
    *WORK,
    argument(
        "--out",
        metavar="FILE",
        type=path,
        help="HTML page with the Pareto front, the transmission error before and after, and TOML to paste",
    ),
    argument("--stage", metavar="N", type=count, help="number of the stage (default 1)"),
    argument(
        "--vary",
        metavar="KEY=VALUES",
        action="append",
        help="modification to vary, as GEAR.KEY=LOW:HIGH[:STEP] or GEAR.KEY=A,B,C with GEAR pinion, wheel or both; or "
        "a value of the stage, as face_width_mm=18:24:2 (also teeth, module, angles, profile shifts), at constant "
        "centre distance; default steps 1 um and 0.1 mm; repeatable (default: tip reliefs of both gears, amounts up to "
        "the deflection)",
    ),
    argument(
        "--minimize",
        metavar="NAME",
        nargs="+",
        help="te (peak-to-peak transmission error, mean over the torques), te-max (the largest), te1 to te8 "
        "(amplitude of a mesh order), pressure, root-stress, load-factor, level (rms acceleration of the sensors at "
        "the mesh orders), level-SENSOR, ratio-error (%% of the ratio of the scene); with a statistic over the samples "
        "as in te:q90 (default te)",
    ),
    argument(
        "--limit",
        metavar="TEXT",
        action="append",
        dest="limits",
        help='limit, as in "pressure <= 1200" (MPa); repeatable',
    ),
    argument(
        "--torque",
        metavar="N_M",
        type=positive,
        nargs="+",
        dest="torques",
        help="torques on the pinion, N m (default: 25, 50, 75 and 100 %% of that of the scene)",
    ),
    argument(
        "--samples",
        metavar="N",
        type=count,
        help="number of pairs with random profile and helix deviations of ISO 1328-1, in the class of the scene, also "
        "if deviations.enabled is false (default: the nominal pair only). To vary only the misalignment, add --set "
        "deviations.include=[]",
    ),
    argument(
        "--misalignment",
        metavar="UM",
        type=from_zero,
        help="largest misalignment of these pairs over the face width, um (default 0)",
    ),
    argument("--seed", metavar="N", type=count, help="seed of search and deviations (default 1)"),
    argument(
        "--evaluations",
        metavar="N",
        type=count,
        help="evaluate all combinations if there are at most N (default 2000); else use a genetic algorithm, which "
        "needs pip install 'gearcase[design]'",
    ),
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Search for the best flank modifications of a stage: tip reliefs of both gears, or what --vary gives, also the
    numbers of teeth and other values of the stage. Print the best candidates, with values rounded to the steps of
    --vary, and the settings of the best design for each objective. A repeated search continues where it ended. Takes
    seconds for nominal pairs, and minutes with --samples.

    Example
    -------
    gearcase design bench --vary both.tip_relief.amount_um=0:30:2 --vary both.tip_relief.length_mm=0.5:4:0.5
    ...
    --set stages.1.pinion.tip_relief.amount_um=...
    ...
    """
    from dataclasses import fields

    from pipelines.io.user_files import writable_file
    from pipelines.studies.design.design_page import words, write_page
    from pipelines.studies.design.design_study import DesignOptions, design_study

    target = None if options.out is None else writable_file(options.out, endings=(".html",))
    loaded, work = scene_and_work(options)
    known = {one.name for one in fields(DesignOptions)}
    given: dict[str, Any] = {
        name: value for name, value in vars(options).items() if name in known and value is not None
    }
    if "misalignment" in given:
        given["misalignment"] *= 1e-6
    found = design_study(loaded, DesignOptions(**given), work)
    yield from words(found)
    if target is not None:
        write_page(found, target)
        yield str(target)
