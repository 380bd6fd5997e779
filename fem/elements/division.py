"""Division of hexahedra, wedges and pyramids into tetrahedra of the same nodes, so that all elements conform.

A quadrilateral is cut along the diagonal through its corner with the lowest number, in the same way for both its
elements. The tetrahedra of an element join its lowest corner to the triangles of the faces without this corner: 6 for a
hexahedron, 3 for a wedge, 2 for a pyramid. Mid-side nodes are kept. The middle of a diagonal is the node in the face if
there is one. Otherwise the shape functions of the face or of the element map its position, so that a curved side stays
curved. Corners are in the order of VTK; mid-side nodes are recognised by their positions.

Reference: Dompierre, Labbe, Vallet & Camarero (1999), How to subdivide pyramids, prisms, and hexahedra into
tetrahedra, Proc. 8th Int. Meshing Roundtable, 195-204.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.elements.solid_elements import SOLIDS, ElementError
from fem.numerics.message_places import in_mm

OFF_MIDDLE = 0.3  # of the edge length: largest distance of a mid-side node from the middle


@dataclass(frozen=True)
class _Shape:
    """Edges and outward faces of an element by its corners."""

    word: str
    edges: tuple[tuple[int, int], ...]
    faces: tuple[tuple[int, ...], ...]

    @property
    def quadrilaterals(self) -> list[tuple[int, ...]]:
        return [face for face in self.faces if len(face) == 4]


_TETRAHEDRON = _Shape(
    "tetrahedra", ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)), ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
)
_PYRAMID = _Shape(
    "pyramids",
    ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)),
    ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
)
_WEDGE = _Shape(
    "wedges",
    ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
)
_HEXAHEDRON = _Shape(
    "hexahedra",
    ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
    (
        (3, 0, 4, 7),
        (1, 2, 6, 5),
        (0, 1, 5, 4),
        (2, 3, 7, 6),
        (0, 3, 2, 1),
        (4, 5, 6, 7),
    ),  # as VTK numbers mid-face nodes
)
_MIRRORED = [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]  # nodes of a tetrahedron of opposite orientation
_SHAPES = {  # corners and shape by the number of nodes
    **dict.fromkeys((4, 10), (4, _TETRAHEDRON)),
    **dict.fromkeys((5, 13, 14), (5, _PYRAMID)),
    **dict.fromkeys((6, 15, 18), (6, _WEDGE)),
    **dict.fromkeys((8, 20, 27), (8, _HEXAHEDRON)),
}


def divided(nodes: np.ndarray, blocks: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """All elements divided into tetrahedra of 4 nodes, or of 10 if the elements have mid-side nodes.

    Parameters
    ----------
    nodes : float (n, 3), mm (the unit matters only in messages)
    blocks : int (e, k) each, the elements of one kind: tetrahedra of 4 or 10 nodes, pyramids of 5, 13 or 14, wedges of
        6, 15 or 18, hexahedra of 8, 20 or 27

    Returns
    -------
    nodes : float (m, 3), the given nodes, then the middles of diagonals
    elements : int (t, 4 or 10)

    Raises
    ------
    ElementError : mixed linear and quadratic elements, misplaced mid-side nodes, triangles on quadrilaterals
    """
    blocks = [np.asarray(block, np.int64) for block in blocks if len(block)]
    quadratic = {block.shape[1] != _SHAPES[block.shape[1]][0] for block in blocks}
    if len(quadratic) > 1:
        counts = ", ".join(f"{len(b)} {_SHAPES[b.shape[1]][1].word} of {b.shape[1]} nodes" for b in blocks)
        raise ElementError(
            f"elements with and without mid-side nodes do not fit together ({counts}); make all of them quadratic"
        )
    blocks = [ordered(nodes, block) for block in blocks]
    _check_conforming(nodes, blocks)
    parts = [_outwards(nodes, _corner_tetrahedra(block)) for block in blocks]
    corners = np.vstack(parts)
    if not quadratic.pop():
        return nodes, corners
    return _with_middles(nodes, blocks, corners)


def described(blocks: Sequence[np.ndarray]) -> str:
    """Numbers of elements of each shape in the blocks, as text."""
    counts: dict[str, int] = {}
    for block in blocks:
        word = _SHAPES[block.shape[1]][1].word
        counts[word] = counts.get(word, 0) + len(block)
    return ", ".join(f"{count} {word}" for word, count in counts.items())


def cut_quadrilaterals(faces: np.ndarray) -> np.ndarray:
    """The triangles (2 f, 3) of quadrilaterals (f, 4), two of each, along the diagonal through the lowest corner."""
    first = faces.argmin(axis=1)
    a, b, c, d = np.take_along_axis(faces, (first[:, None] + np.arange(4)) % 4, axis=1).T
    return np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def ordered(nodes: np.ndarray, block: np.ndarray) -> np.ndarray:
    """Elements of one kind with every node on the edge or face to which VTK assigns it.

    Tetrahedra are reordered if all are inverted.

    Parameters
    ----------
    nodes : (n, 3), mm
    block : (e, k) elements in the order of VTK; some programs write other orders of mid-side and mid-face nodes

    Raises
    ------
    ElementError : misplaced mid-side nodes
    """
    count, shape = _SHAPES[block.shape[1]]
    if block.shape[1] > count:
        order = _mid_sides(nodes, block)
        rest = np.setdiff1d(np.arange(count, block.shape[1]), order)
        if len(rest):
            some = block[_sample(block)]
            corners = [list(face) for face in (*shape.quadrilaterals, range(count))][: len(rest)]
            centres = np.stack([nodes[some[:, own]].mean(axis=1) for own in corners], axis=1)
            rest = _places(nodes, some, rest, centres)
        block = np.column_stack([block[:, :count], block[:, order], block[:, rest]])
    return _outwards(nodes, block) if shape is _TETRAHEDRON else block


def _mid_sides(nodes: np.ndarray, block: np.ndarray) -> np.ndarray:
    """Local numbers of the mid-side nodes of elements of one kind, in the order of the edges of their shape."""
    count, shape = _SHAPES[block.shape[1]]
    ends = nodes[block[:, np.array(shape.edges)]]
    length = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2)
    some = _sample(block)
    order = _places(nodes, block[some], np.arange(count, block.shape[1]), ends.mean(axis=2)[some])
    far = np.linalg.norm(nodes[block[:, order]] - ends.mean(axis=2), axis=2)
    if not (far < OFF_MIDDLE * length).all() or len(set(order.tolist())) < len(order):
        worst = int((far / np.maximum(length, 1e-300)).max(axis=1).argmax())
        raise ElementError(
            f"mid-side nodes do not lie near the middles of their edges (limit {OFF_MIDDLE:g} edge lengths), the worst "
            f"in one of the {shape.word} {_near(nodes, block[worst, :count])}; check the order of the nodes"
        )
    return order


def _sample(block: np.ndarray) -> slice:
    """Some elements, whose order of nodes is that of all."""
    return slice(None, None, 1 + len(block) // 1000)


def _places(nodes: np.ndarray, block: np.ndarray, among: np.ndarray, middles: np.ndarray) -> np.ndarray:
    """Local numbers, out of `among`, of the nodes of elements (e, k) nearest to the middles (e, m, 3)."""
    off = np.linalg.norm(nodes[block[:, among]][:, None] - middles[:, :, None], axis=3)  # (e, m, among)
    size = np.maximum(np.ptp(nodes[block], axis=1).max(axis=1), 1e-300)
    return among[np.median(off / size[:, None, None], axis=0).argmin(axis=1)]


def _check_conforming(nodes: np.ndarray, blocks: Sequence[np.ndarray]) -> None:
    """ElementError for triangles on a quadrilateral, as their diagonal may differ, or for missing pyramids."""
    triangles, quadrilaterals = [np.zeros((0, 3), np.int64)], [np.zeros((0, 4), np.int64)]
    for block in blocks:
        for face in _SHAPES[block.shape[1]][1].faces:
            (triangles if len(face) == 3 else quadrilaterals).append(np.sort(block[:, list(face)], axis=1))
    if len(triangles) == 1 or len(quadrilaterals) == 1:
        return
    loose, open_ones = (_used_once(np.vstack(faces)) for faces in (triangles, quadrilaterals))
    corners = np.vstack([np.delete(open_ones, left_out, axis=1) for left_out in range(4)])
    size = len(nodes)
    shared = loose[np.isin(_key(loose, size), _key(corners, size))]
    if len(shared):
        raise ElementError(
            f"{len(shared)} triangles lie on quadrilaterals of other elements, one {_near(nodes, shared[0])}: "
            "tetrahedra meet hexahedra or wedges there without pyramids in between. Mesh the part with pyramids, or "
            "with tetrahedra alone"
        )
    holes = _pyramidal_holes(loose, open_ones, size)
    if len(holes):
        raise ElementError(
            f"{len(holes)} pyramids are missing between quadrilaterals and tetrahedra, one {_near(nodes, holes[0])}: "
            "gmsh writes none into universal files (.unv). Write the mesh as .msh or .med, or mesh the part with "
            "tetrahedra alone"
        )


def _pyramidal_holes(triangles: np.ndarray, quadrilaterals: np.ndarray, size: int) -> np.ndarray:
    """The outer quadrilaterals (f, 4) under four outer triangles with one common corner."""
    from scipy.sparse import csr_array  # imported here so that commands that only read a scene start sooner

    sides = [(0, 1, 2), (0, 2, 1), (1, 2, 0)]
    apex = np.concatenate([triangles[:, c] for _, _, c in sides])
    key = np.concatenate([triangles[:, a] * size + triangles[:, b] for a, b, _ in sides])
    edges, row = np.unique(key, return_inverse=True)
    upon = csr_array((np.ones(len(row)), (row.ravel(), apex)), shape=(len(edges), size))
    first, second = np.triu_indices(4, 1)
    own = quadrilaterals[:, first] * size + quadrilaterals[:, second]
    at = np.minimum(np.searchsorted(edges, own), len(edges) - 1)
    known = edges[at] == own
    of = csr_array((np.ones(int(known.sum())), (np.nonzero(known)[0], at[known])), shape=(len(own), len(edges)))
    return quadrilaterals[np.unique((of @ upon == 4.0).nonzero()[0])]


def _used_once(faces: np.ndarray) -> np.ndarray:
    unique, uses = np.unique(faces, axis=0, return_counts=True)
    return unique[uses == 1]


def _key(triangles: np.ndarray, size: int) -> np.ndarray:
    """One number for three sorted ones below `size`; exact to two million nodes."""
    return (triangles[:, 0] * size + triangles[:, 1]) * size + triangles[:, 2]


def _corner_tetrahedra(block: np.ndarray) -> np.ndarray:
    """Corners (t, 4) of the tetrahedra of all elements of a block; those of a collapsed side are omitted."""
    count, shape = _SHAPES[block.shape[1]]
    corners = block[:, :count]
    lowest = corners.argmin(axis=1)
    parts = []
    for top in range(count):
        own = corners[lowest == top]
        for face in shape.faces:
            if top in face:
                continue
            outer = own[:, list(face)]
            triangles = outer if len(face) == 3 else cut_quadrilaterals(outer)
            parts.append(np.column_stack([np.tile(own[:, top], len(triangles) // max(len(own), 1)), triangles]))
    found = np.vstack(parts)
    ordered = np.sort(found, axis=1)
    return found[(np.diff(ordered, axis=1) > 0).all(axis=1)]


def _outwards(nodes: np.ndarray, tetrahedra: np.ndarray) -> np.ndarray:
    """The tetrahedra (t, 4 or 10), reordered if all are inverted, as in files with the opposite numbering."""
    corners = nodes[tetrahedra[:, :4]]
    if (np.linalg.det(corners[:, 1:] - corners[:, :1]) >= 0.0).any():
        return tetrahedra
    return tetrahedra[:, _MIRRORED[: tetrahedra.shape[1]]]


def _with_middles(
    nodes: np.ndarray, blocks: Sequence[np.ndarray], corners: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Ten-node tetrahedra: the mid-side nodes of the file, and nodes at the middles of the diagonals."""
    ends, middles = [], []  # pairs of corners, and the node between them
    places = [nodes]
    count = len(nodes)
    for block in blocks:
        for pairs, node, place in _middles(nodes, block):
            ends.append(np.sort(pairs, axis=1))
            if place is not None:
                node = count + np.arange(len(place))
                places.append(place)
                count += len(place)
            middles.append(node)
    every, between = np.vstack(ends), np.concatenate(middles)
    key, first = np.unique(every[:, 0] * len(nodes) + every[:, 1], return_index=True)
    edges = np.sort(corners[:, np.array(SOLIDS["tetrahedron-10"].library.refdom.edges)], axis=2)
    where = np.searchsorted(key, edges[..., 0] * len(nodes) + edges[..., 1])
    return np.vstack(places), np.column_stack([corners, between[first[where]]])


_Middles = tuple[np.ndarray, np.ndarray, np.ndarray | None]


def _middles(nodes: np.ndarray, block: np.ndarray) -> list[_Middles]:
    """Pairs of corners (e, 2) with the nodes (e,) between them, or the positions (e, 3) of missing nodes."""
    count, shape = _SHAPES[block.shape[1]]
    found: list[_Middles] = [
        (block[:, list(edge)], block[:, count + place], None) for place, edge in enumerate(shape.edges)
    ]
    of_edge = {frozenset(edge): count + place for place, edge in enumerate(shape.edges)}
    none = np.zeros(0, np.int64)
    for place, face in enumerate(shape.quadrilaterals):
        own = block[:, list(face)]
        first = own.argmin(axis=1)[:, None]
        diagonal = np.hstack([np.take_along_axis(own, (first + step) % 4, axis=1) for step in (0, 2)])
        in_face = count + len(shape.edges) + place
        if in_face < block.shape[1]:
            found.append((diagonal, block[:, in_face], None))
            continue
        sides = [of_edge[frozenset((face[i], face[(i + 1) % 4]))] for i in range(4)]
        found.append((diagonal, none, 0.5 * nodes[block[:, sides]].sum(axis=1) - 0.25 * nodes[own].sum(axis=1)))
    if shape is _HEXAHEDRON:
        lowest = block[:, :8].argmin(axis=1)
        opposite = np.array([6, 7, 4, 5, 2, 3, 0, 1])[lowest]
        rows = np.arange(len(block))
        diagonal = np.column_stack([block[rows, lowest], block[rows, opposite]])
        if block.shape[1] == 27:
            found.append((diagonal, block[:, 26], None))
        else:
            inside = 0.25 * nodes[block[:, 8:20]].sum(axis=1) - 0.25 * nodes[block[:, :8]].sum(axis=1)
            found.append((diagonal, none, inside))
    return found


def _near(nodes: np.ndarray, corners: np.ndarray) -> str:
    return f"near {in_mm(nodes[corners].mean(axis=0) / 1000)}"
