"""Measured flanks from a file: CSV with a line for each point, or netCDF; the format is in docs/flank-deviations.md."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fem.gears.prescribed import FLANKS, MeasuredFlanks
from pipelines.io.errors import SceneError
from pipelines.io.shown_text import shown
from pipelines.io.user_files import read_text
from pipelines.scene.tables.series import cell_number, reading, refused

if TYPE_CHECKING:
    import xarray

COLUMNS = ("tooth", "flank", "diameter_mm", "position_mm", "deviation_um")
NETCDF = (".nc", ".netcdf")
_AXES = ("tooth", "diameter_mm", "position_mm")
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
    with reading(file, name, path, _MOST_BYTES, "CSV or netCDF"):
        if file.suffix.lower() in NETCDF:
            found = _from_netcdf(file, path)
        else:
            found = _from_csv(read_text(file, _MOST_BYTES), path)
    axes = {name: np.asarray(found[name].values, dtype=float) for name in _AXES}
    tooth, diameter, position = axes.values()
    for name, axis in axes.items():
        if (np.diff(axis) <= 0).any() or (axis is tooth and (axis % 1).any()) or (axis is diameter and axis.min() <= 0):
            raise _refused(
                path, f"{name} must increase; teeth must be whole numbers and diameters positive", "Correct the file"
            )
    face = sense * position / 1000
    order = np.argsort(face)
    return MeasuredFlanks(
        tooth=tooth.astype(int),
        radius=diameter / 2000,
        face=face[order],
        deviation=found.reindex(flank=list(FLANKS)).fillna(0.0).values[..., order] / 1_000_000,
    )


def _from_csv(text: str, path: str) -> xarray.DataArray:
    """Deviations (flank, tooth, diameter_mm, position_mm) as written; NaN on flanks that are not there."""
    import pandas as pd

    rows = csv.DictReader(io.StringIO(text))
    names = [(name or "").strip() for name in rows.fieldnames or ()]
    if names != list(COLUMNS):
        found = ", ".join(map(shown, names)) or "none"
        raise _refused(path, f"the columns are {found}", f"Name them {', '.join(COLUMNS)}, separated by commas")
    rows.fieldnames = names
    points: dict[tuple[str | float, ...], float] = {}
    for row in rows:
        flank = (row["flank"] or "").strip()
        if flank not in FLANKS:
            raise _refused(path, f"line {rows.line_num}: flank is {shown(flank)}", "Set drive or coast")
        *place, value = (cell_number(row[key] or "", rows.line_num, key, path) for key in (*_AXES, "deviation_um"))
        if (flank, *place) in points:
            raise _refused(path, f"line {rows.line_num}: this point is there twice", "Delete one of the two lines")
        points[flank, *place] = value
    if not points:
        raise _refused(path, "the file has no points", "Write one point in each line below the header")
    deviation: xarray.DataArray = pd.Series(points).rename_axis(["flank", *_AXES]).to_xarray()
    for (flank, tooth), one in deviation.stack(place=("flank", "tooth")).groupby("place"):
        counted = int(one.notnull().sum())
        if 0 < counted < one.size:
            raise _refused(
                path,
                f"the {flank} flank of tooth {tooth:g} has {counted} of {one.size} points of the grid",
                "Measure every flank at the same diameters and positions, or delete its lines",
            )
    return deviation


def _from_netcdf(file: Path, path: str) -> xarray.DataArray:
    """As `_from_csv`, from the variable deviation_um."""
    import xarray

    wanted = ("flank", *_AXES)
    with xarray.open_dataset(file, engine="h5netcdf") as data:
        found = data["deviation_um"].load()
    if set(found.dims) != set(wanted) or not set(wanted) <= set(found.coords):
        raise _refused(
            path, f"deviation_um has the dimensions {', '.join(map(str, found.dims))}", f"Set {', '.join(wanted)}"
        )
    sides = [str(flank) for flank in found["flank"].values]
    found = found.transpose(*wanted).astype(float).assign_coords(flank=sides)
    if not set(sides) <= set(FLANKS) or len(set(sides)) < len(sides) or not np.isfinite(found.values).all():
        raise _refused(
            path, "flank must hold drive and coast, each once, and all deviations must be finite", "Correct the file"
        )
    return found


def _refused(path: str, message: str, remedy: str) -> SceneError:
    return refused(f"{path}.file", message, remedy)
