"""`gearcase design`: flank modifications with the least transmission error, pressure and load factor."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pipelines.cli.command_line import scene_and_work, work_arguments
from pipelines.io.argument_types import count, from_zero, positive

HELP = """\
Search for the best flank modifications of a stage. Print the best candidates, evaluated with values as they are
manufactured, and the settings of the best design for each objective. A repeated search continues where it ended."""
EXAMPLE = """\
gearcase design bench --vary both.tip_relief.amount_um=0:30:2 --vary both.tip_relief.length_mm=0.5:4:0.5
...
--set stages.1.pinion.tip_relief.amount_um=...
..."""


def arguments(sub: argparse.ArgumentParser) -> None:
    """Variables, objectives, limits and loads."""
    work_arguments(sub)
    sub.add_argument("--stage", metavar="N", type=count, default=1, help="number of the stage (default 1)")
    sub.add_argument(
        "--vary",
        metavar="KEY=VALUES",
        action="append",
        default=[],
        help="modification to vary, as GEAR.KEY=LOW:HIGH[:STEP] or GEAR.KEY=A,B,C with GEAR pinion, wheel or both; "
        "default steps 1 um and 0.1 mm; repeatable",
    )
    sub.add_argument(
        "--minimize",
        metavar="NAME",
        nargs="+",
        default=["te"],
        help="te, te-max, te1 to te8, pressure or load-factor, also with a statistic over the deviations as in "
        "te:q90 (default te)",
    )
    sub.add_argument(
        "--limit", metavar="TEXT", action="append", default=[], help='limit, as in "pressure <= 1200"; repeatable'
    )
    sub.add_argument(
        "--torque",
        metavar="N_M",
        type=positive,
        nargs="+",
        default=[],
        help="torques on the pinion, N m (default: 25, 50, 75 and 100 %% of that of the scene)",
    )
    sub.add_argument(
        "--samples",
        metavar="N",
        type=count,
        default=0,
        help="number of pairs with random deviations of ISO 1328-1 (default: the nominal pair only)",
    )
    sub.add_argument(
        "--misalignment", metavar="UM", type=from_zero, default=0.0, help="largest misalignment of the samples, um"
    )
    sub.add_argument("--seed", metavar="N", type=count, default=1, help="seed of search and deviations (default 1)")
    sub.add_argument(
        "--evaluations",
        metavar="N",
        type=count,
        default=2000,
        help="number of candidates up to which all are evaluated; with more a genetic algorithm searches, which needs "
        "pip install 'gearcase[design]' (default 2000)",
    )


def main(options: argparse.Namespace) -> Iterator[str]:
    """Search; print the table and the settings of the compromise."""
    from pipelines.io.grid import grid
    from pipelines.studies.design.study import COMPROMISE, DesignOptions, design_study

    loaded, work = scene_and_work(options)
    found = design_study(
        loaded,
        DesignOptions(
            stage=options.stage,
            vary=tuple(options.vary),
            minimize=tuple(options.minimize),
            limits=tuple(options.limit),
            torques=tuple(options.torque),
            samples=options.samples,
            misalignment_um=options.misalignment,
            seed=options.seed,
            evaluations=options.evaluations,
        ),
        work,
    )
    yield grid(found.title, found.rows()).to_text()
    yield f"{len(found.designs.index)} candidates. The table was computed with more positions of the mesh cycle."
    best = found.best()
    if COMPROMISE in best:
        yield (
            "Compromise: the design of the Pareto front nearest to the best value of every objective, each divided by "
            "its range on the front; it is better than the unmodified pair in every objective."
        )
    elif len(best) > 1:
        yield "There is no compromise that is better than the unmodified pair in every objective."
    for purpose, name in best.items():
        yield f"{purpose if purpose == COMPROMISE else f'least {purpose}'}: design {name}\n{found.settings(name)}"
        if edges := found.edges(name):
            yield f"Design {name} is at the edge of the range of {', '.join(edges)}. Extend the range with --vary."
