"""Decomposition of a body with a mirror plane into a symmetric and an antisymmetric half.

A reflection S (S S = 1) maps the unknowns of such a body and its interface onto themselves, S K S = K, S M S = M and
B S = R B. Motions with S u = u and with S u = -u are then uncoupled:

    u = Q_s q_s + Q_a q_a,   u_b = C_s v_s + C_a v_a,   K_h = Q_h^T K Q_h,   M_h = Q_h^T M Q_h,   B_h = C_h^T B Q_h

Each half has half of the unknowns and about half of the modes; its factor has less than half of the entries. The halves
are computed one after the other, so that only one factor is in memory. On the plane an unknown moves in only one half.
In the other it is kept with a stiffness, without coupling and mass, so that every node has three unknowns.

Reference: Bossavit (1986), Comput. Methods Appl. Mech. Eng. 56(2), 167-215 (symmetry of boundary value problems).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.spatial import cKDTree

from fem.casing.enrichment.added_unknowns import AddedUnknowns
from fem.casing.reduced.lanczos import EigenError, block_lanczos
from fem.casing.reduced.reduction import Reduction, held_interface, largest_entry, reduce_body
from fem.casing.reduced.sturm_count import count_fixed_modes
from fem.numerics.linear_solver import factorize
from fem.numerics.memory import give_back
from fem.numerics.unknowns import unknowns_of

_SAME = 1e-7  # of the size of the body: a node this close to the image of another is its image
_ROUNDING = 1e-10  # relative tolerance of products that should be equal
_SHARE = 0.6  # of the requested modes: first number computed in each half


@dataclass(frozen=True, eq=False)
class Subspace:
    """Motions of a body that are uncoupled from its others: all of them or those of one half, with their interface."""

    motions: sp.csr_matrix  # Q (n, n_h), orthonormal columns; 0 for unknowns at rest
    numbers: np.ndarray  # (n_h,) of the unknowns q whose motions they are, on one side of the mirror plane
    coordinates: np.ndarray  # C (b, b_h), orthonormal
    K: sp.csr_matrix  # (n_h, n_h)
    M: sp.csr_matrix
    rows: sp.csr_matrix  # of the interface (b_h, n_h)
    penalty: np.ndarray | None  # (b_h,)

    def without(self, omitted: np.ndarray) -> Subspace:
        """The motions with unknowns q (n,) at rest, which are left out."""
        own = ~omitted[self.numbers]
        return replace(
            self,
            motions=sp.csr_matrix(self.motions[~omitted][:, own]),
            numbers=(np.cumsum(~omitted) - 1)[self.numbers[own]],
            K=sp.csr_matrix(self.K[own][:, own]),
            M=sp.csr_matrix(self.M[own][:, own]),
            rows=sp.csr_matrix(self.rows[:, own]),
        )


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


def subspaces_of(
    added: AddedUnknowns | None,
    K: sp.csr_matrix,
    M: sp.csr_matrix,
    rows: sp.csr_matrix,
    *,
    expansion: sp.csr_matrix,
    penalty: np.ndarray | None = None,
) -> tuple[Subspace, ...]:
    """The motions E q of a body; two halves if it has a mirror plane normal to an axis.

    Parameters
    ----------
    added : the unknowns u beyond those of the nodes; None: no search for a mirror plane
    K, M : sparse (u, u), stiffness and mass in SI
    rows, penalty : those of `fem.casing.reduced.reduction.held_interface`
    expansion : E (u, n), a selection of unknowns if `added` is given
    """
    for axis in range(3) if added is not None else ():
        assert added is not None
        reflection = _reflection(added, axis, K, expansion.tocsc().indices)
        if reflection is None or not all(_unchanged(matrix, reflection, expansion) for matrix in (K, M)):
            continue
        turned = _of_interface(rows, reflection)
        stiffness = np.zeros(rows.shape[0]) if penalty is None else penalty
        if turned is not None and np.allclose(turned * stiffness, stiffness[:, None] * turned):
            return _halves(reflection, turned, K, M, expansion, rows, penalty)
    n, b = expansion.shape[1], rows.shape[0]
    own_K, own_M = projected(K, expansion), projected(M, expansion)
    return (Subspace(sp.eye_array(n, format="csr"), np.arange(n), np.eye(b), own_K, own_M, rows, penalty),)


def together(matrices: Sequence[tuple[sp.csr_matrix, sp.csr_matrix]]) -> sp.csr_matrix | spla.LinearOperator:
    """Products with the sum of Q A Q^T over the subspaces of a body, from all Q and A; A of an undivided body."""
    if len(matrices) == 1:
        return matrices[0][1]
    one, other = (spla.aslinearoperator(Q) @ spla.aslinearoperator(A) @ spla.aslinearoperator(Q.T) for Q, A in matrices)
    return one + other


def projected(matrix: sp.csr_matrix, expansion: sp.csr_matrix) -> sp.csr_matrix:
    """E^T A E; a selection of unknowns is sliced."""
    if expansion.nnz > expansion.shape[1]:
        return sp.csr_matrix(expansion.T @ matrix @ expansion)
    chosen = expansion.tocsc().indices
    return sp.csr_matrix(matrix[chosen][:, chosen])


def reduced_and_counted(
    subspaces: Sequence[Subspace],
    loads: np.ndarray | sp.csr_matrix,
    *,
    highest: float | None,
    count: int = 0,
) -> tuple[Reduction, int]:
    """Reduce a body one subspace at a time; the number of modes is verified by a Sturm-sequence count.

    Parameters
    ----------
    subspaces : of the body
    loads : (n, l), those of `held_interface`
    highest : Hz, every mode up to it, with the inertia correction; or None:
    count : number of modes of every subspace, not verified; 0: static condensation

    Raises
    ------
    EigenError : the number of modes differs from the Sturm-sequence count; or see `held_interface` and `reduce_body`
    """

    def reduced(one: Subspace) -> tuple[Reduction, int]:
        give_back()  # the factor of the subspace before
        held = held_interface(one.K, one.rows, penalty=one.penalty, loads=one.motions.T @ loads)
        if highest is None:
            return reduce_body(held, one.K, one.M, count=count, enrich=count > 0), 0
        counted = count_fixed_modes(held, one.K, one.M, highest)
        give_back()
        reduction = reduce_body(held, one.K, one.M, highest=highest)
        if reduction.n_fixed != counted:
            raise EigenError(
                f"casing: {reduction.n_fixed} fixed-interface modes found below {highest:g} Hz, {counted} exist; "
                "choose a slightly different band"
            )
        return reduction, counted

    found = [reduced(one) for one in subspaces]
    return _joined(subspaces, [reduction for reduction, _ in found]), sum(counted for _, counted in found)


def lowest(subspaces: Sequence[Subspace], count: int) -> tuple[np.ndarray, np.ndarray]:
    """The lowest natural modes of a body with free interface and definite stiffness.

    Parameters
    ----------
    subspaces : of the body, without penalty
    count : number of modes

    Returns
    -------
    theta = 1 / omega^2 (count,), descending, in s2, and vectors (n, count), orthonormal in M

    Raises
    ------
    EigenError : no convergence
    """

    def of_each(number: int) -> list[tuple[np.ndarray, np.ndarray]]:
        return [block_lanczos(factorize(one.K).solve, one.M, count=number) for one in subspaces]

    found = of_each(count if len(subspaces) == 1 else math.ceil(_SHARE * count))
    if np.sort(np.concatenate([theta for theta, _ in found]))[-count:][0] < max(theta[-1] for theta, _ in found):
        found = of_each(count)  # one half may have further modes above the last one
    theta = np.concatenate([values for values, _ in found])
    order = np.argsort(-theta)[:count]
    vectors = [one.motions @ modes for one, (_, modes) in zip(subspaces, found, strict=True)]
    return theta[order], np.hstack(vectors)[:, order]


def _reflection(added: AddedUnknowns, axis: int, K: sp.csr_matrix, chosen: np.ndarray) -> _Reflection | None:
    """The reflection of the chosen unknowns about the centre of the body; None if some have no image."""
    nodes = added.edges.mesh.nodes
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    near = _SAME * float(np.linalg.norm(high - low))
    image = _images(nodes, low[axis] + high[axis], axis, near)
    numbered = np.column_stack([added.places, added.numbers])  # the number separates those of one node
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
    """Sign (1 or -1) of a reflected added function relative to its image, from their forces in a random motion."""
    n = len(image)
    x, reflected = np.zeros((2, K.shape[0]))
    x[:n] = np.random.default_rng(0).standard_normal(n)
    reflected[:n] = sign * x[image]
    return np.where((K @ reflected)[n:] * (K @ x)[n:][other] < 0.0, -1.0, 1.0)


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


def _halves(
    reflection: _Reflection,
    turned: np.ndarray,
    K: sp.csr_matrix,
    M: sp.csr_matrix,
    expansion: sp.csr_matrix,
    rows: sp.csr_matrix,
    penalty: np.ndarray | None,
) -> tuple[Subspace, Subspace]:
    value, vector = la.eigh(turned)
    largest, kept = float(K.diagonal().max()), expansion.tocsc().indices[reflection.kept]

    def half(parity: float) -> Subspace:
        Q, C, share = reflection.motions(parity), vector[:, value * parity > 0.0], reflection.share(parity)
        scale = np.divide(1.0, share, out=np.zeros_like(share), where=share > 0.0)

        in_body = sp.csr_matrix(expansion @ Q)

        def of_half(matrix: sp.csr_matrix) -> sp.csr_matrix:
            """Q_i^T A Q_j = A_i Q_j / share_i: the images of the rows give the same products."""
            found = sp.csr_matrix(matrix[kept] @ in_body)
            found.data *= np.repeat(scale, np.diff(found.indptr))
            return found

        own_K = sp.csr_matrix(of_half(K) + sp.diags_array(np.where(share > 0.0, 0.0, largest)))
        own_rows = sp.csr_matrix(C.T @ (rows @ Q).toarray())
        own_penalty = None if penalty is None else np.einsum("ij,i,ij->j", C, penalty, C)
        return Subspace(Q, reflection.kept, C, own_K, of_half(M), own_rows, own_penalty)

    return half(1.0), half(-1.0)


def _joined(subspaces: Sequence[Subspace], reductions: Sequence[Reduction]) -> Reduction:
    """The reduction of the whole body from those of its subspaces."""
    b, n = len(subspaces[0].coordinates), subspaces[0].motions.shape[0]
    (stiffness, mass), between, frequencies, late = np.zeros((2, b, b)), [], [], []
    constraint, loaded = np.zeros((n, b)), np.zeros((n, reductions[0].loaded.shape[1]))
    for one, own in zip(subspaces, reductions, strict=True):
        C, own_b = one.coordinates, one.coordinates.shape[1]
        stiffness += C @ own.stiffness[:own_b, :own_b] @ C.T
        mass += C @ own.mass[:own_b, :own_b] @ C.T
        constraint += one.motions @ (own.constraint @ C.T)
        loaded += one.motions @ own.loaded
        between.append(C @ own.mass[:own_b, own_b:])
        frequencies.append(own.frequencies)
        late.append(np.arange(len(own.frequencies)) >= own.n_fixed)
    together, inertia = np.concatenate(frequencies), np.concatenate(late)
    order = np.lexsort((together, inertia))
    cross = np.hstack(between)[:, order]
    modes, places = np.empty((n, len(order))), np.split(np.argsort(order), np.cumsum([len(one) for one in late])[:-1])
    for one, own, place in zip(subspaces, reductions, places, strict=True):
        modes[:, place] = one.motions @ own.modes
    return Reduction(
        constraint=constraint,
        modes=modes,
        frequencies=together[order],
        n_fixed=int((~inertia).sum()),
        stiffness=la.block_diag(stiffness, np.diag((2.0 * math.pi * together[order]) ** 2)),
        mass=np.block([[mass, cross], [cross.T, np.eye(len(order))]]),
        loaded=loaded,
        solver=reductions[0].solver + (", by symmetric and antisymmetric halves" if len(subspaces) > 1 else ""),
    )
