"""Check-up of an imported body: the checks of a structural analyst before use of matrices of another program."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from fem.casing.imported.imported_body import MODAL, ImportedBody
from fem.elements.solids import rigid_body_modes

_SYMMETRIC = 1e-9
_FREE = 1e-7  # of max |K| max |R|
_DENSE = 1500
_MASSLESS = 1e-13  # of the largest value of the shifted problem
_USUAL_MASS = (0.05, 1e5)  # kg, of a housing
_USUAL_DENSITY = 2e4  # kg/m3 of the box around the body; above that of metals
_USUAL_FIRST = (1.0, 1e5)  # Hz, first elastic mode


@dataclass(frozen=True, eq=False, kw_only=True)
class MatrixCheck:
    """Results of the check-up of an imported body, and its errors and warnings as text."""

    equations: int
    nodes: int
    dropped: int
    stiffness_asymmetry: float  # max |K - K^T| over max |K|
    mass_asymmetry: float
    grounding: float  # max |K R| over max |K| max |R|; nan without positions of the nodes
    mass: float  # kg, by R^T M R; nan without positions
    centre: np.ndarray  # (3,) m
    inertia: np.ndarray  # (3, 3) kg m2 about the centre
    frequencies: np.ndarray  # Hz, the lowest, of the body as it was exported
    rigid_modes: int  # number of zero frequencies among them
    wrong: tuple[str, ...]
    doubtful: tuple[str, ...]

    def report(self, count: int = 20) -> str:
        """The check-up as text."""
        lines = [f"Checks of the matrices: {self.equations} equations of {self.nodes} nodes"]
        if self.dropped:
            lines.append(f"  {self.dropped} equations without stiffness and mass were left out")
        lines.append(f"  asymmetry of stiffness {self.stiffness_asymmetry:.1e}, of mass {self.mass_asymmetry:.1e}")
        if np.isfinite(self.mass):
            x, y, z = 1000 * self.centre
            lines.append(f"  force in a rigid-body motion: {self.grounding:.1e} of the largest stiffness")
            lines.append(f"  mass {self.mass:.6g} kg, centre of gravity ({x:.6g}, {y:.6g}, {z:.6g}) mm")
        else:
            lines.append("  node coordinates are not known: mass and supports are not checked")
        lines.append(f"  {self.rigid_modes} modes without stiffness; frequencies as exported, Hz:")
        lines += frequency_lines(self.frequencies[:count])
        lines += [f"  WRONG: {words}" for words in self.wrong] + [f"  doubtful: {words}" for words in self.doubtful]
        lines += [] if self.wrong or self.doubtful else ["  all checks passed"]
        return "\n".join(lines)


def frequency_lines(frequencies: np.ndarray) -> list[str]:
    """Frequencies in Hz to the seven digits that Nastran prints, five in a line."""
    rows = np.array_split(frequencies, -(-len(frequencies) // 5) or 1)
    return ["    " + "  ".join(f"{one:12.7g}" for one in row) for row in rows]


def check_matrices(body: ImportedBody, count: int = 30) -> MatrixCheck:
    """Check up an imported body.

    Parameters
    ----------
    body : with positions of its nodes if mass and grounding are to be checked
    count : number of lowest frequencies
    """
    K, M = body.stiffness, body.mass
    asymmetry = [float(abs(A - A.T).max() / max(abs(A).max(), 1e-300)) for A in (K, M)]
    frequencies, negative = lowest_frequencies(K, M, count)
    elastic = frequencies[frequencies > 1e-3 * max(float(frequencies[-1]), 1e-300)] if len(frequencies) else frequencies
    rigid = len(frequencies) - len(elastic)
    mass, centre, inertia, grounding = math.nan, np.full(3, math.nan), np.full((3, 3), math.nan), math.nan
    if body.located:
        R = rigid_motion(body, np.zeros(3))
        block = R.T @ (M @ R)
        mass = float(np.trace(block[:3, :3]) / 3.0)
        if mass > 0.0:
            centre = np.array([block[1, 5], block[2, 3], block[0, 4]]) / mass
            about = rigid_motion(body, centre)
            inertia = (about.T @ (M @ about))[3:, 3:]
            scale = abs(K).max() * np.maximum(abs(about).max(axis=0), 1e-300)
            grounding = float((abs(K @ about) / scale).max())
    wrong = _wrong(asymmetry, mass, grounding, rigid, negative, _negative_place(body) if negative else "")
    return MatrixCheck(
        equations=K.shape[0],
        nodes=len(body.numbers),
        dropped=body.dropped,
        stiffness_asymmetry=asymmetry[0],
        mass_asymmetry=asymmetry[1],
        grounding=grounding,
        mass=mass,
        centre=centre,
        inertia=inertia,
        frequencies=frequencies,
        rigid_modes=rigid,
        wrong=tuple(words for bad, words in wrong if bad),
        doubtful=tuple(_doubtful(body, mass, elastic)),
    )


def rigid_motion(body: ImportedBody, centre: np.ndarray) -> np.ndarray:
    """Rigid motions (n, 6) about a point; 0 in modal coordinates."""
    found, turning = np.zeros((len(body.node), 6)), np.flatnonzero(body.axis >= 3)
    found[turning, body.axis[turning]] = 1.0
    moving, node = body.displacements
    of_nodes = rigid_body_modes(body.places, centre).reshape(-1, 3, 6)
    found[moving] = of_nodes[node, body.axis[moving]]
    return found


def lowest_frequencies(K: sp.csr_matrix, M: sp.csr_matrix, count: int) -> tuple[np.ndarray, int]:
    """The lowest frequencies (Hz) of K u = omega^2 M u, zeros for rigid modes, and the number of negative omega^2.

    Shift and invert: dense for small bodies, by ARPACK for larger ones, which may not find all negative omega^2. No
    frequencies are found if the stiffness is negative in a direction without mass; then the negative eigenvalues of K
    are counted.
    """
    K, M = 0.5 * (K + K.T), 0.5 * (M + M.T)
    n, least = K.shape[0], 0  # known number of negative omega^2
    if not abs(M).max() > 0.0:
        return np.zeros(0), 0
    if n <= _DENSE:
        found = _dense(K.toarray(), M.toarray())
        if found is None:
            scaled = K.toarray() / max(abs(K).max(), 1e-300)
            return np.zeros(0), int((la.eigvalsh(scaled) < -_SYMMETRIC).sum())
        squares = found
    else:
        from scipy.sparse.linalg import LinearOperator, eigsh

        from fem.numerics.linear_solver import SingularMatrixError, factorize

        shift = -1e-6 * float(abs(K.diagonal()).max() / abs(M.diagonal()).max())
        try:
            solve = LinearOperator((n, n), factorize(K - shift * M).solve)
        except SingularMatrixError:  # indefinite, or without stiffness and mass in some direction
            solve, least = None, int(negative_pivot(K) is not None)
        squares = eigsh(K, k=min(count, n - 2), M=M, sigma=shift, OPinv=solve, return_eigenvectors=False)
    squares = np.sort(squares)[:count]
    noise = 1e-9 * float(abs(squares).max(initial=0.0))
    return np.sqrt(np.maximum(squares, 0.0)) / (2.0 * math.pi), max(least, int((squares < -max(noise, 1.0)).sum()))


def negative_pivot(K: sp.csr_matrix) -> int | None:
    """An unknown with a negative pivot in the Cholesky factorisation of K; None if there is none.

    The diagonal is raised by its `_SYMMETRIC` share, so that a free body has none by rounding.
    """
    from fem.numerics.linear_solver import SingularMatrixError, factorize

    try:
        factorize(K + sp.diags_array(_SYMMETRIC * abs(K.diagonal())))
    except SingularMatrixError as error:
        return error.unknown
    return None


def _dense(K: np.ndarray, M: np.ndarray) -> np.ndarray | None:
    """Squared angular frequencies 1 / m - s, from the eigenvalues m of L^-1 M L^-T with K + s M = L L^T.

    Directions without mass have m = 0 and drop out; condensing them first would lose digits where their stiffness is
    large. The shift s is the smallest of a series from 1 Hz upwards that makes the sum definite; None if there is none.
    """
    for shift in (2.0 * math.pi * 10.0 ** np.arange(7.0)) ** 2:
        A = K + shift * M
        sizes = np.sqrt(np.maximum(np.diag(A), 1e-300))
        scale = np.outer(sizes, sizes)
        try:
            values = la.eigh(M / scale, A / scale, eigvals_only=True)
        except (la.LinAlgError, ValueError):  # not definite, or overflow
            continue
        return 1.0 / values[values > _MASSLESS * values.max()] - shift
    return None


def _wrong(
    asymmetry: list[float], mass: float, grounding: float, rigid: int, negative: int, place: str
) -> Iterator[tuple[bool, str]]:
    """Whether something is wrong, and in what words; mass and grounding are nan without positions of the nodes."""
    for name, value in zip(("stiffness", "mass"), asymmetry, strict=True):
        yield (
            value > _SYMMETRIC,
            (
                f"the {name} matrix is not symmetric ({value:.1e}, limit {_SYMMETRIC:.0e}): it contains gyroscopic "
                "terms, or the file is cut off"
            ),
        )
    yield (
        negative > 0,
        (
            f"{negative} or more modes have negative stiffness{place}: the exporting program has inverted elements or "
            "a negative modulus there, the matrices are those of a loaded or damaged model, or have too few digits"
        ),
    )
    yield (
        grounding > _FREE,
        (
            f"a rigid-body motion needs force ({grounding:.1e} of the largest stiffness, limit {_FREE:.0e}): the body "
            "is held, or the node coordinates are wrong. Export the free body, and state its feet in the scene"
        ),
    )
    loose = f"{rigid} modes have no stiffness, a free body has 6 of them: a part is not connected"
    yield grounding <= _FREE and rigid > 6, loose
    yield mass <= 0.0, "its mass is zero: no densities in the model, or a mass matrix of other equations"


def _negative_place(body: ImportedBody) -> str:
    """Node and axis of an equation with a negative pivot, for a message; "" if it is not known."""
    if (unknown := negative_pivot(body.stiffness)) is None or body.axis[unknown] == MODAL:
        return ""
    axis = ("x", "y", "z", "rotation x", "rotation y", "rotation z")[body.axis[unknown]]
    return f", found at node {body.node[unknown]} along {axis}"


def _doubtful(body: ImportedBody, mass: float, elastic: np.ndarray) -> Iterator[str]:
    if np.isfinite(mass) and mass > 0.0:
        size = np.ptp(body.places, axis=0)
        reduced = bool((body.axis < 0).any())  # its nodes do not span the body
        heavy = not reduced and size.min() > 0.0 and mass / size.prod() > _USUAL_DENSITY
        if heavy or not _USUAL_MASS[0] <= mass <= _USUAL_MASS[1]:
            words = " x ".join(f"{1000 * side:.4g}" for side in size)
            yield f"a mass of {mass:.4g} kg is unusual for a housing of {words} mm: check the units"
    if len(elastic) and not _USUAL_FIRST[0] <= elastic[0] <= _USUAL_FIRST[1]:
        yield f"the first elastic mode at {elastic[0]:.4g} Hz is unusual for a housing: check the units"
