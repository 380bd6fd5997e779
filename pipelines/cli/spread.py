"""`gearcase spread`: features over a population of machines, and which property makes their variance."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from pipelines.cli.command_line import SCENE, argument, campaign_arguments, work_of
from pipelines.io.argument_types import count, path
from pipelines.signals.features.definitions import BY_NAME

ARGUMENTS = (
    *SCENE,
    argument(
        "--over",
        metavar="PLAN",
        type=path,
        help="plan of a campaign whose variables are the population (default: scatter as in docs/campaigns.md)",
    ),
    argument("--machines", metavar="N", type=count, help="number of machines (default: that of PLAN, or 100)"),
    argument(
        "--feature",
        metavar="NAME",
        action="append",
        choices=[*BY_NAME],
        default=[],
        help="feature of the figure, as in docs/features.md; repeatable (default: those with the widest intervals)",
    ),
    *campaign_arguments("spread"),
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Simulate machines of a population that differ from the scene. Print and write the median and the 90 % interval of
    every feature, and first-order Sobol indices: which property of the machines makes the variance. Repeat the
    command to continue after an interruption. Takes minutes to hours: use --dry-run first.

    Example
    -------
    gearcase spread minimal --dry-run
    scenes      100
    ...
    time        about 34 s on 2 cores: ...
    disk        about 22.5 MB in 300 files, 3 for each simulation
    """
    from pipelines.datasets.campaign_scenes import sampled_scenes
    from pipelines.datasets.estimate import estimate
    from pipelines.io.user_files import whole_file
    from pipelines.machine.checks.checked_machine import checked_machine
    from pipelines.report.figures.frame_files import save_figure
    from pipelines.scene.presets import load_requested
    from pipelines.studies.spread.population_spread import run_spread, spread_plan
    from pipelines.studies.spread.spread_output import chosen, figure, text

    loaded = load_requested(options)
    machine = checked_machine(loaded.scene, loaded.source.shown)
    plan = spread_plan(loaded, machine, options.over, options.machines)
    if options.dry_run or not options.quiet:
        yield estimate(plan, sampled_scenes(plan)).text
    if options.dry_run:
        return
    folder = Path(options.out or f"campaigns/{plan.name}")
    found = run_spread(plan, folder, machine.monitored, options.processes, work_of(options), quiet=options.quiet)
    yield text(found)
    with whole_file(folder / "spread.csv") as aside:
        found.table.to_csv(aside, index=False, float_format="%.6g", lineterminator="\n")
    save_figure(figure(found, chosen(found, options.feature)), folder / "spread.png", dpi=130)
    yield f"table: {folder / 'spread.csv'}"
    yield f"figure: {folder / 'spread.png'}"
