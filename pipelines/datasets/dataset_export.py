"""Export of pieces of a data set, with their labels, to file formats of other programs.

For NumPy (and with it scikit-learn and PyTorch) or HDF5 one file; for MATLAB and CSV a folder with one file for each
run and labels.csv. Only one run at a time is in memory, so that the data set may be larger than the memory.
"""

from __future__ import annotations

import csv
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.datasets.dataset_reading import open_dataset
from pipelines.datasets.pieces import pieces
from pipelines.datasets.rows import DONE
from pipelines.io.errors import InputError
from pipelines.io.user_files import whole_file, writable_file, writable_folder

if TYPE_CHECKING:
    import xarray

LABELS = "labels.csv"
_LEFT_OUT = ("key", "status", "reason", "seconds", "loop_seconds")  # columns that describe only the computation


@dataclass(frozen=True, eq=False, kw_only=True)
class Cut:
    """The selected pieces: their number, their shape, and an array for each run."""

    count: int
    shape: tuple[int, ...]  # sensor, axis, time
    runs: Iterator[xarray.DataArray]
    columns: dict[str, np.ndarray]  # (count,) each
    named: dict[str, np.ndarray]  # sensor, axis, time in s, rate_Hz


def export_dataset(folder: Path, form: str, out: str | None, **selection: Any) -> tuple[Path, int]:
    """Write the selected pieces in a file format; the file or folder, and the number of pieces.

    Parameters
    ----------
    folder : of the data set
    form : file format, a key of FORMATS
    out : file or folder; None for pieces.npz, pieces.hdf5, pieces-csv or pieces-mat in the data set
    **selection : runs and pieces, by the keywords of `_cut`

    Raises
    ------
    InputError : there are no such runs, sensors or pieces, or the target cannot be written
    """
    write, one_file = FORMATS[form]
    place = out or str(folder / (f"pieces.{form}" if one_file else f"pieces-{form}"))
    target = writable_file(place) if one_file else writable_folder(place)
    cut = _cut(folder, **selection)
    try:
        if one_file:
            with whole_file(target) as partial:
                write(cut, partial)
        else:
            target.mkdir(parents=True, exist_ok=True)
            write(cut, target)
    except OSError as error:
        raise InputError(f"{target}: cannot be written ({error.strerror}). Choose another --out.") from error
    return target, cut.count


def _cut(
    folder: Path,
    *,
    splits: Sequence[str],
    labels: Sequence[str],
    sensors: Sequence[str],
    start: float,
    seed: int,
    **options: Any,
) -> Cut:
    """The pieces of the selected runs.

    Parameters
    ----------
    folder : of the data set
    splits, labels : of the runs; empty for all
    sensors : their names; empty for all
    start : s; earlier samples are omitted
    seed : of the noise
    options : seconds, overlap, noise_m_s2, as in `pipelines.datasets.pieces.pieces`
    """
    dataset = open_dataset(folder)
    chosen = dataset.status.values == DONE
    for name, values in (("split", splits), ("label", labels)):
        known = sorted(set(map(str, dataset[name].values[dataset.status.values == DONE]))) if name in dataset else []
        if missing := [value for value in values if value not in known]:
            raise InputError(
                f"--{name} {missing[0]}: no finished run has this value. Allowed: {', '.join(known) or 'none yet'}."
            )
        if values:
            chosen &= np.isin(dataset[name].values, values)
    part = dataset.isel(run=np.flatnonzero(chosen))
    if not part.sizes["run"]:
        raise InputError(
            f"{folder}: no finished run matches --split, --label and --sensors together. Leave one of them out."
        )
    part = _from(part, start)
    runs = pieces(part, **options, seed=seed, sensors=sensors or None)
    first = next(pieces(part.isel(run=[0]), **options, sensors=sensors or None))
    each = len(first)
    columns = {
        str(name): np.repeat(column.values, each)
        for name, column in part.coords.items()
        if column.dims == ("run",) and name not in _LEFT_OUT
    }
    starts = np.tile(first.start.values, part.sizes["run"])
    return Cut(
        count=each * part.sizes["run"],
        shape=first.shape[1:],
        runs=runs,
        columns={  # texts of fixed length, which NumPy stores without pickling
            name: values.astype(np.str_) if values.dtype == object else values for name, values in columns.items()
        }
        | {"start": starts},
        named={name: first[name].values for name in ("sensor", "axis", "time")}
        | {"rate_Hz": np.array(dataset.attrs["rate_Hz"])},
    )


def _from(runs: xarray.Dataset, start: float) -> xarray.Dataset:
    """The runs without the samples before `start` (s). InputError if fewer than two samples remain."""
    time, rate = runs.time.values, runs.attrs["rate_Hz"]
    first = int(np.searchsorted(time, start - 1e-3 / rate))  # tolerance for a rounded start time
    if first > len(time) - 2:
        raise InputError(f"--start {start:g}: the runs last {len(time) / rate:g} s. Set a time from 0 to below that.")
    return runs.isel(time=slice(first, None))


def _write_npz(cut: Cut, path: Path) -> None:
    """Write one .npz file: `acceleration` (piece, sensor, axis, time) as float32, and an array for each column."""
    shape = (cut.count, *cut.shape)
    with zipfile.ZipFile(path, "w", allowZip64=True) as archive:
        with archive.open("acceleration.npy", "w", force_zip64=True) as file:
            np.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": shape})
            for one in cut.runs:
                file.write(np.ascontiguousarray(one.values, dtype="<f4").tobytes())
        for name, values in (cut.columns | cut.named).items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, values, allow_pickle=False)


def _write_hdf5(cut: Cut, path: Path) -> None:
    """Write one HDF5 file with the same arrays, one chunk for each piece, and texts as UTF-8."""
    import h5py

    with h5py.File(path, "w") as file:
        stored = file.create_dataset("acceleration", (cut.count, *cut.shape), "<f4", chunks=(1, *cut.shape))
        stored.attrs["units"] = "m/s2"
        place = 0
        for one in cut.runs:
            stored[place : place + len(one)] = one.values
            place += len(one)
        for name, values in (cut.columns | cut.named).items():
            if values.dtype.kind == "U":
                file.create_dataset(name, data=values.astype(object), dtype=h5py.string_dtype())
            else:
                file.create_dataset(name, data=values)


def _write_mat(cut: Cut, folder: Path) -> None:
    """Write a MATLAB 5 file for each run, with `acceleration` (piece, sensor, axis, time), and labels.csv."""
    from scipy.io import savemat

    def write(one: xarray.DataArray, path: Path) -> None:
        known = {name: one[name].values[0] for name in cut.columns if name != "start"}
        named = {
            name: values.astype(object) if values.dtype.kind == "U" else values for name, values in cut.named.items()
        }
        content = known | named | {"start": one.start.values, "acceleration": one.values}
        with path.open("wb") as file:
            savemat(file, content, do_compression=True, long_field_names=True)

    _per_run(cut, folder, "mat", write)


def _write_csv(cut: Cut, folder: Path) -> None:
    """Write a CSV file for each run, with a line for each sample, and labels.csv."""
    channels = [f"acceleration {sensor} {axis} [m/s2]" for sensor in cut.named["sensor"] for axis in cut.named["axis"]]

    def write(one: xarray.DataArray, path: Path) -> None:
        with path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerow(["piece", "time [s]", *channels])
            for number, (start, values) in enumerate(zip(one.start.values, one.values, strict=True)):
                time = start + cut.named["time"]
                table = np.column_stack([np.full(len(time), number), time, values.reshape(len(channels), -1).T])
                np.savetxt(file, table, fmt=["%d", *["%.9g"] * (1 + len(channels))], delimiter=",", newline="\r\n")

    _per_run(cut, folder, "csv", write)


def _per_run(cut: Cut, folder: Path, ending: str, write: Callable[[xarray.DataArray, Path], None]) -> None:
    """Write a file for each run, and labels.csv with a line for each file; cells without a number are empty."""
    import pandas as pd

    names = [name for name in cut.columns if name not in ("run", "start")]
    lines = []
    for one in cut.runs:
        run = int(one.run.values[0])
        file = f"run-{run:06d}.{ending}"
        with whole_file(folder / file) as place:
            write(one, place)
        lines.append({"file": file, "run": run, **{name: one[name].values[0] for name in names}})
    with whole_file(folder / LABELS) as partial:
        pd.DataFrame(lines).to_csv(partial, index=False, lineterminator="\r\n")


FORMATS: dict[str, tuple[Callable[[Cut, Path], None], bool]] = {  # function that writes, whether it writes one file
    "csv": (_write_csv, False),
    "mat": (_write_mat, False),
    "npz": (_write_npz, True),
    "hdf5": (_write_hdf5, True),
}
