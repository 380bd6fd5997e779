"""Measured flanks from a file: CSV with a line for each point, or netCDF; the format is in docs/flank-deviations.md."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fem.gears.prescribed import FLANKS, MeasuredFlanks
from pipelines.io.errors import InputError, Problem, SceneError
from pipelines.io.shown import shown
from pipelines.io.user_files import read_text, regular_file

COLUMNS = ("tooth", "flank", "diameter_mm", "position_mm", "deviation_um")
NETCDF = (".nc", ".netcdf")
_MOST_BYTES = 50_000_000


def measured_flanks(name: str, path: str, sense: int) -> MeasuredFlanks:
    """The measured flanks of a gear, in SI and in the face coordinate of the mesh law.

    Parameters
    ----------
    name : of the file
    path : of its table in the scene, for messages
    sense : lifting sense of the pinion of the stage

    Raises
    ------
    SceneError : no such file, a line or variable that does not fit, points that make no grid
    """
    file = Path(name)
    try:
        regular_file(file, _MOST_BYTES)
        if file.suffix.lower() in NETCDF:
            axes, deviation = _from_netcdf(file, path)
        else:
            axes, deviation = _from_csv(read_text(file, _MOST_BYTES), path)
    except FileNotFoundError:
        raise _refused(
            path, "there is no such file", "Correct the path; it starts at the folder of the scene", name
        ) from None
    except SceneError:
        raise
    except InputError as error:
        raise _refused(path, str(error), "") from error
    tooth, diameter, position = axes
    face = sense * position / 1000
    order = np.argsort(face)
    return MeasuredFlanks(
        tooth=tooth.astype(int),
        radius=diameter / 2000,
        face=face[order],
        deviation=deviation[..., order] / 1_000_000,
    )


def _from_csv(text: str, path: str) -> tuple[list[np.ndarray], np.ndarray]:
    """Teeth, diameters and positions, and the deviations (flank, tooth, diameter, position), as written."""
    rows = csv.DictReader(io.StringIO(text))
    names = [(name or "").strip() for name in rows.fieldnames or ()]
    if names != list(COLUMNS):
        found = ", ".join(map(shown, names)) or "none"
        raise _refused(path, f"the columns are {found}", f"Name them {', '.join(COLUMNS)}, separated by commas")
    rows.fieldnames = names
    points: dict[tuple[int, float, float, float], float] = {}
    for row in rows:
        flank = (row["flank"] or "").strip()
        if flank not in FLANKS:
            raise _refused(path, f"line {rows.line_num}: flank is {shown(flank)}", "Set drive or coast")
        tooth, diameter, position, value = (_number(row[key], rows.line_num, key, path) for key in _NUMBERS)
        point = (FLANKS.index(flank), tooth, diameter, position)
        if point in points:
            raise _refused(path, f"line {rows.line_num}: this point is there twice", "Delete one of the two lines")
        points[point] = value
    if not points:
        raise _refused(path, "the file has no points", "Write one point in each line below the header")
    axes = [np.array(sorted({point[axis] for point in points})) for axis in (1, 2, 3)]
    deviation = np.zeros((len(FLANKS), *(len(axis) for axis in axes)))
    places = [{value: i for i, value in enumerate(axis.tolist())} for axis in axes]
    counted = np.zeros(deviation.shape[:2], dtype=int)
    for (side, *where), value in points.items():
        i, j, k = (place[at] for place, at in zip(places, where, strict=True))
        deviation[side, i, j, k] = value
        counted[side, i] += 1
    whole = deviation.shape[2] * deviation.shape[3]
    partly = np.argwhere((counted > 0) & (counted < whole))
    if len(partly):
        side, i = partly[0]
        raise _refused(
            path,
            f"the {FLANKS[side]} flank of tooth {axes[0][i]:g} has {counted[side, i]} of {whole} points of the grid",
            "Measure every flank at the same diameters and positions, or delete its lines",
        )
    return _checked(axes, path), deviation


_NUMBERS = ("tooth", "diameter_mm", "position_mm", "deviation_um")


def _number(cell: str | None, line: int, column: str, path: str) -> float:
    try:
        value = float(cell or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise _refused(path, f"line {line}: {column} is {shown(cell or 'empty')}", "Write a number")
    return value


def _from_netcdf(file: Path, path: str) -> tuple[list[np.ndarray], np.ndarray]:
    """As `_from_csv`, from the variable deviation_um (flank, tooth, diameter_mm, position_mm) with its coordinates."""
    import xarray

    try:
        with xarray.open_dataset(file, engine="h5netcdf") as data:
            found = data["deviation_um"].load()
            wanted = ("flank", *COLUMNS[:1], *COLUMNS[2:4])
            if set(found.dims) != set(wanted) or not set(wanted) <= set(found.coords):
                raise _refused(
                    path,
                    f"deviation_um has the dimensions {', '.join(map(str, found.dims))}",
                    f"Set {', '.join(wanted)}",
                )
            found = found.transpose(*wanted)
            sides = [str(flank) for flank in found["flank"].values]
            axes = [np.asarray(found[name].values, dtype=float) for name in wanted[1:]]
            given = np.asarray(found.values, dtype=float)
    except SceneError:
        raise
    except Exception as error:  # the libraries raise errors of every kind
        raise _refused(path, f"cannot be read as netCDF ({error})", "Set a CSV or netCDF file") from error
    if not set(sides) <= set(FLANKS) or len(set(sides)) < len(sides) or not np.isfinite(given).all():
        raise _refused(
            path, "flank must hold drive and coast, each once, and all deviations must be finite", "Correct the file"
        )
    deviation = np.zeros((len(FLANKS), *given.shape[1:]))
    for side, values in zip(sides, given, strict=True):
        deviation[FLANKS.index(side)] = values
    return _checked(axes, path), deviation


def _checked(axes: Sequence[np.ndarray], path: str) -> list[np.ndarray]:
    """The axes, if teeth are whole numbers, diameters positive and all of them rise."""
    tooth, diameter, _ = axes
    for name, wrong in (
        ("tooth", (tooth % 1 != 0).any()),
        ("diameter_mm", (diameter <= 0).any()),
        *((name, (np.diff(axis) <= 0).any()) for name, axis in zip((COLUMNS[0], *COLUMNS[2:4]), axes, strict=True)),
    ):
        if wrong:
            raise _refused(
                path, f"{name} must increase; teeth must be whole numbers and diameters positive", "Correct the file"
            )
    return list(axes)


def _refused(path: str, message: str, remedy: str, value: str | None = None) -> SceneError:
    return SceneError("scene", [Problem(f"{path}.file", message, remedy, None if value is None else f'"{value}"')])
