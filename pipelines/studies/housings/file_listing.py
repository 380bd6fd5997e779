"""What a file of a housing holds, as tables of text; all places in mm, in the frame of the file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from fem.casing.recognition.housing_contents import GeometryContents
from fem.casing.recognition.shaft_fit import ShaftFit, tilt
from pipelines.io.shown_text import shown
from pipelines.io.text_table import grid

MOST_ROWS = 40
_LEAST_TILT = 0.01  # degrees that are mentioned
_USUAL_SIZE = (0.02, 5.0)  # m, longest side of a housing


def listing(contents: GeometryContents) -> Iterator[str]:
    """Unit and size, solids and what hangs loose, bores, flat faces, bolt patterns, tilt."""
    yield from _head(contents)
    yield _solids(contents)
    for solid in contents.solids:
        if solid.open_at is not None:
            yield (
                f"  solid {solid.number} does not close, or has faces that cannot be meshed, around "
                f"({_mm(solid.open_at)}) mm: repair it in the CAD program, or exclude it by solids = [...]"
            )
    for one, two, gap, place in contents.gaps:
        if contents.solids[one - 1].part != contents.solids[two - 1].part:
            yield f"  solids {one} and {two} do not touch: gap of {1000 * gap:.4g} mm at ({_mm(place)}) mm"
    if contents.bores:
        yield _bores(contents)
        yield from _tilt(contents)
    else:
        yield "no bore was found: no face is a cylinder with the material outside"
    if contents.flats:
        yield _flats(contents)
    if contents.patterns:
        yield _patterns(contents)


def _head(contents: GeometryContents) -> Iterator[str]:
    size = np.ptp(contents.box, axis=0)
    how = "declared by the file" if contents.declared else "assumed, the file declares none; --unit states another"
    yield f"{shown(contents.name)}: unit {contents.unit} ({how})"
    yield (
        f"  size {' x '.join(f'{1000 * side:.5g}' for side in size)} mm, from ({_mm(contents.box[0])}) to "
        f"({_mm(contents.box[1])}) mm"
    )
    longest = float(size.max())
    if not _USUAL_SIZE[0] <= longest <= _USUAL_SIZE[1]:
        yield (f"  a housing {longest:.4g} m long is unusual: give --unit, or --scene to find the unit of the shafts")


def _solids(contents: GeometryContents) -> str:
    rows = [
        {
            "solid": one.number,
            "part": one.part,
            "volume cm3": f"{1e6 * one.volume:.5g}",
            "from mm": _mm(one.box[0]),
            "to mm": _mm(one.box[1]),
        }
        for one in contents.solids[:MOST_ROWS]
    ]
    parts = contents.parts
    words = "one connected body" if parts == 1 else f"{parts} parts that do not touch"
    title = f"{len(contents.solids)} {'solid' if len(contents.solids) == 1 else 'solids'}, {words}"
    return _cut_off(title, rows, len(contents.solids))


def _bores(contents: GeometryContents) -> str:
    rows = [
        {
            "bore": one.number,
            "solid": one.solid,
            "diameter mm": f"{1000 * one.diameter:.4f}",
            "length mm": f"{1000 * one.length:.3f}",
            "middle mm": _mm(one.centre),
            "axis": _direction(one.axis),
            "arc deg": f"{np.degrees(one.angle):.0f}",
        }
        for one in contents.bores[:MOST_ROWS]
    ]
    title = f"{len(contents.bores)} {'bore' if len(contents.bores) == 1 else 'bores'}, the widest first"
    return _cut_off(title, rows, len(contents.bores))


def _tilt(contents: GeometryContents) -> Iterator[str]:
    axis, angle = tilt(contents.bores)
    if np.degrees(angle) > _LEAST_TILT:
        name = "xyz"[int(np.abs(axis).argmax())]
        yield f"  tilt: {np.degrees(angle):.3f} deg between the widest bore and the axis {name} of the file"


def _flats(contents: GeometryContents) -> str:
    rows = [
        {
            "face": one.number,
            "solid": one.solid,
            "area mm2": f"{1e6 * one.area:.5g}",
            "middle mm": _mm(one.centre),
            "normal": _direction(one.normal),
        }
        for one in contents.flats[: MOST_ROWS // 4]
    ]
    return _cut_off(f"{len(contents.flats)} flat faces, the largest first", rows, len(contents.flats))


def _patterns(contents: GeometryContents) -> str:
    rows = []
    for one in contents.patterns[: MOST_ROWS // 2]:
        around = f" about bore {one.around}" if one.around else ""
        where = f"circle of {1000 * one.circle_diameter:.4g}{around}" if one.circle_diameter else "no circle"
        numbers = ", ".join(map(str, one.bores[:12])) + (", ..." if len(one.bores) > 12 else "")
        holes = f"{len(one.bores)} x {1000 * one.hole_diameter:.4g}"
        rows.append({"holes mm": holes, "on mm": where, "middle mm": _mm(one.centre), "bores": numbers})
    return _cut_off("Bolt patterns", rows, len(contents.patterns))


def fitted(fit: ShaftFit) -> str:
    """Which bore is the seat of which bearing, in the frame of the scene."""
    rows = [
        {
            "bearing": one.bearing,
            "shaft": one.shaft + 1,
            "bore": one.bore.number,
            "diameter mm": f"{1000 * one.bore.diameter:.4f}",
            "off axis mm": f"{1000 * one.off:.4f}",
            "bearing at y mm": f"{1000 * one.y:.4f}",
            "middle of seat y mm": f"{1000 * one.middle:.4f}",
        }
        for one in fit.seats
    ]
    turn = float(np.degrees(np.arccos(np.clip((np.trace(fit.axes) - 1.0) / 2.0, -1.0, 1.0))))
    title = f"Seats of the scene's bearings, the file turned by {turn:.3f} deg"
    return grid(title, rows).to_text()


def _cut_off(title: str, rows: Sequence[Mapping[str, Any]], count: int) -> str:
    """Table of the first rows of `count`."""
    more = f"\n  and {count - len(rows)} more" if count > len(rows) else ""
    return grid(title, rows).to_text() + more


def _mm(point: np.ndarray) -> str:
    return ", ".join(f"{round(1000 * float(value), 4) + 0.0:.6g}" for value in point)


def _direction(vector: np.ndarray) -> str:
    return ", ".join(f"{round(float(value), 5) + 0.0:.5g}" for value in vector)
