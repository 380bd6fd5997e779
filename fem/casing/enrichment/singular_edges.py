"""Where functions are added: edges of a mesh at which stresses are singular, and the fans of elements around them.

Such edges are the re-entrant edges and the rims of clamped faces. A fan is the set of elements around one side (element
edge) on such an edge, ordered from one face of the body to the other. Consecutive fans form a chain. A chain has one
system of local coordinates: xi along the first face of every element, eta along the second, s along the edge.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from fem.casing.enrichment.topology import Sector, Topology

_NOTHING = 1e-9  # of the largest value of a function
_LEAST_TURN = np.radians(30.0)  # least excess of a re-entrant angle over 180 degrees; below it the surface is smooth


@dataclass(frozen=True, eq=False)
class Fan:
    """The elements around one side of an element, from face to face; s runs from the first vertex to the second."""

    vertices: tuple[int, int]
    sectors: tuple[Sector, ...]

    def turned(self) -> Fan:
        """The fan from its last face to its first."""
        return Fan(self.vertices, tuple(sector.turned() for sector in self.sectors[::-1]))

    def backwards(self) -> Fan:
        """The fan with s reversed."""
        return Fan(self.vertices[::-1], tuple(sector.backwards() for sector in self.sectors))


@dataclass(frozen=True, eq=False)
class Chain:
    """Consecutive fans; closed if the last one joins the first."""

    fans: tuple[Fan, ...]
    closed: bool


def chains(topology: Topology, clamped: np.ndarray) -> list[Chain]:
    """All chains at edges where stresses are singular.

    Parameters
    ----------
    topology : of the mesh
    clamped : bool (face,)
    """
    fans = [fan for side in singular_sides(topology, clamped) if (fan := _fan(topology, int(side))) is not None]
    at_end: dict[tuple[int, ...], list[int]] = defaultdict(list)
    for number, fan in enumerate(fans):
        for end in (0, 1):
            at_end[_end(topology, fan, end)].append(number)
    left, found = set(range(len(fans))), []
    while left:
        chain = [fans[left.pop()]]
        for _ in (0, 1):  # onwards, then from the other end
            while following := [n for n in at_end[_end(topology, chain[-1], 1)] if n in left]:
                left.remove(following[0])
                chain.append(_continued(topology, chain[-1], fans[following[0]]))
            chain = [fan.backwards() for fan in chain[::-1]]
        closed = len(chain) > 2 and _end(topology, chain[-1], 1) == _end(topology, chain[0], 0)
        found.append(Chain(tuple(chain), closed))
    return found


def continuation(topology: Topology, fan: Fan, end: int, values: list[np.ndarray]) -> list[Sector | None] | None:
    """Elements beyond the end of a chain into which its functions continue and decay; None if that is not possible.

    It is possible if the functions vanish, or the body ends, on every side towards an element outside the chain.

    Parameters
    ----------
    topology, fan, end : the last fan of a chain and which of its vertices is the end
    values : (function, 3, k, k) of every sector

    Returns
    -------
    the element beyond every sector, None where the body ends
    """
    if any(topology.patch[topology.face_at(sector, 2, end)] >= 0 for sector in fan.sectors):
        return None
    behind = [topology.beyond(sector, end) for sector in fan.sectors]
    for number, sector in enumerate(behind):
        if sector is None:
            continue
        own = values[number]
        lines = {(0, 0): own[:, :, 0], (0, 1): own[:, :, -1], (1, 0): own[..., 0], (1, 1): own[..., -1]}
        for (direction, side), line in lines.items():
            face = topology.face_at(sector, direction, side)
            neighbour = {(0, 0): number + 1, (1, 0): number - 1}.get((direction, side), -1)
            other = behind[neighbour] if 0 <= neighbour < len(behind) else None
            if other is not None and face == topology.face_at(other, 1 - direction, 0):
                continue
            if abs(line).max() > _NOTHING and not (topology.outer[face] and topology.patch[face] < 0):
                return None
    return behind


def singular_sides(topology: Topology, clamped: np.ndarray) -> np.ndarray:
    """Numbers of the sides (element edges) on re-entrant edges and on rims of clamped faces.

    Parameters
    ----------
    topology : of the mesh
    clamped : bool (face,)
    """
    faces, held = np.zeros((2, len(topology.ends)), int)  # number of faces of the body at each side
    for axis in range(3):
        for place, across in enumerate(one for one in range(3) if one != axis):
            number = topology.face[:, across]  # (e, side)
            sides = topology.side[:, axis] if place == 0 else topology.side[:, axis].transpose(0, 2, 1)
            for counts, flags in ((faces, topology.outer), (held, topology.outer & clamped)):
                np.add.at(counts, sides[flags[number]].ravel(), 1)
    angle = np.bincount(topology.side.ravel(), topology.angles().ravel(), len(topology.ends))
    return np.flatnonzero((faces == 2) & ((held == 1) | ((held == 0) & (angle > np.pi + _LEAST_TURN))))


def _end(topology: Topology, fan: Fan, end: int) -> tuple[int, ...]:
    """The first or the second vertex of a fan and the faces across the edge there, in order of their numbers."""
    return (fan.vertices[end], *sorted(topology.face_at(sector, 2, end) for sector in fan.sectors))


def _continued(topology: Topology, last: Fan, fan: Fan) -> Fan:
    """A fan reoriented so that it begins where the last one ends."""
    if _end(topology, fan, 0) != _end(topology, last, 1):
        fan = fan.backwards()
    first, before = fan.sectors[0], last.sectors[0]
    return fan if topology.node(first, (1.0, 0.0, 0.0)) == topology.node(before, (1.0, 0.0, 1.0)) else fan.turned()


def _fan(topology: Topology, side: int) -> Fan | None:
    """The elements around a side in order; None if they do not form one fan."""
    members = {user[0]: topology.sector(*user) for user in topology.users(side)}
    at_face = defaultdict(list)
    for sector in members.values():
        for direction in (0, 1):
            at_face[topology.face_at(sector, direction, 0)].append(sector.element)
    face = min((number for number, users in at_face.items() if len(users) == 1), default=None)
    ordered: list[Sector] = []
    while face is not None and (following := [element for element in at_face[face] if element in members]):
        sector = members.pop(following[0])
        ordered.append(sector if topology.face_at(sector, 1, 0) == face else sector.turned())  # it begins with xi
        face = topology.face_at(ordered[-1], 0, 0)
    if members or not ordered:
        return None
    return Fan((int(topology.ends[side, 0]), int(topology.ends[side, 1])), tuple(ordered))
