"""Decomposition of a body with a mirror plane into a symmetric and an antisymmetric half.

A reflection S (S S = 1) maps the unknowns of such a body and its interface onto themselves, S K S = K, S M S = M and
B S = R B. Motions with S u = u and with S u = -u are then uncoupled:

    u = Q_s q_s + Q_a q_a,   u_b = C_s v_s + C_a v_a,   K_h = Q_h^T K Q_h,   M_h = Q_h^T M Q_h,   B_h = C_h^T B Q_h

Each half has half of the unknowns and about half of the modes; its factor has less than half of the entries, and both
are computed in parallel. On the plane an unknown moves in only one half. In the other it is kept with a stiffness,
without coupling and mass, so that every node has three unknowns.

Reference: Bossavit (1986), Comput. Methods Appl. Mech. Eng. 56(2), 167-215 (symmetry of boundary value problems).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from scipy.spatial import cKDTree

from fem.casing.reduced.lanczos import block_lanczos
from fem.casing.reduced.reduction import Interface, Reduction, held_interface, largest_entry
from fem.casing.reduced.sturm_count import reduce_and_count
from fem.numerics.linear_solver import Factor, Solver
from fem.numerics.memory import give_back
from fem.numerics.side_by_side import side_by_side
from fem.numerics.unknowns import unknowns_of

Result = TypeVar("Result")

_SAME = 1e-7  # of the size of the body: a node this close to the image of another is its image
_ROUNDING = 1e-10  # relative tolerance of products that should be equal
_NO_LOAD = 1e-13  # share of the load of a body below which the load of a half is round-off
_SHARE = 0.6  # of the requested modes: first number computed in each half


@dataclass(frozen=True, eq=False)
class Half:
    """One of the two halves, with its interface."""

    motions: sp.csr_matrix  # Q (n, n_h), orthonormal columns; 0 for unknowns at rest
    coordinates: np.ndarray  # C (b, b_h), orthonormal
    stiffness: Callable[[], sp.csr_matrix]  # K (n_h, n_h), computed at every call: it is half as large as the factor
    M: sp.csr_matrix
    interface: Interface


@dataclass(frozen=True, eq=False)
class MirroredInterface(Interface):
    """The interface of a body, factorised by halves."""

    halves: tuple[Half, Half]

    @property
    def whole(self) -> Interface:
        """The interface without the matrices of the halves."""
        return Interface(self.factor, self.rows, self.constraint, self.stiffness)


@dataclass(frozen=True, eq=False)
class _Reflection:
    """S u = sign * u[image], and the numbers of the unknowns on one side of the plane (or on it)."""

    image: np.ndarray
    sign: np.ndarray
    kept: np.ndarray

    def __call__(self, u: np.ndarray) -> np.ndarray:
        return self.sign * u[self.image]

    def share(self, parity: float) -> np.ndarray:
        """Entries of Q (n_h,) at the kept unknowns; 0 for those at rest."""
        alone = self.image[self.kept] == self.kept
        return np.where(alone, np.where(self.sign[self.kept] == parity, 1.0, 0.0), math.sqrt(0.5))

    def motions(self, parity: float) -> sp.csr_matrix:
        """Q of the motions with S u = parity u."""
        k, own, image = np.arange(len(self.kept)), self.share(parity), self.image[self.kept]
        other = np.where(image == self.kept, 0.0, own * parity * self.sign[self.kept])
        place = np.concatenate([self.kept, image]), np.concatenate([k, k])
        Q = sp.csr_matrix((np.concatenate([own, other]), place), shape=(len(self.image), len(k)))
        Q.eliminate_zeros()
        return Q


@dataclass(frozen=True, eq=False)
class Places:
    """Positions of the unknowns u: three at every node, then the added ones."""

    nodes: np.ndarray  # (n, 3), m
    functions: np.ndarray  # (m, 3), m, those of `fem.casing.enrichment.added_unknowns.AddedUnknowns`
    numbers: np.ndarray  # (m,)


def interface_of(
    places: Places | None,
    K: sp.csr_matrix,
    M: sp.csr_matrix,
    rows: sp.csr_matrix,
    *,
    expansion: sp.csr_matrix,
    penalty: np.ndarray | None = None,
    solver: Solver = "auto",
) -> Interface:
    """`held_interface` of E^T K E, by halves if the body has a mirror plane normal to an axis.

    Parameters
    ----------
    places : positions of the unknowns u; None: no search for a mirror plane
    K, M : sparse (u, u), stiffness and mass in SI
    rows, penalty, solver : those of `held_interface`
    expansion : E (u, n), a selection of unknowns if `places` are given

    Raises
    ------
    as `held_interface`
    """
    chosen = choice_of(expansion)
    if chosen is None:
        return held_interface(sp.csr_matrix(expansion.T @ K @ expansion), rows, penalty=penalty, solver=solver)
    for axis in range(3):
        reflection = None if places is None else _reflection(places, axis, K, chosen)
        if reflection is None or not all(_unchanged(matrix, reflection, expansion) for matrix in (K, M)):
            continue
        turned = _of_interface(rows, reflection)
        stiffness = np.zeros(rows.shape[0]) if penalty is None else penalty
        if turned is not None and np.allclose(turned * stiffness, stiffness[:, None] * turned):
            return _mirrored(reflection, turned, K, M, expansion, rows, penalty, solver)
    return held_interface(sp.csr_matrix(K[chosen][:, chosen]), rows, penalty=penalty, solver=solver)


def choice_of(expansion: sp.csr_matrix) -> np.ndarray | None:
    """Numbers (n,) of the unknowns u that E (u, n) selects; None if it combines some."""
    return expansion.tocsc().indices if expansion.nnz == expansion.shape[1] else None


def reduced_and_counted(
    interface: Interface,
    whole: Callable[[], tuple[sp.csr_matrix, sp.csr_matrix]],
    *,
    highest: float,
    enrich: bool = True,
) -> tuple[Reduction, int]:
    """`reduce_and_count`, by halves if the body has them.

    Parameters
    ----------
    interface, highest, enrich : those of `reduce_body`
    whole : returns K and M of the undivided body, if needed

    Raises
    ------
    EigenError : the number of modes differs from the Sturm-sequence count; or see `reduce_body`
    """
    if not isinstance(interface, MirroredInterface):
        return reduce_and_count(interface, *whole(), highest=highest, enrich=enrich)

    def reduced(half: Half) -> tuple[Reduction, int]:
        return reduce_and_count(half.interface, half.stiffness(), half.M, highest=highest, enrich=enrich)

    (one, first), (other, second) = _by_halves(reduced, interface)
    give_back()
    return _joined(interface, one, other), first + second


def lowest(interface: Interface, whole: Callable[[], sp.csr_matrix], count: int) -> tuple[np.ndarray, np.ndarray]:
    """The lowest natural modes of a body with free interface and definite stiffness.

    Parameters
    ----------
    interface : of the body, without penalty
    whole : returns M (n, n) of the undivided body, if needed
    count : number of modes

    Returns
    -------
    theta = 1 / omega^2 (count,), descending, in s2, and vectors (n, count), orthonormal in M

    Raises
    ------
    EigenError : no convergence
    """
    if not isinstance(interface, MirroredInterface):
        return block_lanczos(interface.factor.solve, whole(), count=count)
    found = _lowest_of_halves(interface, math.ceil(_SHARE * count))
    theta = np.concatenate([values for values, _ in found])
    order = np.argsort(-theta)[:count]
    if theta[order[-1]] < max(values[-1] for values, _ in found):  # one half may have further modes above it
        found = _lowest_of_halves(interface, count)
        theta = np.concatenate([values for values, _ in found])
        order = np.argsort(-theta)[:count]
    vectors = [half.motions @ modes for half, (_, modes) in zip(interface.halves, found, strict=True)]
    return theta[order], np.hstack(vectors)[:, order]


def _lowest_of_halves(interface: MirroredInterface, count: int) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    return _by_halves(lambda half: block_lanczos(half.interface.factor.solve, half.M, count=count), interface)


def _by_halves(work: Callable[[Half], Result], interface: MirroredInterface) -> tuple[Result, Result]:
    one, other = interface.halves
    return side_by_side(lambda: work(one), lambda: work(other))


def _reflection(places: Places, axis: int, K: sp.csr_matrix, chosen: np.ndarray) -> _Reflection | None:
    """The reflection of the chosen unknowns about the centre of the body; None if some have no image."""
    low, high = places.nodes.min(axis=0), places.nodes.max(axis=0)
    near = _SAME * float(np.linalg.norm(high - low))
    nodes = places.nodes
    image = _images(nodes, low[axis] + high[axis], axis, near)
    numbered = np.column_stack([places.functions, places.numbers])  # the number separates those of one node
    other = _images(numbered, low[axis] + high[axis], axis, near)
    if image is None or other is None:
        return None
    sign = np.ones((len(nodes), 3))
    sign[:, axis] = -1.0
    across = nodes[:, axis] - nodes[image, axis]
    kept = np.flatnonzero((across < 0.0) | (image == np.arange(len(nodes))))
    kept_functions = np.flatnonzero((numbered[:, axis] < numbered[other, axis]) | (other == np.arange(len(other))))
    if 2 * len(kept) < len(nodes) or 2 * len(kept_functions) < len(other):
        return None
    first = 3 * len(nodes)
    images = np.concatenate([unknowns_of(image), first + other])
    signs = np.concatenate([sign.ravel(), _signs(K, unknowns_of(image), sign.ravel(), other)])
    number = np.full(len(images), -1)
    number[chosen] = np.arange(len(chosen))
    own_images, own_kept = number[images[chosen]], number[np.concatenate([unknowns_of(kept), first + kept_functions])]
    if own_images.min(initial=0) < 0:
        return None
    return _Reflection(own_images, signs[chosen], own_kept[own_kept >= 0])


def _images(points: np.ndarray, twice: float, axis: int, near: float) -> np.ndarray | None:
    """Numbers of the points at the reflected positions; None if one is missing."""
    mirrored = points.copy()
    mirrored[:, axis] = twice - points[:, axis]
    if not len(points):
        return np.zeros(0, int)
    distance, image = cKDTree(points).query(mirrored, distance_upper_bound=near)
    if not np.isfinite(distance).all() or (image[image] != np.arange(len(points))).any():
        return None
    return np.asarray(image)


def _signs(K: sp.csr_matrix, image: np.ndarray, sign: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Sign (1 or -1) of a reflected added function relative to its image, from the forces of both on the nodes."""
    n = len(image)
    forces = K[n:, :n]
    reflected = forces[:, image] @ sp.diags_array(sign)
    product = np.asarray(reflected.multiply(forces[other]).sum(axis=1)).ravel()
    return np.where(product < 0.0, -1.0, 1.0)


def _unchanged(matrix: sp.csr_matrix, reflection: _Reflection, expansion: sp.csr_matrix) -> bool:
    """Whether S A S = A of A = E^T matrix E, by products with a random vector."""
    x = np.random.default_rng(0).standard_normal(expansion.shape[1])
    reflected, product = (expansion.T @ (matrix @ (expansion @ some)) for some in (reflection(x), x))
    return bool(abs(reflected - reflection(product)).max() <= _ROUNDING * largest_entry(matrix) * np.linalg.norm(x))


def _of_interface(rows: sp.csr_matrix, reflection: _Reflection) -> np.ndarray | None:
    """R of B S = R B, None if there is no such matrix or it is not a reflection."""
    B = rows.toarray()
    turned = B[:, reflection.image] * reflection.sign
    gram = B @ B.T
    R = la.solve(gram, B @ turned.T, assume_a="pos").T if len(B) else gram
    if abs(R @ B - turned).max(initial=0.0) > _ROUNDING * abs(B).max(initial=0.0) or not np.allclose(R, R.T):
        return None
    return 0.5 * (R + R.T)


def _mirrored(
    reflection: _Reflection,
    turned: np.ndarray,
    K: sp.csr_matrix,
    M: sp.csr_matrix,
    expansion: sp.csr_matrix,
    rows: sp.csr_matrix,
    penalty: np.ndarray | None,
    solver: Solver,
) -> MirroredInterface:
    value, vector = la.eigh(turned)
    largest, kept = float(K.diagonal().max()), expansion.tocsc().indices[reflection.kept]

    def held(parity: float) -> Half:
        Q, C, share = reflection.motions(parity), vector[:, value * parity > 0.0], reflection.share(parity)
        scale = np.divide(1.0, share, out=np.zeros_like(share), where=share > 0.0)
        in_body = sp.csr_matrix(expansion @ Q)

        def of_half(matrix: sp.csr_matrix) -> sp.csr_matrix:
            """Q_i^T A Q_j = A_i Q_j / share_i: the images of the rows give the same products."""
            found = sp.csr_matrix(matrix[kept] @ in_body)
            found.data *= np.repeat(scale, np.diff(found.indptr))
            return found

        def stiffness() -> sp.csr_matrix:
            return sp.csr_matrix(of_half(K) + sp.diags_array(np.where(share > 0.0, 0.0, largest)))

        own_K, own_M = stiffness(), of_half(M)
        give_back()
        own_rows = sp.csr_matrix(C.T @ (rows @ Q).toarray())
        own_penalty = None if penalty is None else np.einsum("ij,i,ij->j", C, penalty, C)
        return Half(Q, C, stiffness, own_M, held_interface(own_K, own_rows, penalty=own_penalty, solver=solver))

    halves = side_by_side(lambda: held(1.0), lambda: held(-1.0))

    solvers = tuple((half.motions, half.interface.factor.solve) for half in halves)  # only these are kept by `solve`

    def solve(b: np.ndarray) -> np.ndarray:
        def of(motions: sp.csr_matrix, inverse: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
            loads, out = motions.T @ columns, np.zeros(columns.shape)
            acts = np.linalg.norm(loads, axis=0) > _NO_LOAD * sizes  # most loads are those of one half
            out[:, acts] = motions @ inverse(loads[:, acts])
            return out

        columns = b.reshape(len(b), -1)
        sizes = np.linalg.norm(columns, axis=0)

        one, other = side_by_side(lambda: of(*solvers[0]), lambda: of(*solvers[1]))
        return (one + other).reshape(b.shape)

    return MirroredInterface(
        factor=Factor(
            f"{halves[0].interface.factor.name}, by symmetric and antisymmetric halves", expansion.shape[1], solve
        ),
        rows=rows,
        constraint=sum(half.motions @ (half.interface.constraint @ half.coordinates.T) for half in halves),
        stiffness=sum(half.coordinates @ half.interface.stiffness @ half.coordinates.T for half in halves),
        halves=halves,
    )


def _joined(interface: MirroredInterface, *reductions: Reduction) -> Reduction:
    """The reduction of the whole body from those of its halves."""
    b = len(interface.stiffness)
    mass, between, frequencies, late = np.zeros((b, b)), [], [], []
    for half, own in zip(interface.halves, reductions, strict=True):
        C, own_b = half.coordinates, half.coordinates.shape[1]
        mass += C @ own.mass[:own_b, :own_b] @ C.T
        between.append(C @ own.mass[:own_b, own_b:])
        frequencies.append(own.frequencies)
        late.append(np.arange(len(own.frequencies)) >= own.n_fixed)
    together, inertia = np.concatenate(frequencies), np.concatenate(late)
    order = np.lexsort((together, inertia))
    cross = np.hstack(between)[:, order]
    modes, places = np.empty((len(interface.constraint), len(order))), np.split(np.argsort(order), [len(late[0])])
    for half, own, place in zip(interface.halves, reductions, places, strict=True):
        modes[:, place] = half.motions @ own.modes
    return Reduction(
        constraint=interface.constraint,
        modes=modes,
        frequencies=together[order],
        n_fixed=int((~inertia).sum()),
        stiffness=la.block_diag(interface.stiffness, np.diag((2.0 * math.pi * together[order]) ** 2)),
        mass=np.block([[mass, cross], [cross.T, np.eye(len(order))]]),
    )
