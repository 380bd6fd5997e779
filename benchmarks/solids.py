"""Small solids that benchmarks and tests share: boxes of any solid element, straight, distorted or bent."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from fem.elements.facets import outer_facets
from fem.elements.solid_elements import SOLIDS, converted


def box_mesh(
    size: Sequence[float],
    divisions: Sequence[int],
    *,
    element: str = "tetrahedron-10",
    distortion: float = 0.0,
    seed: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) and elements (e, k) of a box from the origin; a cell is a hexahedron or six tetrahedra (Kuhn's cut).

    `distortion` moves interior corners by up to this part of a cell; mid-sides stay in the middle.
    """
    counts = np.array(divisions) + 1
    axes = [np.linspace(0.0, length, count) for length, count in zip(size, counts, strict=True)]
    corners = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    if distortion:
        inner = ((corners > 0) & (corners < np.array(size))).all(axis=1)
        move = np.random.default_rng(seed).uniform(-distortion, distortion, corners.shape)
        corners[inner] += (move * np.array(size) / np.array(divisions))[inner]
    index = np.arange(counts.prod()).reshape(counts)

    def at(start: Sequence[int]) -> np.ndarray:
        return index[tuple(slice(s, s + d) for s, d in zip(start, divisions, strict=True))].ravel()

    if element.startswith("hexahedron"):
        cells = np.column_stack([at(start) for start in SOLIDS[element].library.refdom.p.T.astype(int)])
        return converted(corners, cells, SOLIDS[element])
    tets = []
    for order in itertools.permutations(range(3)):
        step, path = np.zeros(3, int), [np.zeros(3, int)]
        for axis in order:
            step = step + np.eye(3, dtype=int)[axis]
            path.append(step)
        if np.linalg.det(np.array(path[1:]) - path[0]) < 0:
            path[1], path[2] = path[2], path[1]
        tets.append(np.column_stack([at(start) for start in path]))
    return converted(corners, np.vstack(tets), SOLIDS[element])


def facets_on(nodes: np.ndarray, elements: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Outer facets (f, k) all of whose nodes are in the boolean mask `chosen` (n,)."""
    facets = outer_facets(nodes, elements)
    return facets[chosen[facets].all(axis=1)]


def unknowns(nodes: np.ndarray) -> np.ndarray:
    """Unknown numbers of node numbers."""
    return (3 * np.asarray(nodes)[:, None] + np.arange(3)).ravel()
