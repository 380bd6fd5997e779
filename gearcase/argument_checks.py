"""Checks of the arguments of public functions; an argument of another type is refused by its name."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown, shown_value

if TYPE_CHECKING:
    import xarray

_RECORDING = "Give the signals that gearcase.open_recording, simulate, run or open_run returned."
_SIGNAL = "Give one over time, such as recording.acceleration.sel(time=slice(0.5, 1.5))."


def refusal(argument: str, value: Any, expected: str, remedy: str) -> InputError:
    """The error for a value of another type, such as ``recording = 3: must be an xarray.Dataset. Give ...``.

    Parameters
    ----------
    argument : its name
    value : what was given
    expected : what it must be, as "an xarray.Dataset"
    remedy : a sentence on what to do
    """
    plain = value is None or isinstance(value, str | int | float)
    head = f"{argument} = {'None' if value is None else shown_value(value)}" if plain else argument
    kind = "" if plain else f"is of type {shown(type(value).__name__)}, and "
    return InputError(f"{head}: {kind}must be {expected}. {remedy}")


def checked_recording(argument: str, value: Any, remedy: str = _RECORDING) -> xarray.Dataset:
    """Signals over time.

    Raises
    ------
    InputError : no dataset, or one without time
    """
    import xarray

    if not isinstance(value, xarray.Dataset):
        raise refusal(argument, value, "an xarray.Dataset", remedy)
    if "time" not in value.coords:
        raise InputError(f"{argument}: the dataset has no coordinate time. {remedy}")
    return value


def checked_recordings(argument: str, value: Any) -> list[xarray.Dataset]:
    """Several of them, in a list or another sequence.

    Raises
    ------
    InputError : no sequence, or an item that is no recording
    """
    if isinstance(value, str | Mapping) or not isinstance(value, Iterable):
        raise refusal(argument, value, "a list of recordings", _RECORDING)
    return [checked_recording(f"{argument}[{number}]", one) for number, one in enumerate(value)]


def checked_by_name(argument: str, value: Any) -> dict[str, xarray.Dataset]:
    """Several of them, by name.

    Raises
    ------
    InputError : no mapping, or a value that is no recording
    """
    if not isinstance(value, Mapping) or hasattr(value, "coords"):
        raise refusal(argument, value, "recordings by name", 'Give a dict such as {"before": one, "after": other}.')
    return {name: checked_recording(f'{argument}["{shown(str(name))}"]', one) for name, one in value.items()}


def checked_signal(argument: str, value: Any) -> xarray.DataArray:
    """One signal.

    Raises
    ------
    InputError : no data array
    """
    import xarray

    if not isinstance(value, xarray.DataArray):
        raise refusal(argument, value, "an xarray.DataArray", _SIGNAL)
    return value


def checked_file(argument: str, value: Any, what: str) -> str | Path:
    """A path or a name, and `what` it is to name.

    Raises
    ------
    InputError : neither text nor a path
    """
    if not isinstance(value, str | os.PathLike):
        raise refusal(argument, value, f"text or a path: {what}", "Correct the argument.")
    return value if isinstance(value, str) else Path(value)
