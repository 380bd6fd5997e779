"""Functions for the displacement of the two cut faces of a sector: products of functions of radius and face coordinate.

A solid body has polynomials in the radius, zero at the bore, times Legendre polynomials along the face. The cut face of
a rim on a web has three parts (rim above the web, rim next to it, web), and its displacement has a kink between them.
There the functions are piecewise continuous polynomials, as of one large element per part (Szabo & Babuska, Finite
Element Analysis, 1991, section 6.1): a hat function at every joint and integrated Legendre polynomials between. Those
of the rim decrease linearly within the web to zero at the bore, so that rim and web conform.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.elements.nested_condensation import Ties


@dataclass(frozen=True, eq=False, kw_only=True)
class CutFunctions:
    """Number of polynomials on a cut face, by radius and along the face; None uses every node of that direction.

    radial, axial : of a solid body
    rim, web : degrees in the radius on rim and web
    along : degree along the face on each part of it, next to and above the web
    """

    radial: int | None = 5
    axial: int | None = 7
    rim: int = 4
    web: int = 4
    along: int = 4


CUT = CutFunctions()


def cut_ties(
    cut: CutFunctions, side: np.ndarray, at: np.ndarray, radius: np.ndarray, bore: float, place: np.ndarray
) -> Ties:
    """Ties of the nodes of both cuts of a solid body.

    Parameters
    ----------
    cut : numbers of functions
    side : int (section nodes,), 0 and 1 on the cuts, -1 elsewhere
    at : int (section nodes,), index of a node in `radius`
    radius : (cut nodes,) m, descending from the root, without the bore
    bore : radius, m
    place : (axial nodes,) m, ascending
    """
    height = (radius - bore) / (radius[0] - bore)
    legendre = np.polynomial.legendre.legvander
    across, along = np.eye(len(radius)), np.eye(len(place))
    if cut.radial is not None and cut.radial < len(radius):
        across = height[:, None] * legendre(2 * height - 1, cut.radial - 1)
    if cut.axial is not None and cut.axial < len(place):
        along = legendre(2 * (place - place[0]) / (place[-1] - place[0]) - 1, cut.axial - 1)
    return _ties(side, at, across, along, np.ones((len(radius), len(place)), dtype=bool))


def webbed_ties(
    cut: CutFunctions,
    side: np.ndarray,
    at: np.ndarray,
    radius: np.ndarray,
    bore: float,
    place: np.ndarray,
    rim: float,
    web: tuple[float, float],
) -> Ties:
    """Ties of the nodes of both cuts of a rim on a web.

    Parameters
    ----------
    cut, side, at, radius, bore, place : those of `cut_ties`
    rim : inner radius of the rim, m
    web : ends of the web along the axis, m, both among `place`
    """
    tiny = 1e-9 * (place[-1] - place[0])
    filled = (radius > rim - tiny)[:, None] | ((place > web[0] - tiny) & (place < web[1] + tiny))
    across, along = np.eye(len(radius)), np.eye(len(place))
    if cut.radial is not None:
        across = piecewise(radius, np.array([bore, rim, radius[0]]), (cut.web, cut.rim))[:, 1:]  # no motion at the bore
    if cut.axial is not None:
        joints = np.unique(np.clip([place[0], *web, place[-1]], place[0], place[-1]))
        joints = joints[np.append(True, np.diff(joints) > tiny)]
        along = piecewise(place, joints, (cut.along,) * (len(joints) - 1))
    return _ties(side, at, across, along, filled)


def piecewise(place: np.ndarray, joints: np.ndarray, degrees: tuple[int, ...]) -> np.ndarray:
    """Piecewise continuous polynomials (place, functions): hat functions at the joints, then those that vanish there.

    A part with too few points for its degree gets a lower one.

    Parameters
    ----------
    place : (place,) within the joints
    joints : (parts + 1,) ascending
    degrees : of every part, at least 1
    """
    found = [np.interp(place, joints, hat) for hat in np.eye(len(joints))]
    tiny = 1e-9 * (joints[-1] - joints[0])
    for low, high, degree in zip(joints[:-1], joints[1:], degrees, strict=True):
        inside = (place > low + tiny) & (place < high - tiny)
        x = 2 * (place - low) / (high - low) - 1
        for n in range(2, min(degree, int(inside.sum()) + 1) + 1):
            series = np.polynomial.Legendre.basis(n) - np.polynomial.Legendre.basis(n - 2)
            found.append(np.where(inside, series(x), 0.0))
    return np.column_stack(found)


def _ties(side: np.ndarray, at: np.ndarray, across: np.ndarray, along: np.ndarray, filled: np.ndarray) -> Ties:
    """Ties with the products that are not zero on all existing nodes, `filled` (cut node, axial node)."""
    used = (across != 0).T.astype(float) @ filled @ (along != 0) > 0
    of_node = np.where((side >= 0)[:, None], across[at], 0.0)
    return Ties(side=side, across=of_node, along=along, used=used)
