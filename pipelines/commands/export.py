"""`gearcase export`: the signals of a run for other programs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def main(options: argparse.Namespace) -> int:
    """Write response.csv or response.mat."""
    import xarray

    from pipelines import results
    from pipelines.errors import InputError
    from pipelines.export import export

    folder = results.find_run(options.run)
    target = Path(options.out) if options.out else folder / f"response.{options.form}"
    with xarray.open_dataset(folder / results.RESPONSE, engine="h5netcdf") as data:
        try:
            path = export(data, target, options.form)
        except OSError as error:
            raise InputError(f"{target}: cannot be written ({error.strerror}). Choose another --out.") from error
    sys.stdout.write(f"{path}\n")
    return 0
