"""The x-z section of a plain housing in nine-node quadrilaterals that follow the outlines of all its parts.

Lines through every face of the box, the cavity and the feet divide the section into rectangles, and these into cells of
the target size. A rectangle around every shaft axis is filled with rings of cells between the circles of its bores and
bosses; radial lines join the outermost circle to the nodes of the rectangle. Nodes between corners are on the true
circles.

Reference: Thompson, Soni & Weatherill (eds.), Handbook of Grid Generation (1999), chapters 3 and 13 (transfinite
interpolation between two boundaries, O-grids in blocks).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fem.casing.geometry.dimensions import Bore, HousingError
from fem.casing.geometry.housing import Housing
from fem.numerics.quadratic_grids import cells_of, with_middles

_SAME = 1e-9  # m: lines and nodes closer than this are merged
_LEAST = 3  # least number of cells along a side of a shaft's rectangle
_MARGIN = 0.6  # target distance from the largest circle to the rectangle, in element sizes


@dataclass(frozen=True)
class ShaftPlace:
    """Circles about one shaft axis: radii of bores and bosses (m, ascending), and the rectangle around them."""

    x: float
    z: float
    radii: tuple[float, ...]
    low: tuple[float, float]
    high: tuple[float, float]


def divided(fixed: Sequence[float], size: float) -> np.ndarray:
    """Lines (n,) through all of `fixed`, spaced by at most `size`.

    Parameters
    ----------
    fixed : m, in any order; equal ones are merged
    size : m
    """
    kept: list[float] = []
    for place in np.sort(fixed):
        if not kept or place - kept[-1] > _SAME:
            kept.append(float(place))
    parts = [np.linspace(a, b, max(1, math.ceil((b - a) / size - 1e-6)) + 1)[:-1] for a, b in pairwise(kept)]
    return np.concatenate([*parts, [kept[-1]]])


def shaft_places(housing: Housing, size: float) -> list[ShaftPlace]:
    """A rectangle around the bosses of every axis, inside the cavity and without overlap.

    Axes whose bosses share a range of z form one row, and their rectangles have the height of the row. Sides that are
    free to move are aligned with the side of a foot if one is near and not in an end wall.

    Parameters
    ----------
    housing : must be plain
    size : m, largest side of an element

    Raises
    ------
    HousingError : flange, ribs, fillets or bolt pads, an axis with a bearing in one wall only, bosses that overlap both
        seen along x and along z, or no room around a boss
    """
    if not housing.plain:
        raise HousingError(
            "hexahedra: the housing has a flange, ribs, fillets or bolt pads, and only boxes and cylinders along y are "
            "extruded; set element = 'tetrahedron-10'"
        )
    axes: dict[tuple[float, float], list[Bore]] = {}
    for bore in housing.bores:
        axes.setdefault((bore.x, bore.z), []).append(bore)
    for (x, z), bores in axes.items():
        if len({bore.side for bore in bores}) < 2:
            raise HousingError(
                f"hexahedra: {bores[0].name} at x = {1000 * x:.6g}, z = {1000 * z:.6g} mm has no bore across from it "
                "on the same axis; set element = 'tetrahedron-10'"
            )
    rows: list[list[tuple[float, float]]] = []
    for axis in sorted(axes, key=lambda one: one[1] - _radius(axes[one])):
        if rows and axis[1] - _radius(axes[axis]) < max(z + _radius(axes[x, z]) for x, z in rows[-1]) + _SAME:
            rows[-1].append(axis)
        else:
            rows.append([axis])
    low, high = housing.cavity
    bottoms = [min(z - _radius(axes[x, z]) for x, z in row) for row in rows]
    tops = [max(z + _radius(axes[x, z]) for x, z in row) for row in rows]
    spans = _apart(bottoms, tops, float(low[2]), float(high[2]), _MARGIN * size, np.zeros(0))
    feet = np.array([corner[0] for foot in housing.foot_boxes().values() for corner in foot])
    feet = feet[(feet > low[0]) & (feet < high[0])]
    places = []
    for row, (bottom, top) in zip(rows, spans, strict=True):
        row.sort()
        sides = _apart(
            [x - _radius(axes[x, z]) for x, z in row],
            [x + _radius(axes[x, z]) for x, z in row],
            float(low[0]),
            float(high[0]),
            _MARGIN * size,
            feet,
        )
        for (x, z), (left, right) in zip(row, sides, strict=True):
            diameters = {d for bore in axes[x, z] for d in (bore.diameter, bore.boss_diameter)}
            radii = tuple(sorted(diameter / 2 for diameter in diameters))
            places.append(ShaftPlace(x, z, radii, (left, bottom), (right, top)))
    return places


def lines_across(places: Sequence[ShaftPlace], axis: int, size: float) -> list[float]:
    """Lines (m) that rectangles need along x (axis 0) or z (axis 1): sides, and thirds for twelve cells around."""
    lines = []
    for place in places:
        low, high = place.low[axis], place.high[axis]
        cells = _LEAST if (high - low) / size < _LEAST else 1
        lines += np.linspace(low, high, cells + 1).tolist()
    return lines


def section(
    places: Sequence[ShaftPlace], x_lines: np.ndarray, z_lines: np.ndarray, *, size: float
) -> tuple[np.ndarray, np.ndarray]:
    """Nine-node quadrilaterals of a section: nodes (n, 2) at x, z and cells (c, 3, 3) of node numbers.

    The corners of a cell are ordered from x towards z.

    Parameters
    ----------
    places : shaft axes with rings of cells; the sides of their rectangles are on the lines
    x_lines, z_lines : m, ascending
    size : m, largest length of a cell along the radius
    """
    x, z = with_middles(x_lines), with_middles(z_lines)
    grid = np.stack(np.meshgrid(x, z, indexing="ij"), axis=2)
    free = np.ones((len(x_lines) - 1, len(z_lines) - 1), bool)
    blocks = []
    for place in places:
        i = np.searchsorted(x_lines, np.array([place.low[0], place.high[0]]) - _SAME)
        j = np.searchsorted(z_lines, np.array([place.low[1], place.high[1]]) - _SAME)
        free[i[0] : i[1], j[0] : j[1]] = False
        blocks.append(grid[2 * i[0] : 2 * i[1] + 1, 2 * j[0] : 2 * j[1] + 1])
    around = [_rings(place, _outline(block), size) for place, block in zip(places, blocks, strict=True)]
    parts, cells, first = [], [], 0
    for block in (grid, *around):
        number = first + np.arange(block[..., 0].size).reshape(block.shape[:2])
        parts.append(block.reshape(-1, 2))
        cells.append(cells_of(number)[free.ravel()] if block is grid else cells_of(number))
        first += number.size
    return _merged(np.concatenate(parts), np.concatenate(cells))


def _radius(bores: Sequence[Bore]) -> float:
    return max(bore.boss_diameter for bore in bores) / 2


def _apart(
    starts: Sequence[float],
    ends: Sequence[float],
    low: float,
    high: float,
    margin: float,
    lines: np.ndarray,
) -> list[tuple[float, float]]:
    """The given intervals, widened by the margin where there is room; close neighbours meet in the middle.

    A margin changes by up to half of itself to end on one of the `lines`.
    """
    for (_, end), (start, _) in pairwise(zip(starts, ends, strict=True)):
        if start - end < _SAME:
            raise HousingError(
                f"hexahedra: two bosses overlap by {1000 * (end - start):.6g} mm seen along x and along z (their "
                "rectangles must not overlap); set element = 'tetrahedron-10'"
            )
    limits = [low, *[0.5 * (end + start) for end, start in zip(ends[:-1], starts[1:], strict=True)], high]
    rooms = [start - limit for start, limit in zip([*starts, np.inf], limits, strict=True)]
    rooms = [min(room, limit - end) for room, limit, end in zip(rooms, limits, [-np.inf, *ends], strict=True)]
    limits = [_moved(limit, lines, min(0.5 * margin, 0.6 * room)) for limit, room in zip(limits, rooms, strict=True)]
    out = []
    for start, end, before, after in zip(starts, ends, limits[:-1], limits[1:], strict=True):
        left = before if start - before < 1.6 * margin else _moved(start - margin, lines, 0.5 * margin)
        right = after if after - end < 1.6 * margin else _moved(end + margin, lines, 0.5 * margin)
        if min(start - left, right - end) < _SAME:
            raise HousingError(
                "hexahedra: a boss touches the floor, the cover or an end wall, which leaves no room for cells around "
                "it; set element = 'tetrahedron-10'"
            )
        out.append((left, right))
    return out


def _moved(place: float, lines: np.ndarray, reach: float) -> float:
    """The nearest of the lines within reach, else `place` itself."""
    near = lines[abs(lines - place) < reach]
    return float(near[abs(near - place).argmin()]) if len(near) else place


def _outline(block: np.ndarray) -> np.ndarray:
    """Nodes (m + 1, 2) around a rectangular block (i, j, 2), from x towards z; the first one is repeated at the end."""
    return np.concatenate([block[:-1, 0], block[-1, :-1], block[:0:-1, -1], block[0, ::-1]])


def _rings(place: ShaftPlace, outline: np.ndarray, size: float) -> np.ndarray:
    """Nodes (radial, around, 2) from the smallest circle to the rectangle."""
    centre = np.array([place.x, place.z])
    angle = np.unwrap(np.arctan2(*(outline - centre).T[::-1]))
    angle[1::2] = 0.5 * (angle[:-1:2] + angle[2::2])
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    circles = centre + with_middles(divided(place.radii, size))[:, None, None] * direction
    outermost = circles[-1]
    distance = np.linalg.norm(outline - outermost, axis=1).mean()
    part = with_middles(divided((0.0, 1.0), size / distance))[1:, None, None]
    return np.concatenate([circles, (1.0 - part) * outermost + part * outline])


def _merged(nodes: np.ndarray, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Merge coincident nodes, drop unused ones, and order the corners of every cell from x towards z."""
    _, first, same = np.unique(np.round(nodes / _SAME).astype(np.int64), axis=0, return_index=True, return_inverse=True)
    cells = same.ravel()[cells]
    used, flat = np.unique(cells, return_inverse=True)
    cells, nodes = flat.reshape(cells.shape), nodes[first][used]
    one, other = nodes[cells[:, 2, 0]] - nodes[cells[:, 0, 0]], nodes[cells[:, 0, 2]] - nodes[cells[:, 0, 0]]
    backwards = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0] < 0.0
    cells[backwards] = cells[backwards].transpose(0, 2, 1)
    return nodes, cells
