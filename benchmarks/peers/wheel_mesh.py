"""A whole gear wheel in 20-node hexahedra: fine teeth where it meshes, coarse ones around the rest, one body.

Fine and coarse sectors meet on a cut through a tooth space. There the fine nodes follow the coarse faces by linear
constraints (the shape functions of the 8-node face), so no stress is lost and no sector is left out.

Lengths mm, as the decks are written.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.peers.tooth_mesh import Profile, Sector, Sizes, sector
from fem.gears.gear import Gear

Constraint = tuple[int, np.ndarray, np.ndarray]  # dependent node, independent nodes, weights
# corners and middles of the 8-node face in (depth, station), and of the hexahedron in (radial, around, face)
CORNERS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0)])
HEXAHEDRON = np.array(
    [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
    + [(1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2)]
    + [(0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)]
)
LOADED_FACE = 5  # face of a tooth element on the loaded flank, in the numbering of CalculiX


@dataclass(frozen=True, eq=False, kw_only=True)
class WheelMesh:
    """Nodes (n, 3) in mm with the gear axis along z, elements (m, 20) into them, the nodes of the bore, the elements
    (from 0) of every loaded flank by tooth pair number, and the constraints between fine and coarse sectors."""

    nodes: np.ndarray
    elements: np.ndarray
    bore: np.ndarray
    flanks: dict[int, np.ndarray]
    constraints: list[Constraint]


@dataclass(frozen=True, eq=False)
class _Block:
    """Nodes and elements of one sector, and where its lattices sit."""

    points: np.ndarray
    elements: np.ndarray
    flank: np.ndarray
    body: np.ndarray  # node numbers of the body lattice, -1 where there is none
    of: Sector


def wheel_mesh(
    gear: Gear,
    centre_angle: Callable[[int, np.ndarray], np.ndarray],
    contact: dict[int, np.ndarray],
    fine: Sizes,
    coarse: Sizes,
    *,
    falling: bool,
    missing: int | None = None,
    ends: dict[int, np.ndarray] | None = None,
) -> WheelMesh:
    """Mesh a gear.

    Parameters
    ----------
    centre_angle : (pair number, face coordinates in m) -> angle of the tooth centre (rad)
    contact : pair numbers (neighbours) whose teeth are fine, with the roll length of the contact line (m) at the face
        stations of the fine sizes
    falling : tooth angles fall with the pair number
    missing : pair number of a tooth that is broken off at the middle of its fillet
    ends : ends of the rows on the involute (row, station), m, by pair number, where they do not follow the contact line
    """
    profile = Profile(gear)
    numbers = sorted(contact)
    others = range(numbers[-1] + 1, numbers[0] + gear.teeth)
    blocks: dict[int, _Block] = {}
    shared = sector(profile, coarse)
    for number in (*numbers, *others):
        if number in contact:
            part = sector(profile, fine, profile.arc_of_roll(contact[number]), (ends or {}).get(number))
        else:
            part = shared
        blocks[number] = _block(gear, part, centre_angle, number, whole=number != missing)
    start, offset = {}, 0
    for number, block in blocks.items():
        start[number], offset = offset, offset + len(block.points)
    points = np.vstack([block.points for block in blocks.values()])
    is_fine = np.concatenate([np.full(len(b.points), n in contact) for n, b in blocks.items()])
    unique = _merged(points, is_fine)
    elements = np.vstack([blocks[n].elements + start[n] for n in blocks])
    counts = np.cumsum([0] + [len(b.elements) for b in blocks.values()])
    flanks = {n: b.flank + counts[i] for i, (n, b) in enumerate(blocks.items()) if n in contact and b.flank.size}
    bore = np.unique(unique[np.concatenate([_present(b.body[-1]) + start[n] for n, b in blocks.items()])])
    constraints: list[Constraint] = []
    for edge, neighbour, after in ((numbers[-1], others[0], True), (numbers[0], others[-1], False)):
        low = after == falling  # the fine sector is cut at its low angle
        own, mate = blocks[edge], blocks[neighbour]
        own_cut, mate_cut = own.body[:, 0 if low else -1], mate.body[:, -1 if low else 0]
        for node, nodes, weights in _hanging(own, mate, own_cut, mate_cut):
            constraints.append((int(unique[node + start[edge]]), unique[nodes + start[neighbour]], weights))
    used, compact = np.unique(unique, return_inverse=True)
    place = np.full(len(points), -1)
    place[used] = np.arange(used.size)
    return WheelMesh(
        nodes=points[used] * 1000.0,
        elements=compact[elements],
        bore=place[bore],
        flanks=flanks,
        constraints=[(int(place[d]), place[i], w) for d, i, w in constraints],
    )


def _block(
    gear: Gear, part: Sector, centre_angle: Callable[[int, np.ndarray], np.ndarray], number: int, *, whole: bool
) -> _Block:
    """The hexahedra of a sector at its place."""
    turn = centre_angle(number, part.station * gear.face_width)
    height = part.station * gear.face_width
    shape, tooth_shape = part.body_radius.shape, part.tooth_radius.shape
    ids = np.arange(part.body_radius.size).reshape(shape)
    tooth = np.empty(tooth_shape, dtype=int)
    tooth[0] = ids[0, part.first : part.first + tooth_shape[1]]
    tooth[1:] = ids.size + np.arange(part.tooth_radius[1:].size).reshape(part.tooth_radius[1:].shape)
    radius = np.concatenate([part.body_radius.ravel(), part.tooth_radius[1:].ravel()])
    angle = np.concatenate([(part.body_angle + turn).ravel(), (part.tooth_angle[1:] + turn).ravel()])
    tall = np.concatenate([np.broadcast_to(height, shape).ravel(), np.broadcast_to(height, tooth[1:].shape).ravel()])
    elements = _hexahedra(ids[::-1])
    flank = np.empty(0, dtype=int)
    if whole:
        teeth = _hexahedra(tooth)
        rows, columns, faces = ((n - 1) // 2 for n in tooth_shape)
        grid = np.arange(len(teeth)).reshape(rows, columns, faces)
        flank = len(elements) + grid[part.contact_row // 2 :, -1, :].ravel()
        elements = np.vstack([elements, teeth])
    used, compact = np.unique(elements, return_inverse=True)
    place = np.full(radius.size, -1)
    place[used] = np.arange(used.size)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), tall])[used]
    return _Block(points, compact.reshape(elements.shape), flank, place[ids], part)


def _hexahedra(ids: np.ndarray) -> np.ndarray:
    """Elements (m, 20) of a lattice (radial outwards, around, face) with odd counts."""
    windows = np.lib.stride_tricks.sliding_window_view(ids, (3, 3, 3))[::2, ::2, ::2]
    return windows.reshape(-1, 3, 3, 3)[:, HEXAHEDRON[:, 0], HEXAHEDRON[:, 1], HEXAHEDRON[:, 2]]


def _present(ids: np.ndarray) -> np.ndarray:
    return ids[ids >= 0]


def _merged(points: np.ndarray, is_fine: np.ndarray) -> np.ndarray:
    """Number of the node that stands for each node: coincident ones become one, fine and coarse stay apart."""
    unique = np.arange(len(points))
    for group in (is_fine, ~is_fine):
        members = np.flatnonzero(group)
        pairs = cKDTree(points[members]).query_pairs(1e-9, output_type="ndarray")
        np.minimum.at(unique, members[pairs.max(axis=1)], members[pairs.min(axis=1)])
    return unique


def _hanging(own: _Block, mate: _Block, own_cut: np.ndarray, mate_cut: np.ndarray) -> list[Constraint]:
    """Constraints of the nodes of a fine cut (layers, face), those of the bore excepted, to the coarse cut."""
    out: list[Constraint] = []
    for i, depth in enumerate(own.of.depth[:-1]):
        for j, station in enumerate(own.of.station):
            if own_cut[i, j] < 0:
                continue
            a, x = _local(mate.of.depth[::2], depth)
            b, y = _local(mate.of.station[::2], station)
            nodes = mate_cut[2 * a + 1 + CORNERS[:, 0], 2 * b + 1 + CORNERS[:, 1]]
            weights = _serendipity(x, y)
            keep = np.abs(weights) > 1e-12
            out.append((int(own_cut[i, j]), nodes[keep], weights[keep]))
    return out


def _local(ends: np.ndarray, value: float) -> tuple[int, float]:
    """Element of a division and the coordinate in it, -1 .. 1."""
    element = int(np.clip(np.searchsorted(ends, value, side="right") - 1, 0, len(ends) - 2))
    return element, 2.0 * (value - ends[element]) / (ends[element + 1] - ends[element]) - 1.0


def _serendipity(x: float, y: float) -> np.ndarray:
    """Shape functions (8,) of the quadratic face in the order of CORNERS."""
    a, b = CORNERS[:4].T
    corner = (1 + a * x) * (1 + b * y) * (a * x + b * y - 1) / 4.0
    middle = np.array([(1 - x * x) * (1 - y), (1 + x) * (1 - y * y), (1 - x * x) * (1 + y), (1 - x) * (1 - y * y)])
    return np.concatenate([corner, middle / 2.0])
