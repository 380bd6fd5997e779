"""Linear elasticity of a section with nine-node quadrilaterals: plane strain, or a helical body reduced to its section.

Straight teeth (twist = 0): plane strain, two displacement components. A helical body has the same load in every section
if the load follows the helix. Its displacement then rotates with the section, u(x, z) = R(twist z) u(R(-twist z) x), so
that d/dz is a derivative in the section,

    d/dz (u, v) = twist (J (u, v) - d/dtheta (u, v)),   d/dz w = -twist d/dtheta w,   d/dtheta = x d/dy - y d/dx,

J = [[0, -1], [1, 0]], and three-dimensional elasticity becomes a problem in the section alone with the three
components (u, v, w). twist = 2 pi / lead = tan(beta) / r. For twist = 0 the axial component w decouples and is omitted.

Elements are isoparametric and biquadratic (the nine-node quadrilateral of scikit-fem), with three Gauss points in each
direction. Degrees of freedom are numbered ``components * node + component``.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from fem.elements.solid_elements import ElementError, rule, shapes


def lagrange(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quadratic functions of the nodes 0, 1/2, 1 of a line and their derivatives at ``s``; both of shape (..., 3)."""
    from skfem import ElementLineP2

    s = np.asarray(s, dtype=float)
    values, slopes = shapes(ElementLineP2(), s.reshape(1, -1))
    start, end, middle = range(3)
    order = [start, middle, end]
    return values[:, order].reshape(*s.shape, 3), slopes[:, order, 0].reshape(*s.shape, 3)


def gauss_line(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss rule on the unit line: points and weights (count,)."""
    from skfem import ElementLineP2

    points, weights = rule(ElementLineP2(), 2 * count - 1)
    return points[0], weights


def gauss_grid(order: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Tensor Gauss rule on the unit square: points (order^2, 2), weights (order^2,)."""
    from skfem import ElementQuad2

    points, weights = rule(ElementQuad2(), 2 * order - 1)
    return points.T, weights


def shape_functions(local: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Biquadratic functions (q, 9) and their local derivatives (q, 9, 2) at ``local`` (q, 2) in the unit square.

    Node 3 i + j of an element is at (s, t) = (i / 2, j / 2).
    """
    from skfem import ElementQuad2

    values, slopes = shapes(ElementQuad2(), local.T)
    order = np.argsort(_tensor_places())
    return values[:, order], slopes[:, order]


def _tensor_places() -> np.ndarray:
    """Index (9,) of every node of scikit-fem's nine-node quadrilateral in tensor order."""
    from skfem import ElementQuad2

    return (2 * ElementQuad2.doflocs @ [3, 1]).astype(int)


def geometry(points: np.ndarray, elements: np.ndarray, order: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Quadrature of a mesh: positions (e, q, 2), gradients of shape functions (e, q, 9, 2), weights (e, q) in m2.

    Raises
    ------
    ElementError : the Jacobian is not positive at a quadrature point
    """
    from skfem import MeshQuad2

    local, weight = gauss_grid(order)
    mesh = MeshQuad2(np.array(points.T, order="C"), np.array(elements[:, _tensor_places()].T, order="C"))
    mapping = mesh.mapping()
    places = mapping.F(local.T).transpose(1, 2, 0)
    determinant = np.linalg.det(mapping.DF(local.T).transpose(2, 3, 0, 1))
    if (determinant <= 0).any():
        element = int(np.argmin(determinant.min(axis=1)))
        raise ElementError(
            f"section mesh: {int((determinant <= 0).any(axis=1).sum())} of {len(elements)} elements are turned inside "
            f"out, the worst is element {element} near {places[element].mean(axis=0)} m (Jacobian must be positive). "
            "Check the tooth profile or change the mesh refinement."
        )
    gradients = np.einsum("qas,sieq->eqai", shape_functions(local)[1], mapping.invDF(local.T), optimize=True)
    return places, gradients, determinant * weight


def strain_operator(places: np.ndarray, gradients: np.ndarray, values: np.ndarray, twist: float) -> np.ndarray:
    """Matrix B (e, q, strain, 9 * components) with the engineering strains of every shape function.

    Strains: (xx, yy, xy) in plane strain, (xx, yy, zz, yz, xz, xy) for twist != 0.

    Parameters
    ----------
    places, gradients : (e, q, 2) m and (e, q, 9, 2) 1/m, of `geometry`
    values : (q, 9), of `shape_functions` at the same points
    twist : rad/m, 0 for plane strain
    """
    if twist != 0.0:
        return strains_in_space(places, gradients, values, twist)
    e, q = places.shape[:2]
    dx, dy = gradients[..., 0], gradients[..., 1]
    b = np.zeros((e, q, 3, 9, 2))
    b[:, :, 0, :, 0], b[:, :, 1, :, 1] = dx, dy
    b[:, :, 2, :, 0], b[:, :, 2, :, 1] = dy, dx
    return b.reshape(e, q, 3, 18)


def strains_in_space(places: np.ndarray, gradients: np.ndarray, values: np.ndarray, twist: float) -> np.ndarray:
    """Engineering strains (xx, yy, zz, yz, xz, xy) of three components that rotate with the section: (e, q, 6, 27).

    Parameters
    ----------
    places, gradients, values, twist : those of `strain_operator`
    """
    e, q = places.shape[:2]
    dx, dy = gradients[..., 0], gradients[..., 1]
    around = twist * (places[..., :1] * dy - places[..., 1:] * dx)  # twist d/dtheta
    b = np.zeros((e, q, 6, 9, 3))
    b[:, :, 0, :, 0], b[:, :, 1, :, 1] = dx, dy
    b[:, :, 2, :, 2] = -around
    b[:, :, 3, :, 2], b[:, :, 3, :, 1], b[:, :, 3, :, 0] = dy, -around, twist * values
    b[:, :, 4, :, 2], b[:, :, 4, :, 0], b[:, :, 4, :, 1] = dx, -around, -twist * values
    b[:, :, 5, :, 0], b[:, :, 5, :, 1] = dy, dx
    return b.reshape(e, q, 6, 27)


def elasticity(young: float, poisson: float, strains: int) -> np.ndarray:
    """Hooke's matrix (strains, strains) in Pa for 3 (plane strain) or 6 strains."""
    shear = young / (2 * (1 + poisson))
    lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    normal = 2 if strains == 3 else 3
    hooke = np.diag([2 * shear] * normal + [shear] * (strains - normal))
    hooke[:normal, :normal] += lame
    return hooke


def stiffness(
    points: np.ndarray,
    elements: np.ndarray,
    young: float,
    poisson: float,
    twist: float = 0.0,
    filling: np.ndarray | None = None,
) -> sparse.csc_matrix:
    """Stiffness matrix per unit length, N/m2, of shape (components * nodes, components * nodes).

    Parameters
    ----------
    points : float (nodes, 2), m
    elements : int (elements, 9), tensor order (see `shape_functions`)
    young, poisson : Pa, 1
    twist : rad/m, 0 for plane strain (2 components), otherwise 3 components
    filling : (elements,) share of the length filled with material, as by a web; None: 1
    """
    places, gradients, weight = geometry(points, elements)
    if filling is not None:
        weight = weight * filling[:, None]
    values, _ = shape_functions(gauss_grid()[0])
    b = strain_operator(places, gradients, values, twist)
    e, q, strains, columns = b.shape
    stress = np.matmul(elasticity(young, poisson, strains), b) * weight[..., None, None]
    flat = (e, q * strains, columns)
    blocks = np.matmul(b.reshape(flat).transpose(0, 2, 1), stress.reshape(flat))
    components = columns // 9
    dofs = (components * elements[:, :, None] + np.arange(components)).reshape(e, columns)
    size = components * len(points)
    rows = np.broadcast_to(dofs[:, :, None], blocks.shape).ravel()
    cols = np.broadcast_to(dofs[:, None, :], blocks.shape).ravel()
    return sparse.csc_matrix((blocks.ravel(), (rows, cols)), shape=(size, size))
