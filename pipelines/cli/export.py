"""`gearcase export`: the signals of a run for other programs."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Write response.csv, response.mat or response.uff."""
    from pipelines.diagnosis.export import export
    from pipelines.io.errors import InputError
    from pipelines.io.shown import shown
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
    sys.stdout.write(f"{target}\n")
    return 0
