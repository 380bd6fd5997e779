"""Quality of solid elements: it is measured, curved elements are straightened, inverted ones refused with their place.

Signed inverse condition number of the map from the ideal element (edges W) to the element (Jacobian J):

    SICN = 3 sign(det S) / (|S| |S^-1|),   S = J W^-1,   Frobenius norms

1 is equilateral (a cube), 0 flat, below 0 inverted. Straight tetrahedra have one J. Other elements are evaluated at the
points of a lattice, and their Jacobian determinant, a polynomial, is bounded from below over the whole element by its
Bezier coefficients: of degree 3 in a ten-node tetrahedron, 5 along each side of a quadratic hexahedron. Edge ratio:
longest over shortest edge between corners.

References: Freitag & Knupp (2002), Int. J. Numer. Meth. Engng 53, 1377-1391 (condition number); Johnen, Remacle &
Geuzaine (2013), J. Comput. Phys. 233, 359-372 (Bezier bounds).
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import cache
from itertools import product
from math import comb, factorial

import numpy as np

from fem.casing.mesh.mesh import MeshError
from fem.elements.solid_elements import curved, shapes, solid_element, straight_places
from fem.numerics.message_places import in_mm

_log = logging.getLogger(__name__)

QUALITY_LIMIT = 0.05  # least SICN
GOOD_QUALITY = 0.1  # below it a mesh is improved before it is refused
EDGE_RATIO_LIMIT = 50.0
_TURNS = 12  # steps of straightening; the last three straighten edges completely
_CHUNK = 131072  # points evaluated together

_REGULAR = np.array([[1.0, 0.5, 0.5], [0.0, np.sqrt(3.0) / 2.0, np.sqrt(3.0) / 6.0], [0.0, 0.0, np.sqrt(2.0 / 3.0)]])


@dataclass(frozen=True, eq=False)
class Quality:
    """Quality of every element: SICN, least Jacobian bound over that of the straight element, edge ratio."""

    sicn: np.ndarray  # (element,)
    jacobian: np.ndarray  # (element,), <= 0 where inversion is not excluded
    edge_ratio: np.ndarray  # (element,)


def measure(nodes: np.ndarray, elements: np.ndarray) -> Quality:
    """Quality of all elements; nodes (n, 3) in m, elements (e, k) of one of `fem.elements.solid_elements.SOLIDS`."""
    kind = solid_element(elements)
    tetrahedral = kind.corners == 4
    sicn, jacobian = np.empty(len(elements)), np.ones(len(elements))
    bent = curved(nodes, elements) if tetrahedral else np.ones(len(elements), bool)
    lattice, to_bezier = _lattice() if tetrahedral else _tensor_lattice()
    ideal = np.linalg.inv(_REGULAR) if tetrahedral else np.eye(3)
    for chosen, points in ((np.flatnonzero(~bent), np.full((1, 3), 0.25)), (np.flatnonzero(bent), lattice)):
        _, slopes = shapes(kind.library, points.T)
        for part in np.array_split(chosen, len(chosen) * len(points) // _CHUNK + 1):
            J = np.einsum("ead,qar->eqdr", nodes[elements[part]], slopes, optimize=True)
            determinant = np.linalg.det(J)
            sicn[part] = _sicn(J @ ideal).min(axis=1)
            if len(points) > 1:
                straight = np.einsum("ead,qar->eqdr", straight_places(nodes, elements[part]), slopes, optimize=True)
                volume = np.linalg.det(straight).mean(axis=1)
                with np.errstate(divide="ignore", invalid="ignore"):
                    jacobian[part] = np.nan_to_num((determinant @ to_bezier.T).min(axis=1) / volume, nan=-1.0)
    first, second = np.transpose(kind.library.refdom.edges)
    edges = np.linalg.norm(nodes[elements[:, first]] - nodes[elements[:, second]], axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.nan_to_num(edges.max(axis=1) / edges.min(axis=1), nan=np.inf, posinf=np.inf)
    return Quality(sicn, jacobian, ratio)


def straightened(nodes: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """The nodes, with mid-side nodes of badly curved ten-node tetrahedra moved towards the middle of their edges.

    Where elements are large for the radius of a surface (a fillet, a small hole), a curved face can fold the element or
    nearly so. The curvature of these elements alone is reduced by a third at a time until their quality is sufficient.
    Only their corners are then on the surface, an error of second order in the element size.
    """
    mended = nodes
    for turn in range(_TURNS):
        found = measure(mended, elements)
        bad = ((found.sicn < GOOD_QUALITY) | (found.jacobian < GOOD_QUALITY)) & curved(mended, elements)
        if not bad.any():
            break
        if mended is nodes:
            mended = nodes.copy()
        _log.info("casing mesh: %d curved elements are straightened", int(bad.sum()))
        middles = elements[bad, 4:].ravel()
        straight = straight_places(mended, elements[bad])[:, 4:].reshape(-1, 3)
        share = 1.0 if turn >= _TURNS - 3 else 1.0 / 3.0
        mended[middles] = share * straight + (1.0 - share) * mended[middles]
    return mended


def checked_quality(nodes: np.ndarray, elements: np.ndarray, remedy: str) -> float:
    """The worst SICN of a mesh, after a check that every element is within the limits.

    Raises
    ------
    MeshError : inverted, flat, or needle-like elements: their number, and value and position of the worst
    """
    found = measure(nodes, elements)
    shape = "tetrahedra" if solid_element(elements).corners == 4 else "hexahedra"
    inverted = found.sicn <= 0.0
    if inverted.any():
        raise MeshError(
            f"casing mesh: {int(inverted.sum())} of {len(elements)} {shape} are inverted (negative Jacobian), the "
            f"worst with SICN {found.sicn.min():.3g} {_place(nodes, elements, int(found.sicn.argmin()))}. {remedy}"
        )
    checks = (
        ("quality (SICN)", found.sicn, QUALITY_LIMIT, found.sicn < QUALITY_LIMIT),
        ("a Jacobian that may fall", found.jacobian, 0.0, found.jacobian <= 0.0),
        ("an inverse edge ratio", 1.0 / found.edge_ratio, 1.0 / EDGE_RATIO_LIMIT, found.edge_ratio > EDGE_RATIO_LIMIT),
    )
    for name, values, limit, bad in checks:
        if bad.any():
            raise MeshError(
                f"casing mesh: {int(bad.sum())} of {len(elements)} {shape} have {name} below {limit:g} (worst "
                f"{values.min():.3g} {_place(nodes, elements, int(values.argmin()))}). {remedy}"
            )
    return float(found.sicn.min())


def _place(nodes: np.ndarray, elements: np.ndarray, element: int) -> str:
    return f"near {in_mm(nodes[elements[element, : solid_element(elements).corners]].mean(axis=0))}"


def _sicn(S: np.ndarray) -> np.ndarray:
    """3 sign(det) / (|S| |S^-1|); with the adjugate, |S^-1| = |adj S| / |det S|, flat elements give 0."""
    a, b, c = S[..., 0], S[..., 1], S[..., 2]
    adjugate = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
    determinant = np.einsum("...i,...i->...", a, np.cross(b, c))
    size = np.linalg.norm(S, axis=(-2, -1)) * np.linalg.norm(adjugate, axis=(-2, -1))
    return 3.0 * determinant / np.maximum(size, np.finfo(float).tiny)


@cache
def _lattice() -> tuple[np.ndarray, np.ndarray]:
    """The 20 points (20, 3) of the cubic lattice, and the matrix from values there to Bezier coefficients."""
    powers = np.array([p for p in product(range(4), repeat=4) if sum(p) == 3])
    barycentric = powers / 3.0
    weights = np.array([6.0 / np.prod([factorial(k) for k in p]) for p in powers])
    bernstein = weights * np.prod(barycentric[:, None, :] ** powers[None, :, :], axis=2)
    return barycentric[:, 1:], np.linalg.inv(bernstein)


@cache
def _tensor_lattice() -> tuple[np.ndarray, np.ndarray]:
    """`_lattice` on a cube: 6^3 points (216, 3) for polynomials of degree 5 along each side."""
    places = np.linspace(0.0, 1.0, 6)
    bernstein = np.array([[comb(5, k) * x**k * (1.0 - x) ** (5 - k) for k in range(6)] for x in places])
    to_bezier = np.linalg.inv(bernstein)
    return np.array(list(product(places, repeat=3))), np.kron(np.kron(to_bezier, to_bezier), to_bezier)
