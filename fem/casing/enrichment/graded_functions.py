"""Quadratic functions along a line, on one element and on a grid graded towards its start, and their products."""

from __future__ import annotations

import numpy as np

from fem.elements.sections import lagrange
from fem.numerics.quadratic_grids import with_middles

GRID = np.array([0.0, 0.01, 0.06, 0.3, 1.0])  # cells from an edge to the far side of an element
NODES = with_middles(GRID)  # coordinates (k,) of the nodes of quadratic cells on it
GAUSS = 3  # points in a cell: exact to degree 5


def graded(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and slopes (q, k) of the functions of NODES at x (q,) in 0 .. 1."""
    cell = np.clip(np.searchsorted(GRID, x, side="right") - 1, 0, len(GRID) - 2)
    width = np.diff(GRID)[cell]
    value, slope = lagrange((x - GRID[cell]) / width)
    values, slopes = np.zeros((2, len(x), 2 * len(GRID) - 1))
    place = 2 * cell[:, None] + np.arange(3)
    np.put_along_axis(values, place, value, axis=1)
    np.put_along_axis(slopes, place, slope / width[:, None], axis=1)
    return values, slopes


def gauss(cuts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and weights (q,) of `GAUSS` points in every cell between the cuts."""
    at, weight = np.polynomial.legendre.leggauss(GAUSS)
    width = np.diff(cuts)
    places = cuts[:-1, None] + width[:, None] * 0.5 * (1.0 + at)
    return places.ravel(), (0.5 * width[:, None] * weight).ravel()


def products(
    first: tuple[np.ndarray, np.ndarray], second: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Values (q, a, b) and slopes (q, a, b, 2) of products of functions of xi and of eta at the same points."""
    (x, dx), (y, dy) = first, second
    values = x[:, :, None] * y[:, None, :]
    return values, np.stack([dx[:, :, None] * y[:, None, :], x[:, :, None] * dy[:, None, :]], axis=3)


def nine_nodes(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values (q, 3, 3) and slopes (q, 3, 3, 2) of a quadrilateral of nine nodes at xi, eta."""
    return products(lagrange(x), lagrange(y))


def eight_nodes(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """As `nine_nodes`, without the node in the middle: its function is shared among the others."""
    values, slopes = nine_nodes(x, y)
    share = np.array([[-0.25, 0.5, -0.25], [0.5, -1.0, 0.5], [-0.25, 0.5, -0.25]])
    return values + share * values[:, 1:2, 1:2], slopes + share[:, :, None] * slopes[:, 1:2, 1:2]
