"""Export of results to files for other programs: signals as CSV, MATLAB or UFF, diagnoses as netCDF, CSV and JSON."""

from __future__ import annotations

import csv
import dataclasses
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.io.universal_file import QUANTITIES, Function, write_function
from pipelines.signals.line_table import joined

if TYPE_CHECKING:
    import xarray

    from pipelines.diagnosis.control_diagnosis import Diagnosis

FORMATS = ("csv", "mat", "uff")
ROWS_AT_ONCE = 8192
_DIRECTIONS = {"x": 1, "y": 2, "z": 3}  # of a universal file


class ExportError(ValueError):
    """The format is not known."""


def export(run: xarray.Dataset, path: Path | str, form: str) -> Path:
    """Write a response as `form`, one of FORMATS; returns the path.

    Raises
    ------
    ExportError : the format is not known
    """
    writers = {"csv": write_csv, "mat": write_mat, "uff": write_uff}
    if form not in writers:
        raise ExportError(f"format {form!r}: known are {', '.join(FORMATS)}")
    return writers[form](run, path)


def write_csv(run: xarray.Dataset, path: Path | str) -> Path:
    """One row per sample, one column per signal, named like "acceleration sensor_3 x [m/s2]" in the header."""
    path = Path(path)
    with path.open("w", encoding="utf-8", newline="") as file:
        names = [name for name, _ in signal_columns(run.isel(time=slice(0)))]
        csv.writer(file).writerow(["time [s]", *names])
        for first in range(0, run.time.size, ROWS_AT_ONCE):
            last = min(first + ROWS_AT_ONCE, run.time.size)  # h5netcdf 1.3 pads slices beyond the end
            block = run.isel(time=slice(first, last))
            columns = [block.time.values, *(values for _, values in signal_columns(block))]
            digits = ["%.9g" if column.dtype == np.float32 else "%.15g" for column in columns]
            np.savetxt(file, np.column_stack(columns), fmt=digits, delimiter=",", newline="\r\n")
    return path


def write_mat(run: xarray.Dataset, path: Path | str) -> Path:
    """MATLAB 5 file: each variable as an array with its dimensions in the order of the Dataset.

    The struct `units` holds the unit of each variable, `coordinates` the names along the dimensions, `labels` the
    attributes (state, load, seed, ...; JSON texts stay texts).
    """
    from scipy.io import savemat

    path = Path(path)
    units = {str(name): str(variable.attrs.get("units", "")) for name, variable in run.data_vars.items()}
    coordinates = {
        str(name): np.array([str(v) for v in coordinate.values], dtype=object)
        for name, coordinate in run.coords.items()
        if name != "time"
    }
    labels = {str(name): _plain(value) for name, value in run.attrs.items()}
    with path.open("wb") as file:
        for name in ("time", *run.data_vars):  # one by one to limit memory
            savemat(file, {str(name): run[name].values}, do_compression=True, long_field_names=True)
        content = {"units": units, "coordinates": coordinates, "labels": labels}
        savemat(file, content, do_compression=True, long_field_names=True)
    return path


def write_uff(run: xarray.Dataset, path: Path | str) -> Path:
    """Universal file: a function (dataset 58, ASCII, double precision) for each signal, read and written one by one.

    The first line of each function is the name of the signal, as in the header of the CSV file, the second line the
    title of the run. The response entity is the name of the place, cut to ten characters. The direction is the axis, 0
    if there is none.
    """
    path = Path(path)
    time = run.time.values
    kinds = {units: kind for kind, units in QUANTITIES.items()}
    with path.open("w", encoding="ascii", errors="replace", newline="\n") as file:
        for name, variable in run.data_vars.items():
            if "time" not in variable.dims:
                continue
            units = str(variable.attrs.get("units", ""))
            for words, place in signal_places(run, variable):
                signal = variable.isel(place).transpose("time")
                axis = words[-1] if "axis" in place else ""
                head = Function(
                    lines=(" ".join([str(name), *words]), str(run.attrs.get("title", ""))),
                    entity=words[0] if words else "",
                    node=1 + next(iter(place.values()), -1),
                    direction=_DIRECTIONS.get(axis, 0),
                    size=len(time),
                    start=float(time[0]),
                    step=float(time[-1] - time[0]) / (len(time) - 1),
                    quantity=kinds.get(units, 0),
                    units=units,
                )
                parts = (
                    slice(first, min(first + ROWS_AT_ONCE, len(time))) for first in range(0, len(time), ROWS_AT_ONCE)
                )
                write_function(file, head, (signal.isel(time=part).values for part in parts))
    return path


def signal_places(run: xarray.Dataset, variable: xarray.DataArray) -> Iterator[tuple[list[str], dict[str, int]]]:
    """Names, and numbers along all dimensions except time, of every place of a signal."""
    others = [str(dim) for dim in variable.dims if dim != "time"]
    for numbers in np.ndindex(*(run.sizes[dim] for dim in others)):
        place = dict(zip(others, numbers, strict=True))
        yield [str(run[dim].values[i]) if dim in run.coords else str(i + 1) for dim, i in place.items()], place


def signal_columns(run: xarray.Dataset) -> Iterator[tuple[str, np.ndarray]]:
    """Name with unit and samples (time,) of every signal; a signal of more dimensions has several columns."""
    for name, variable in run.data_vars.items():
        if "time" not in variable.dims:
            continue
        others = [dim for dim in variable.dims if dim != "time"]
        unit = f" [{variable.attrs['units']}]" if "units" in variable.attrs else ""
        flat = variable.transpose("time", *others)
        shape = tuple(run.sizes[dim] for dim in others)
        values = flat.values.reshape(run.time.size, math.prod(shape))
        for column, (words, _) in enumerate(signal_places(run, flat)):
            yield " ".join([str(name), *words]) + unit, values[:, column]


def save_diagnoses(folder: Path | str, diagnoses: Sequence[Diagnosis]) -> tuple[Path, Path, Path]:
    """Write diagnosis.nc (all lines), diagnosis.csv and diagnosis.json (settings, bands, segments, lines)."""
    folder = Path(folder)
    table = joined(d.lines for d in diagnoses)
    table.save(folder / "diagnosis.nc")
    table.write_csv(folder / "diagnosis.csv")
    text = json.dumps(diagnosis_facts(diagnoses), indent=1)
    (folder / "diagnosis.json").write_text(text, encoding="utf-8")
    return folder / "diagnosis.nc", folder / "diagnosis.csv", folder / "diagnosis.json"


def diagnosis_facts(diagnoses: Sequence[Diagnosis]) -> dict[str, Any]:
    """Settings, band and segments of every case, and all lines with the units of their columns."""
    table = joined(d.lines for d in diagnoses)
    cases = [
        {
            "load": d.load,
            "deviations": d.deviations,
            "sensor_noise": d.noise,
            "envelope_band_hz": list(d.band),
            "settings": dataclasses.asdict(d.settings),
            "segments": {name: dataclasses.asdict(s) | {"duration": s.duration} for name, s in d.segments.items()},
        }
        for d in diagnoses
    ]
    return {"cases": cases, "units": table.units(), "lines": table.to_dicts()}


def _plain(value: object) -> object:
    """A value for MATLAB: numbers and texts unchanged, "" for None, others as text."""
    if value is None:
        return ""
    return value if isinstance(value, (str, int, float, np.ndarray, np.generic)) else str(value)
