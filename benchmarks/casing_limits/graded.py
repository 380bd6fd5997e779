"""Ten-node tetrahedra divided towards the edges at which stresses grow without bound.

Such edges are the re-entrant ones and the rims of clamped faces. At every level each side of an element that begins on
one of them and ends elsewhere is divided at a quarter of its length, by bisecting all elements that share the side: the
elements become thin across the edge and keep their length along it. Sides that join two such edges are halved first.
Parts of a curved element lie where its own map puts them, so that the body stays what it was.

Reference: Bacuta, Nistor & Zikatanov (2007), Improving the rate of convergence of high-order finite elements on
polyhedra II, Numer. Funct. Anal. Optim. 28(7-8), 775-824 (division at a ratio towards edges).
"""

from __future__ import annotations

import numpy as np

from fem.elements.facets import outer_facets
from fem.elements.solid_elements import SOLIDS, shapes

SHARE = 1.0 / 4.0
TEN = SOLIDS["tetrahedron-10"]
PLACES = TEN.library.doflocs  # (10, 3), of the nodes in the reference element
SIDES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])  # corners between which the nodes 4 to 9 lie
_CORNERS = np.column_stack([PLACES[:4], np.ones(4)])
BARYCENTRIC = np.column_stack([PLACES, np.ones(10)]) @ np.linalg.inv(_CORNERS)  # (10, 4), of all nodes
_KEY = 1 << 32
_LEAST_TURN = np.radians(30.0)  # between the faces of an edge: less is a surface that is smooth


def graded(nodes: np.ndarray, elements: np.ndarray, clamped: np.ndarray, levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) and elements (e, 10) of the same body.

    Parameters
    ----------
    nodes, elements : (n, 3) m and (e, 10)
    clamped : bool (n,), nodes that are held
    levels : how often sides are divided
    """
    edges = singular_edges(nodes, elements, clamped)
    corners, places = elements[:, :4].astype(np.int64), nodes[elements]
    on_edge = np.zeros(len(nodes), bool)
    on_edge[_ends(edges)] = True
    sides = np.unique(_keys(corners))
    joining = sides[on_edge[_ends(sides)].all(axis=0)]
    corners, places, on_edge = _bisected(corners, places, np.setdiff1d(joining, edges), on_edge)
    for _ in range(levels):
        sides = np.unique(_keys(corners))
        first, second = on_edge[_ends(sides)]
        corners, places, on_edge = _bisected(corners, places, sides[first != second], on_edge)
    return _numbered(corners, places)


def singular_edges(nodes: np.ndarray, elements: np.ndarray, clamped: np.ndarray) -> np.ndarray:
    """Keys (k,) of the sides of elements that lie on a re-entrant edge or on the rim of a clamped face."""
    import skfem

    facets = outer_facets(nodes, elements)
    _, slopes = shapes(skfem.ElementTriP2(), np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5]]))  # middles of 01, 12, 20
    along = np.einsum("qas,fai->fqsi", slopes, nodes[facets])
    normal = _unit(np.cross(along[:, :, 0], along[:, :, 1])).reshape(-1, 3)
    side = nodes[facets[:, [1, 2, 0]]] - nodes[facets[:, :3]]
    inwards = np.cross(normal, _unit(side.reshape(-1, 3)))  # from the edge into its own facet
    key = _key(facets[:, :3], facets[:, [1, 2, 0]]).ravel()
    one, other = np.argsort(key, kind="stable").reshape(-1, 2).T
    turn = np.arctan2((normal[one] * inwards[other]).sum(axis=1), (normal[one] * normal[other]).sum(axis=1))
    re_entrant = turn > _LEAST_TURN
    held = clamped[facets].all(axis=1).repeat(3)
    return np.unique(key[one[re_entrant | (held[one] != held[other])]])


def _bisected(
    corners: np.ndarray, places: np.ndarray, wanted: np.ndarray, on_edge: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Elements with the sides `wanted` (keys) divided, each time those that are the longest of all their elements.

    Parameters
    ----------
    corners, places : (e, 4) numbers and (e, 10, 3) nodes of the elements
    wanted : (k,) keys
    on_edge : bool (corner,); sides are divided at `SHARE` from the end that is, in the middle if both or none are
    """
    whole: list[tuple[np.ndarray, np.ndarray]] = []
    while len(wanted):
        key = _keys(corners)
        number = np.minimum(np.searchsorted(wanted, key), len(wanted) - 1)
        asked = wanted[number] == key
        touched = asked.any(axis=1)
        whole.append((corners[~touched], places[~touched]))
        corners, places, number, asked = corners[touched], places[touched], number[touched], asked[touched]
        length = np.zeros(len(wanted))
        size = np.linalg.norm(places[:, SIDES[:, 0]] - places[:, SIDES[:, 1]], axis=2)
        np.maximum.at(length, number[asked], size[asked])
        rank = np.argsort(np.lexsort((wanted, -length.round(9))))
        best = np.where(asked, rank[number], len(wanted)).argmin(axis=1)
        chosen = number[np.arange(len(best)), best]
        holders, votes = (np.bincount(some, minlength=len(wanted)) for some in (number[asked], chosen))
        now = votes == holders
        new = len(on_edge) + np.cumsum(now) - 1
        parts = [(corners[~now[chosen]], places[~now[chosen]])]
        for side, (i, j) in enumerate(SIDES):
            own = np.flatnonzero(now[chosen] & (best == side))
            first, second = on_edge[corners[own, i]], on_edge[corners[own, j]]
            at = np.where(first == second, 0.5, np.where(first, SHARE, 1.0 - SHARE))
            for share in np.unique(at):
                some = own[at == share]
                parts += [_half(corners[some], places[some], (i, j), drop, share, new[chosen[some]]) for drop in (i, j)]
        on_edge = np.concatenate([on_edge, np.zeros(int(now.sum()), bool)])
        wanted = wanted[~now]
        corners, places = (np.concatenate(some) for some in zip(*parts, strict=True))
    whole.append((corners, places))
    return np.concatenate([some[0] for some in whole]), np.concatenate([some[1] for some in whole]), on_edge


def _half(
    corners: np.ndarray, places: np.ndarray, side: tuple[int, int], drop: int, share: float, new: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The part of elements in which the corner `new` at a share of a side takes the place of the corner `drop`."""
    own, at = corners.copy(), PLACES[:4].copy()
    own[:, drop] = new
    at[drop] = (1.0 - share) * PLACES[side[0]] + share * PLACES[side[1]]
    values, _ = shapes(TEN.library, (BARYCENTRIC @ at).T)
    return own, np.einsum("qa,eai->eqi", values, places)


def _numbered(corners: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and elements of parts that share corners."""
    used, own = np.unique(corners, return_inverse=True)
    sides, middle = np.unique(_keys(corners), return_inverse=True)
    elements = np.column_stack([own.reshape(corners.shape), len(used) + middle.reshape(-1, 6)])
    nodes = np.empty((len(used) + len(sides), 3))
    nodes[elements] = places
    return nodes, elements


def _keys(corners: np.ndarray) -> np.ndarray:
    """Of the sides (e, 6) of elements."""
    return _key(corners[:, SIDES[:, 0]], corners[:, SIDES[:, 1]])


def _key(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.minimum(one, other).astype(np.int64) * _KEY + np.maximum(one, other)


def _ends(key: np.ndarray) -> np.ndarray:
    """Numbers (2, k) of the corners of sides."""
    return np.stack(np.divmod(key, _KEY))


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
