"""`gearcase tradeoff`: the price of every model and main setting, on this machine and this scene."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pipelines.cli.command_line import WORK, argument, scene_and_work
from pipelines.io.argument_types import picture, seconds, share

ARGUMENTS = (
    *WORK,
    argument(
        "--error",
        type=share,
        metavar="E",
        default=0.02,
        help="print the least expensive choice within this error, a fraction or as in 2%% (default 2%%)",
    ),
    argument(
        "--time",
        type=seconds,
        metavar="T",
        default=10.0,
        help="print the most accurate choice within this time, s (default 10)",
    ),
    argument("--out", type=picture, metavar="FILE", help="plot, .png, .svg or .pdf (default: ./tradeoff-<scene>.png)"),
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Measure time, memory and error of the presets, of every model and main setting, and of combinations that take
    mesh laws, casing and time step from different presets. The error is the deviation from the preset
    `reference`. Print a table, the least expensive choice within --error and the most accurate within --time;
    write a plot. Takes about a minute for the scene `minimal`, and about 5 minutes for the scenes `rig-...`.

    Example
    -------
    gearcase tradeoff minimal --error 2%
    ...
    Within 2 % error of sensor rms the least expensive is "combination: mesh law standard, step 100 us" (1.91 s, 0.4 %).
    ...
    plot: tradeoff-minimal.png
    """
    from pipelines.io.user_files import writable_file
    from pipelines.report.figures.frame_files import save_figure
    from pipelines.studies.trade.tradeoff import trade
    from pipelines.studies.trade.tradeoff_output import answers, trade_figure, trade_table

    loaded, work = scene_and_work(options)
    path = writable_file(options.out or f"tradeoff-{loaded.name}.png")
    found = trade(loaded, work)
    yield trade_table(found).to_text()
    yield from answers(found, options.error, options.time)
    save_figure(trade_figure(found), path, dpi=130)
    yield f"plot: {path}"
