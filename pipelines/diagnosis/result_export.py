"""Export of results to files for other programs: signals as CSV, MATLAB or UFF, diagnoses as netCDF, CSV and JSON."""

from __future__ import annotations

import csv
import dataclasses
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.io.universal_file import QUANTITIES, Function, write_function
from pipelines.signals.line_table import joined

if TYPE_CHECKING:
    import xarray

    from pipelines.diagnosis.control_diagnosis import Diagnosis

ROWS_AT_ONCE = 8192
_DIRECTIONS = {"x": 1, "y": 2, "z": 3}  # of a universal file


def export(run: xarray.Dataset, path: Path | str, form: str) -> Path:
    """Write a response as `form`: "csv", "mat" or "uff"; returns the path."""
    path = Path(path)
    {"csv": _write_csv, "mat": _write_mat, "uff": _write_uff}[form](run, path)
    return path


def _write_csv(run: xarray.Dataset, path: Path) -> None:
    """One row per sample, one column per signal, named like "acceleration sensor_3 x [m/s2]" in the header."""
    found = list(_signals(run))
    with path.open("w", encoding="utf-8", newline="") as file:
        names = [
            " ".join(words) + (f" [{signal.attrs['units']}]" if "units" in signal.attrs else "")
            for words, _, signal in found
        ]
        csv.writer(file).writerow(["time [s]", *names])
        for part in _parts(run):
            columns = [signal.isel(time=part).values for signal in (run.time, *(signal for *_, signal in found))]
            digits = ["%.9g" if column.dtype == np.float32 else "%.15g" for column in columns]
            np.savetxt(file, np.column_stack(columns), fmt=digits, delimiter=",", newline="\r\n")


def _write_mat(run: xarray.Dataset, path: Path) -> None:
    """MATLAB 5 file: each variable as an array with its dimensions in the order of the Dataset.

    The struct `units` holds the unit of each variable, `coordinates` the names along the dimensions, `labels` the
    attributes (state, load, seed, ...; JSON texts stay texts).
    """
    from scipy.io import savemat

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


def _write_uff(run: xarray.Dataset, path: Path) -> None:
    """Universal file: a function (dataset 58, ASCII, double precision) for each signal, read and written one by one.

    The first line of each function is the name of the signal, as in the header of the CSV file, the second line the
    title of the run. The response entity is the name of the place, cut to ten characters. The direction is the axis, 0
    if there is none.
    """
    time = run.time.values
    kinds = {units: kind for kind, units in QUANTITIES.items()}
    with path.open("w", encoding="ascii", errors="replace", newline="\n") as file:
        for words, place, signal in _signals(run):
            units = str(signal.attrs.get("units", ""))
            head = Function(
                lines=(" ".join(words), str(run.attrs.get("title", ""))),
                entity=words[1] if place else "",
                node=1 + next(iter(place.values()), -1),
                direction=_DIRECTIONS.get(words[-1], 0) if "axis" in place else 0,
                size=len(time),
                start=float(time[0]),
                step=float(time[-1] - time[0]) / (len(time) - 1),
                quantity=kinds.get(units, 0),
                units=units,
            )
            write_function(file, head, (signal.isel(time=part).values for part in _parts(run)))


def _signals(run: xarray.Dataset) -> Iterator[tuple[list[str], dict[str, int], xarray.DataArray]]:
    """Every signal over time: name of the variable and of its place, number along each other dimension, and samples."""
    for name, variable in run.data_vars.items():
        others = [str(dim) for dim in variable.dims if dim != "time"]
        for numbers in np.ndindex(*(run.sizes[dim] for dim in others)) if "time" in variable.dims else ():
            place = dict(zip(others, numbers, strict=True))
            words = [str(run[dim].values[i]) if dim in run.coords else str(i + 1) for dim, i in place.items()]
            yield [str(name), *words], place, variable.isel(place)


def _parts(run: xarray.Dataset) -> Iterator[slice]:
    """The samples of a run part by part, none beyond the end, where h5netcdf 1.3 pads slices."""
    return (slice(i, min(i + ROWS_AT_ONCE, run.time.size)) for i in range(0, run.time.size, ROWS_AT_ONCE))


def save_diagnoses(folder: Path | str, diagnoses: Sequence[Diagnosis]) -> tuple[Path, Path, Path]:
    """Write diagnosis.nc (all lines), diagnosis.csv and diagnosis.json (settings, bands, segments, lines)."""
    stored, table, facts = (Path(folder) / f"diagnosis.{ending}" for ending in ("nc", "csv", "json"))
    lines = joined(d.lines for d in diagnoses)
    lines.save(stored)
    lines.write_csv(table)
    facts.write_text(json.dumps(diagnosis_facts(diagnoses), indent=1), encoding="utf-8")
    return stored, table, facts


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
