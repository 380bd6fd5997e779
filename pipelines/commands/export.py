"""`gearcase export`: the signals of a run for other programs."""

from __future__ import annotations

import argparse
import sys


def main(options: argparse.Namespace) -> int:
    """Write response.csv or response.mat."""
    from pipelines import results
    from pipelines.errors import InputError
    from pipelines.export import export
    from pipelines.user_files import writable_file

    folder = results.find_run(options.run)
    target = writable_file(options.out or folder / f"response.{options.form}")
    with results.opened_run(folder / results.RESPONSE) as run:
        try:
            path = export(run, target, options.form)
        except OSError as error:
            raise InputError(f"{target}: cannot be written ({error.strerror}). Choose another --out.") from error
    sys.stdout.write(f"{path}\n")
    return 0
