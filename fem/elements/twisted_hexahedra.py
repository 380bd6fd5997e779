"""Linear elasticity of a twisted prism: quadratic hexahedra as the product of a section and an axial mesh.

A body of constant section that rotates by ``twist`` per unit length (twist = 2 pi / lead = tan(beta) / r; 0 for
straight teeth) is described in the frame that rotates with the section, u(x, z) = R(twist z) v(R(-twist z) x, z). With
biquadratic functions N_a of the section and quadratic functions L_i along the axis, v = sum v_ai N_a L_i is the 27-node
hexahedron with exact helicoids as sides. The derivative along the axis is

    D_z (u, v) = d/dz (u, v) + twist (J (u, v) - d/dtheta (u, v)),      D_z w = d/dz w - twist d/dtheta w

(J and d/dtheta as in `fem.elements.sections`), so that the strains of N_a L_i are B_a L_i + N_a L_i' with two matrices
of the section, and the stiffness matrix is a sum of Kronecker products of small integrals,

    K = M x A_00 + D x A_01 + D^T x A_01^T + S x A_11,
    A_mn = int B_m^T C B_n dA,   M = int L L^T,   D = int L L'^T,   S = int L' L'^T dz.

This needs no loop over hexahedra and no quadrature in space: the section is integrated once, with three points in each
direction. The factors N_a and L_i are the nine-node quadrilateral and the three-node line of scikit-fem. Degrees of
freedom are numbered ``(axial node * section nodes + section node) * 3 + component``.
"""

from __future__ import annotations

import numpy as np

from fem.elements.sections import (
    elasticity,
    gauss_grid,
    gauss_line,
    geometry,
    lagrange,
    shape_functions,
    strains_in_space,
)
from fem.numerics.compiled import stored


def turned_blocks(blocks: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """Blocks in other components: frames (elements, 9, 3, 3) have the new unit vectors as columns."""
    turn = np.zeros((len(frames), 9, 3, 9, 3))
    for a in range(9):
        turn[:, a, :, a, :] = frames[:, a]
    whole = turn.reshape(-1, 27, 27)
    return np.asarray(whole.transpose(0, 2, 1) @ blocks @ whole)


def strain_matrices(
    places: np.ndarray, gradients: np.ndarray, values: np.ndarray, twist: float
) -> tuple[np.ndarray, np.ndarray]:
    """Strains (xx, yy, zz, yz, xz, xy) of the section functions and of their axial derivative, (e, q, 6, 27) each.

    Parameters
    ----------
    places, gradients : (e, q, 2) m and (e, q, 9, 2) 1/m, of `fem.elements.sections.geometry`
    values : (q, 9), of `fem.elements.sections.shape_functions` at the same points
    twist : rad/m
    """
    e, q = places.shape[:2]
    along = np.zeros((e, q, 6, 9, 3))
    along[:, :, 2, :, 2] = along[:, :, 3, :, 1] = along[:, :, 4, :, 0] = values
    return strains_in_space(places, gradients, values, twist), along.reshape(e, q, 6, 27)


def section_blocks(
    points: np.ndarray, elements: np.ndarray, young: float, poisson: float, twist: float, filling: np.ndarray
) -> np.ndarray:
    """A_00 (N/m2), A_01 (N/m), A_11 (N) of every element of a section, (3, elements, 27, 27), as defined above.

    Parameters
    ----------
    points : float (nodes, 2), m
    elements : int (elements, 9), tensor order
    young, poisson : Pa, 1
    twist : rad/m
    filling : (elements,) part of the length that is filled with material
    """
    places, gradients, weight = geometry(points, elements)
    weight = weight * filling[:, None]
    values, _ = shape_functions(gauss_grid()[0])
    count = len(elements)
    strains = strain_matrices(places, gradients, values, twist)
    hooke = elasticity(young, poisson, 6)
    stress = [(hooke @ part * weight[..., None, None]).reshape(count, -1, 27) for part in strains]
    rows = [part.reshape(count, -1, 27).transpose(0, 2, 1) for part in strains]
    return np.stack([rows[0] @ stress[0], rows[0] @ stress[1], rows[1] @ stress[1]])


def axial_matrices(ends: np.ndarray) -> np.ndarray:
    """M (m), D (1), S (1/m), (3, nodes, nodes): integrals of quadratic functions along the axis.

    `ends` (elements + 1,) are the element ends in m, ascending.
    """
    nodes = 2 * len(ends) - 1
    x, w = gauss_line(3)
    values, slopes = lagrange(x)
    parts = np.zeros((3, nodes, nodes))
    for k, length in enumerate(np.diff(ends)):
        here = slice(2 * k, 2 * k + 3)
        parts[0, here, here] += values.T @ (w[:, None] * values) * length
        parts[1, here, here] += values.T @ (w[:, None] * slopes)
        parts[2, here, here] += slopes.T @ (w[:, None] * slopes) / length
    return parts


@stored(__file__)
def product_stiffness(section: np.ndarray, axial: np.ndarray, place: np.ndarray, size: int) -> np.ndarray:
    """Dense stiffness matrix (size, size), N/m, of the hexahedra over some section elements and a piece of the axis.

    M x A_00 + D x A_01 + D^T x A_01^T + S x A_11 is added for every element.

    Parameters
    ----------
    section, axial : integrals over these elements and over this piece
    place : int (elements, axial nodes, 27), rows of their unknowns in the matrix; -1 omits one
    size : number of rows
    """
    out, nodes = np.zeros((size, size)), axial.shape[1]
    for e in range(len(place)):
        for i in range(nodes):
            for j in range(max(0, i - 2), min(nodes, i + 3)):
                m, d, turned, s = axial[0, i, j], axial[1, i, j], axial[1, j, i], axial[2, i, j]
                for a in range(27):
                    row = place[e, i, a]
                    if row < 0:
                        continue
                    for b in range(27):
                        column = place[e, j, b]
                        if column >= 0:
                            both = d * section[1, e, a, b] + turned * section[1, e, b, a]
                            out[row, column] += m * section[0, e, a, b] + s * section[2, e, a, b] + both
    return out


def slice_means(ends: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Mean of every axial function over the intervals between `bounds`; (intervals, nodes), rows sum to 1."""
    out = np.zeros((len(bounds) - 1, 2 * len(ends) - 1))
    x, w = gauss_line(2)  # exact: the functions are quadratic inside a piece
    for k, (start, end) in enumerate(zip(ends[:-1], ends[1:], strict=True)):
        low, high = np.clip(bounds[:-1], start, end), np.clip(bounds[1:], start, end)
        place = low[:, None] + (high - low)[:, None] * x
        values, _ = lagrange((place - start) / (end - start))
        out[:, 2 * k : 2 * k + 3] += np.einsum("sq,sqi->si", w * (high - low)[:, None], values)
    return out / np.diff(bounds)[:, None]
