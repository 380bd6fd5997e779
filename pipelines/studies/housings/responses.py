"""Frequency responses of the reduced casing: acceleration per force from one point to others, in a table and a plot.

With the row r of the response, the row s of the force, and omega = 2 pi f:

    H(f) = -omega^2 r (K + i omega C - omega^2 M)^-1 s^T

C is the damping of the casing in the scene. The phase is that of the acceleration relative to the force.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from fem.casing.reduced.reduced_body import ReducedBody

LINES = 2000  # frequencies of a response
_COLOURS = {"x": "#2a6f97", "y": "#3a7d44", "z": "#c23b22"}
_COLUMNS = 3  # points side by side in a plot


def accelerances(body: ReducedBody, outputs: np.ndarray, inputs: np.ndarray, frequencies: np.ndarray) -> np.ndarray:
    """Complex accelerances (line, output, input), m/s2/N.

    Parameters
    ----------
    body : the reduced casing
    outputs, inputs : rows (output, coordinate) of the responses and (input, coordinate) of the forces
    frequencies : (line,) Hz
    """
    found = np.empty((len(frequencies), len(outputs), len(inputs)), complex)
    for line, omega in enumerate(2.0 * math.pi * frequencies):
        dynamic = body.stiffness - omega**2 * body.mass + 1j * omega * body.damping
        found[line] = -(omega**2) * outputs @ np.linalg.solve(dynamic, inputs.T)
    return found


def checked_names(names: Sequence[str], bearings: Sequence[str], sensors: Sequence[str]) -> None:
    """Refuse names of a response that a scene does not have, before anything is computed.

    Parameters
    ----------
    names : of the force, then of the responses
    bearings, sensors : points of the casing

    Raises
    ------
    InputError : no axis of the force, an unknown point or axis, no point to respond
    """
    points = (*bearings, *sensors)
    for number, name in enumerate(names):
        point, _, axis = name.partition(":")
        if point not in points:
            raise InputError(f"--response {shown(name)}: no such point. Choose one of {', '.join(points)}.")
        if not re.fullmatch("u?[xyz]" if number == 0 else "(u?[xyz])?", axis):
            raise InputError(
                f"--response {shown(name)}: add the axis :x, :y or :z after the name of the point, as in {point}:z."
            )
    if len(names) == 1 and not sensors:
        raise InputError("--response: the casing has no sensors. Name a point of the response too, as in bearing_1:z.")


def accelerance(body: ReducedBody, names: Sequence[str], band: float, damping: str) -> xarray.DataArray:
    """The responses (frequency, output) to a force, m/s2/N, up to the band of the casing.

    Their attributes name the force and the damping.

    Parameters
    ----------
    body : the reduced casing
    names : of the force, "bearing_1:z", and of the responses, "sensor_3:z" or "sensor_3" for its three axes; without
        them all axes of all sensors
    band : Hz
    damping : in words

    Raises
    ------
    InputError : a point without motion in a direction, as one that bears no load along it
    """
    import xarray

    force, *responses = names
    if not responses:
        responses = [name for name in body.point_names if not name.startswith(("bearing_", "ground_"))]
    known = {name.replace(":u", ":"): name for name in body.row_names if ":u" in name}
    outputs = [row for name in responses for row in _rows_of(name, known)]
    (into,) = _rows_of(force, known)
    frequencies = band * np.arange(1, LINES + 1) / LINES
    rows = np.array([body.row(known[name]) for name in outputs])
    values = accelerances(body, rows, body.row(known[into])[None], frequencies)[:, :, 0]
    return xarray.DataArray(
        values,
        coords={"frequency": frequencies, "output": outputs},
        dims=("frequency", "output"),
        attrs={"force": into, "damping": damping, "units": "m/s2/N"},
    )


def _rows_of(name: str, known: dict[str, str]) -> list[str]:
    plain = name.replace(":u", ":")
    found = [row for row in known if row == plain or row.startswith(f"{plain}:")]
    if not found:
        raise InputError(f"--response {shown(name)}: the casing has no such row. Choose one of {', '.join(known)}.")
    return found


def damping_words(ratios: np.ndarray, frequencies: np.ndarray, band: float) -> str:
    """The modal damping ratios (mode,) of the modes up to a band in words."""
    inside = ratios[frequencies <= band] if (frequencies <= band).any() else ratios
    low, high = 100.0 * inside.min(), 100.0 * inside.max()
    return f"damping ratio of the modes {low:.3g} %" + (f" to {high:.3g} %" if high > 1.001 * low else "")


def table_lines(found: xarray.DataArray, title: str) -> Iterator[str]:
    """Lines of a CSV file: two of comments, the heading, then frequency, amplitude and phase of every response."""
    yield f"# {title}: acceleration per force at {found.force}; {found.damping}\n"
    yield "# frequency in Hz, amplitude in m/s2/N, phase of the acceleration relative to the force in degrees\n"
    heads = [f"{name} {what}" for name in found.output.values for what in ("amplitude", "phase")]
    yield f"{','.join(['frequency', *heads])}\n"
    for frequency, row in zip(found.frequency.values, found.values, strict=True):
        pairs = np.column_stack([np.abs(row), np.degrees(np.angle(row))]).ravel()
        yield f"{frequency:.10g},{','.join(f'{value:.8g}' for value in pairs)}\n"


def accelerance_figure(found: xarray.DataArray, title: str) -> Figure:
    """Amplitude over phase for every point, its axes in three colours."""
    from pipelines.report.figures.plots import dress, new_figure, plain

    points = list(dict.fromkeys(name.split(":")[0] for name in found.output.values))
    columns = min(_COLUMNS, len(points))
    rows = -(-len(points) // columns)
    figure = new_figure(0.6 + 3.6 * rows + 1.4 * (rows == 1), 4.4 * columns if columns > 1 else 9.0)
    figure.suptitle(f"{plain(title)}\nacceleration per force at {found.force}; {found.damping}", fontsize=11)
    boxes = figure.subfigures(rows, columns, squeeze=False).ravel()
    amplitude = np.abs(found.values)
    low, high = amplitude[amplitude > 0.0].min(initial=np.inf), amplitude.max()
    for box, point in zip(boxes, points, strict=False):
        above, below = box.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
        for number, name in enumerate(found.output.values):
            if name.split(":")[0] == point:
                axis = name.split(":")[1]
                looks = {"color": _COLOURS[axis], "lw": 1.0, "label": axis}
                above.semilogy(found.frequency.values, amplitude[:, number], **looks)
                below.plot(found.frequency.values, np.degrees(np.angle(found.values[:, number])), **looks)
        dress(above, point, "", "m/s2/N")
        dress(below, "", "Hz", "phase, deg")
        above.set_ylim(max(0.5 * low, 1e-6 * high), 2.0 * high)
        below.set_xlim(0.0, found.frequency.values[-1])
        below.set_ylim(-180.0, 180.0)
        below.set_yticks([-180, 0, 180])
        above.legend(loc="lower right", ncols=3, frameon=False, fontsize=8)
    return figure
