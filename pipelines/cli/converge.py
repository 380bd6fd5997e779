"""`gearcase converge`: refine one setting and estimate the discretisation error."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pipelines.cli.command_line import WORK, argument, scene_and_work
from pipelines.io.argument_types import count, picture, share
from pipelines.studies.trade.refinement_axes import AXES

ARGUMENTS = (
    *WORK,
    argument(
        "--over",
        choices=tuple(AXES),
        required=True,
        help="setting to refine: element size of the gears, slices of the face, positions in the mesh cycle, element "
        "size or number of modes of the casing, element length of the shafts, or time step",
    ),
    argument(
        "--levels",
        type=count,
        metavar="N",
        default=3,
        help="number of values of the setting, 3 or more: the value of the scene, a finer one and coarser ones "
        "(default 3)",
    ),
    argument(
        "--error", type=share, metavar="E", default=0.01, help="target error, a fraction or as in 1%% (default 1%%)"
    ),
    argument(
        "--out",
        type=picture,
        metavar="FILE",
        help="plot, .png, .svg or .pdf (default: ./convergence-<scene>-<setting>.png)",
    ),
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Compute a scene with several values of one setting. Print the observed order of convergence, the
    extrapolated value and the uncertainty band of each result, and write a plot. Takes seconds to minutes per value.

    Example
    -------
    gearcase converge minimal --over step
    ...
    The setting in use is fine enough for 1 %: the widest uncertainty band is 0.1 % (sensor_3 rms, lifting).
    ...
    plot: convergence-minimal-step.png
    """
    from pipelines.io.user_files import writable_file
    from pipelines.report.figures.frame_files import save_figure
    from pipelines.studies.trade.line_uncertainty import line_uncertainty
    from pipelines.studies.trade.refinement import refine
    from pipelines.studies.trade.refinement_output import (
        convergence_figure,
        convergence_table,
        not_refined,
        pairing_words,
        slicing_table,
        verdict,
    )

    loaded, work = scene_and_work(options)
    path = writable_file(options.out or f"convergence-{loaded.name}-{options.over}.png")
    found = refine(loaded, options.over, options.levels, work)
    yield convergence_table(loaded.name, found).to_text()
    if options.over == "slices":
        yield slicing_table(loaded.name, found).to_text()
    models = [stage.mesh.model for stage in loaded.scene.stages]
    left = not_refined(models, loaded.scene.casing.model, options.over)
    known = line_uncertainty(loaded, work) if options.over == "casing-mesh" else ""
    yield from filter(None, (pairing_words(found), verdict(found, options.error), left, known))
    save_figure(convergence_figure(loaded.name, found), path, dpi=130)
    yield f"plot: {path}"
