"""`gearcase export`: the signals of a run for other programs."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pipelines.cli.command_line import RUN, argument
from pipelines.io.argument_types import path

ARGUMENTS = (
    RUN,
    argument("--to", dest="form", choices=("csv", "mat", "uff"), required=True, help="file format"),
    argument(
        "--out",
        metavar="FILE",
        type=path,
        help="file to write (default: response.csv, .mat or .uff in the result folder)",
    ),
)


def main(options: argparse.Namespace) -> Iterator[str]:
    """Write the signals of a finished run as a CSV, MATLAB or universal file (UFF 58) for other programs. Takes
    seconds.

    Example
    -------
    gearcase export minimal --to mat
    runs/minimal/2026-11-25_00-50-21/response.mat
    """
    from pipelines.diagnosis.result_export import export
    from pipelines.io.errors import InputError
    from pipelines.io.shown_text import shown
    from pipelines.io.user_files import whole_file, writable_file
    from pipelines.runs import run_folder

    if options.out and not options.out.lower().endswith(f".{options.form}"):
        raise InputError(f"--out {shown(options.out)}: with --to {options.form} the name must end in .{options.form}.")
    folder = run_folder.find_run(options.run)
    target = writable_file(options.out or folder / f"response.{options.form}")
    with run_folder.opened_run(folder / run_folder.RESPONSE) as run:
        try:
            with whole_file(target) as partial:
                export(run, partial, options.form)
        except OSError as error:
            raise InputError(f"{target}: cannot be written ({error.strerror}). Choose another --out.") from error
    yield str(target)
