"""A data set as one xarray.Dataset, with the columns of its rows as coordinates along `run`.

A signal is read when its values are used. One chunk holds one run of one signal, so that `dataset.acceleration[17]`
reads one file. Nothing stays in memory, and no scheduler is needed.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pipelines.datasets.columns import read_columns
from pipelines.datasets.signal_layout import read_facts
from pipelines.datasets.store import SIGNALS
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown

if TYPE_CHECKING:
    import xarray

START = "start"  # of a piece
VIBRATION = ("acceleration", "journal_acceleration")  # on the casing; without a casing, of the shafts in their bearings


def open_dataset(folder: str | Path) -> xarray.Dataset:
    """The signals of a data set over run and time, with the columns of its rows along `run`; also while it grows.

    A run that is not finished has the status "" and the value NaN. A variable of the plan that has the name of a signal
    or a dimension gets the prefix `variable_`.

    Raises
    ------
    InputError : the folder has no data set, or a damaged one
    """
    import xarray
    from zarr.errors import BaseZarrError

    folder = Path(folder)
    facts = read_facts(folder)
    try:
        opened = xarray.open_dataset(
            folder / SIGNALS,
            engine="zarr",
            chunks=None,
            cache=False,
            consolidated=False,
            decode_times=False,
            mask_and_scale=False,
        )
    except (OSError, ValueError, KeyError, BaseZarrError) as error:
        path = shown(folder / SIGNALS)
        raise InputError(f"{path}: cannot be read ({shown(str(error))}). Give the folder of a data set.") from error
    names = {name: values for name, values in facts["layout"]["names"].items() if isinstance(values[0], str)}
    texts = {name: (name, np.array(values, dtype=np.str_)) for name, values in names.items()}
    columns = read_columns(folder, opened.sizes["run"])
    taken = {*opened.variables, START}
    named = {f"variable_{name}" if name in taken else name: values for name, values in columns.items()}
    given = opened.assign_coords(texts).assign_coords({name: ("run", values) for name, values in named.items()})
    return given.assign_attrs(folder=str(folder), rate_Hz=facts["layout"]["rate"])


def vibration(dataset: xarray.Dataset) -> xarray.DataArray:
    """The accelerations (run, sensor, axis, time) on the casing, or of the journals, with bearings as sensors.

    Raises
    ------
    InputError : the data set has none
    """
    for name in VIBRATION:
        if name in dataset:
            found = dataset[name]
            return found.rename(bearing="sensor") if "bearing" in found.dims else found
    raise InputError(
        f"the data set holds no accelerations, only {', '.join(map(str, dataset.data_vars))}. Add them to `signals` "
        "of the plan."
    )
