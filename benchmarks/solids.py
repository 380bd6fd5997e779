"""Small solids that benchmarks and tests share: boxes cut into quadratic tetrahedra, straight, distorted or bent."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from fem.elements.tetrahedra import EDGES


def box_mesh(
    size: Sequence[float], divisions: Sequence[int], *, distortion: float = 0.0, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) and tet10 (e, 10) of a box from the origin; every cell gives six tetrahedra (Kuhn's cut).

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
    tets = []
    for order in itertools.permutations(range(3)):
        step, path = np.zeros(3, int), [np.zeros(3, int)]
        for axis in order:
            step = step + np.eye(3, dtype=int)[axis]
            path.append(step)
        if np.linalg.det(np.array(path[1:]) - path[0]) < 0:
            path[1], path[2] = path[2], path[1]
        window = [
            index[tuple(slice(s, s + d) for s, d in zip(start, divisions, strict=True))].ravel() for start in path
        ]
        tets.append(np.column_stack(window))
    return quadratic(corners, np.vstack(tets))


def quadratic(corners: np.ndarray, tets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Add mid-side nodes to linear tetrahedra; negative ones are turned round."""
    volume = np.linalg.det(corners[tets[:, 1:]] - corners[tets[:, :1]])
    tets = np.where((volume < 0)[:, None], tets[:, [1, 0, 2, 3]], tets)
    pairs = np.sort(tets[:, EDGES].reshape(-1, 2), axis=1)
    unique, number = np.unique(pairs, axis=0, return_inverse=True)
    nodes = np.vstack([corners, corners[unique].mean(axis=1)])
    return nodes, np.hstack([tets, len(corners) + number.reshape(-1, 6)])


def facets_on(nodes: np.ndarray, elements: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Six-node facets (f, 6) all of whose nodes are in the boolean mask `chosen` (n,)."""
    sides = [(0, 1, 2, 4, 5, 6), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (0, 2, 3, 6, 9, 7)]
    found = [elements[:, list(side)] for side in sides]
    return np.vstack([f[chosen[f].all(axis=1)] for f in found])


def unknowns(nodes: np.ndarray) -> np.ndarray:
    """Unknown numbers of node numbers."""
    return (3 * np.asarray(nodes)[:, None] + np.arange(3)).ravel()
