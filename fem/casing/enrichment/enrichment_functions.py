"""Enrichment functions across the edges of a mesh, for every node on an edge.

Along a chain the section changes little, but its neighbours change: a wall may end, or a foot begin. The functions of a
node vanish on every side that is closed in any element at it, so that the displacement stays continuous.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fem.casing.enrichment.edge_section import EdgeSection
from fem.casing.enrichment.singular_edges import Chain, Fan, Sector, Topology

ALONG = (0.0, 0.5, 1.0)  # s of the nodes of a fan
_IN_PLANE, _ALONG_EDGE = 3, 1  # largest numbers of functions of a node


def profiles(
    topology: Topology,
    chain: Chain,
    clamped: np.ndarray,
    poisson_ratio: float,
    known: dict[bytes, list[np.ndarray]],
) -> list[list[np.ndarray]]:
    """Functions of the nodes of a chain: values (sector, function, 3, k, k) on the graded grids of a fan's elements.

    The components are along the first face of the fan, across it, and along the edge (`Topology.frame`). Node 2 n + k
    of the chain is node k (0, 1 or 2) of fan n.

    Parameters
    ----------
    topology, chain : of the mesh
    clamped : bool (face,)
    poisson_ratio : of the material
    known : functions of sections of the same mesh by their keys; new ones are added to it
    """
    count, out = len(chain.fans), []
    closed = np.array([[_closed(topology, fan, number) for number in range(len(fan.sectors))] for fan in chain.fans])
    found: dict[bytes, list[np.ndarray]] = {}
    for number in range(2 * count + 1):
        beside = [number // 2] if number % 2 else [number // 2 - 1, number // 2]
        own = [fan % count for fan in beside if chain.closed or 0 <= fan < count]
        here = np.asarray(closed[own].any(axis=0))
        if (at := here.tobytes()) not in found:
            alike = [fan for fan in range(count) if (closed[fan] == here).all()] or own
            section = edge_section(topology, chain.fans[alike[len(alike) // 2]], here, clamped)
            if (key := section.key) not in known:
                known[key] = list(section.functions(poisson_ratio, _IN_PLANE, _ALONG_EDGE))
            found[at] = known[key]
        out.append(found[at])
    return out


def edge_section(topology: Topology, fan: Fan, closed: np.ndarray, clamped: np.ndarray) -> EdgeSection:
    """The section across a fan and its ring, half-way along the edge.

    Parameters
    ----------
    topology, fan : of the mesh
    closed : bool (sector, 4)
    clamped : bool (face,)
    """
    sectors = [*fan.sectors, *_ring(topology, fan)]
    frame = topology.frame(fan.sectors[0], 0.5)
    origin = topology.points(fan.sectors[0], np.array([[0.0], [0.0], [0.5]]))
    at = np.array([[x, y, 0.5] for x in ALONG for y in ALONG]).T
    points = np.array([(topology.points(sector, at) - origin) @ frame[:, :2] for sector in sectors])
    faces = np.array([_faces(topology, sector) for sector in sectors])
    _, number, times = np.unique(faces, return_inverse=True, return_counts=True)
    alone = times[number].reshape(faces.shape) == 1
    held = clamped[faces]
    return EdgeSection(
        points=points.reshape(-1, 3, 3, 2),
        corners=np.array([_parallel_sides(topology, sector) for sector in sectors]),
        sides=faces,
        fan=len(fan.sectors),
        closed=closed,
        clamped=held,
        loaded=alone & ~held & (~topology.outer[faces] | (topology.patch[faces] >= 0)),
        middles=topology.kind.nodes == 27,
    )


def _ring(topology: Topology, fan: Fan) -> list[Sector]:
    """Elements that share a side along the edge with those of a fan."""
    known = {sector.element for sector in fan.sectors}
    found = []
    for side in sorted({side for sector in fan.sectors for row in _parallel_sides(topology, sector) for side in row}):
        for user in topology.users(side):
            if user[0] not in known:
                known.add(user[0])
                found.append(topology.sector(*user))
    return found


def _closed(topology: Topology, fan: Fan, number: int) -> list[bool]:
    """Whether functions vanish on the four sides of a sector: towards elements outside the fan and on patches."""
    faces = _faces(topology, fan.sectors[number])
    out = [not topology.outer[face] or topology.patch[face] >= 0 for face in faces]
    if number + 1 < len(fan.sectors):
        out[0] = False  # xi = 0 is eta = 0 of the next
    if number:
        out[2] = False
    return out


def _faces(topology: Topology, sector: Sector) -> list[int]:
    return [topology.face_at(sector, direction, end) for direction in (0, 1) for end in (0, 1)]


def _parallel_sides(topology: Topology, sector: Sector) -> Sequence[Sequence[int]]:
    """Numbers (2, 2) of the sides of an element along s, by xi and eta."""
    return [[topology.side_along(sector, x, y) for y in (0, 1)] for x in (0, 1)]
