"""Plane problem over the section across an edge: a few functions for what the elements around it cannot represent.

The fan of elements around the edge and the ring of elements around the fan are loaded at the outer ends of the ring.
Each connected part of these ends, and each bearing seat, gets rigid motions and uniform strains. In the ring the
displacement u is that of the elements. In the fan it is solved on a grid graded towards the edge. The difference to its
interpolation I u by the elements from their nodal values,

    phi = u - I u,

vanishes at all nodes and on closed sides: sides towards elements outside the fan, and clamped sides.

References: Szabo & Babuska (1991), Finite Element Analysis, section 10.1 (stresses at edges); Hou & Wu (1997), J.
Comput. Phys. 134(1), 169-189 (functions from local problems on a larger domain).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from fem.casing.enrichment.graded_functions import GRID, NODES, eight_nodes, gauss, graded, nine_nodes, products
from fem.elements.sections import lagrange

_LEAST_ENERGY = 1e-4  # of the first function: functions with less are omitted
_RIGID = 1e-9  # of the largest energy: motions without strain


@dataclass(frozen=True, eq=False, kw_only=True)
class EdgeSection:
    """Sections of elements, those of the fan first and in order, with the conditions on their sides.

    The sides of an element are xi = 0, xi = 1, eta = 0, eta = 1; xi = 0 of one element in a fan is eta = 0 of the next.
    """

    points: np.ndarray  # (cell, 3, 3, 2), m, at xi, eta = 0, 1/2, 1
    corners: np.ndarray  # (cell, 2, 2), numbers
    sides: np.ndarray  # (cell, 4), numbers of the sides
    fan: int  # number of cells in the fan
    closed: np.ndarray  # bool (fan, 4): functions vanish there
    clamped: np.ndarray  # bool (cell, 4)
    loaded: np.ndarray  # bool (cell, 4): an outer end of the ring
    middles: bool  # whether the elements have a node in the middle

    @property
    def key(self) -> bytes:
        """Key that is equal for sections of the same shape at any position."""
        corners, sides = (np.unique(numbers, return_inverse=True)[1] for numbers in (self.corners, self.sides))
        shape = np.round(self.points / abs(self.points).max(), 8) + 0.0
        return b"".join(one.tobytes() for one in (shape, corners, sides, self.closed, self.clamped, self.loaded))

    def functions(self, poisson_ratio: float, in_plane: int, along_edge: int) -> np.ndarray:
        """The functions of highest energy (fan, function, 3, k, k) on the graded grids, largest value 1.

        Components in the plane come first (plane strain), then those along the edge (anti-plane shear).

        Parameters
        ----------
        poisson_ratio : of the material
        in_plane, along_edge : largest numbers of functions
        """
        if not self.loaded.any():
            return np.zeros((self.fan, 0, 3, len(NODES), len(NODES)))
        coarse, n = self._coarse()
        fine, n_fine = self._fine()
        of_fine = self._fine_from(coarse, n, fine, n_fine)  # values on the grids from coarse nodes and free grid nodes
        held, loaded = np.zeros((2, of_fine.shape[1]), bool)
        on_side = _on_sides(coarse)
        held[on_side[self.clamped]] = True
        loaded[on_side[self.loaded]] = True
        of_fan, of_ring = self._products(slice(0, self.fan)), self._products(slice(self.fan, None))
        found = []
        for components, count in ((2, in_plane), (1, along_edge)):
            T = sp.csr_matrix(sp.kron(of_fine, sp.eye_array(components)))
            K_fan = _stiffness(of_fan, fine, n_fine, components, poisson_ratio)
            K = np.asarray(T.T @ (T.T @ K_fan).T)
            head = components * n
            K[:head, :head] += _stiffness(of_ring, coarse[self.fan :], n, components, poisson_ratio)
            known = np.repeat(held | loaded, components) | (np.diag(K) == 0.0)  # nodes within the fan: no stiffness
            data = self._motions(coarse, n, components)
            U = np.zeros((len(K), data.shape[1]))
            U[:head] = data
            U[np.repeat(held, components)] = 0.0
            U[~known] = -la.solve(K[np.ix_(~known, ~known)], K[~known] @ U, assume_a="pos")
            U = U @ _largest(U.T @ K @ U, _RIGID, None)
            u = T @ U
            phi = u - self._interpolated(fine, u.reshape(n_fine, components, -1)).reshape(u.shape)
            phi = phi @ _largest(phi.T @ K_fan @ phi, _LEAST_ENERGY, count)
            phi /= abs(phi).max(axis=0, initial=1e-300)
            full = np.zeros((n_fine, 3, phi.shape[1]))
            full[:, slice(0, 2) if components == 2 else slice(2, 3)] = phi.reshape(n_fine, components, -1)
            found.append(full)
        return np.concatenate(found, axis=2)[fine].transpose(0, 4, 3, 1, 2)

    def _coarse(self) -> tuple[np.ndarray, int]:
        """Numbers (cell, 3, 3) of the nodes of the elements, and how many there are."""
        number = np.empty((len(self.points), 3, 3), int)
        corners, first = np.unique(self.corners, return_inverse=True)
        number[:, ::2, ::2] = first.reshape(-1, 2, 2)
        sides, second = np.unique(self.sides, return_inverse=True)
        number[:, 0, 1], number[:, 2, 1], number[:, 1, 0], number[:, 1, 2] = second.reshape(-1, 4).T + len(corners)
        number[:, 1, 1] = len(corners) + len(sides) + np.arange(len(number))
        return number, len(corners) + len(sides) + len(number)

    def _fine(self) -> tuple[np.ndarray, int]:
        """Numbers (fan, k, k) of the nodes of the graded grids, and how many there are."""
        own = np.arange(self.fan * len(NODES) ** 2).reshape(-1, len(NODES), len(NODES))
        own[:, 0, 0] = 0
        for number in range(self.fan - 1):
            own[number + 1, :, 0] = own[number, 0, :]
        used, flat = np.unique(own, return_inverse=True)
        return flat.reshape(own.shape), len(used)

    def _fine_from(self, coarse: np.ndarray, n: int, fine: np.ndarray, n_fine: int) -> sp.csr_matrix:
        """Values on the grids (n_fine,) from those at the coarse nodes, on closed sides, and at free nodes of grids."""
        weights, _ = lagrange(NODES)
        free = np.ones(n_fine, bool)
        tied: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        on_side, along = _on_sides(coarse[: self.fan]), _on_sides(fine)
        for cell, side in np.argwhere(self.closed | self.clamped[: self.fan]):
            free[along[cell, side]] = False
            tied |= {
                int(node): (on_side[cell, side], own) for node, own in zip(along[cell, side], weights, strict=True)
            }
        number = n + np.cumsum(free) - 1
        row = [np.flatnonzero(free), *(np.full(3, node) for node in tied)]
        column = [number[free], *(nodes for nodes, _ in tied.values())]
        value = [np.ones(int(free.sum())), *(own for _, own in tied.values())]
        place = (np.concatenate(row), np.concatenate(column))
        return sp.csr_matrix((np.concatenate(value), place), shape=(n_fine, n + int(free.sum())))

    def _interpolated(self, fine: np.ndarray, u: np.ndarray) -> np.ndarray:
        """I u (n_fine, component, case)."""
        X, Y = (one.ravel() for one in np.meshgrid(NODES, NODES, indexing="ij"))
        functions, _ = (nine_nodes if self.middles else eight_nodes)(X, Y)
        at_nodes, _ = graded(np.array([0.0, 0.5, 1.0]))
        out = np.zeros_like(u)
        for own in fine:
            values = np.einsum("ai,bj,ijcm->abcm", at_nodes, at_nodes, u[own])
            out[own.ravel()] = np.einsum("qab,abcm->qcm", functions, values)
        return out

    def _motions(self, coarse: np.ndarray, n: int, components: int) -> np.ndarray:
        """Rigid motions and uniform strains (components n, case) of every connected part of the loaded sides."""
        places = np.empty((n, 2))
        places[coarse] = self.points
        sides = _on_sides(coarse)[self.loaded]
        row = np.repeat(np.arange(len(sides)), 3)
        touch = sp.csr_matrix((np.ones(len(row)), (row, sides.ravel())), shape=(len(sides), n))
        parts, label = connected_components(touch @ touch.T, directed=False)
        cases = []
        for part in range(parts):
            nodes = np.unique(sides[label == part])
            at = places[nodes] - places[nodes].mean(axis=0)
            for shape in (np.ones(len(nodes)), *(at / abs(at).max()).T):
                for component in range(components):
                    case = np.zeros((n, components))
                    case[nodes, component] = shape
                    cases.append(case.ravel())
        return np.array(cases).T

    def _products(self, cells: slice) -> np.ndarray:
        """Integrals (cell, i, j, a, b) of products of slopes: fan on its graded grids, ring on the elements."""
        in_fan = cells.start == 0
        x, weight = gauss(GRID if in_fan else np.array([0.0, 1.0]))
        X, Y = (one.ravel() for one in np.meshgrid(x, x, indexing="ij"))
        _, of_map = nine_nodes(X, Y)
        if in_fan:
            _, slopes = products(graded(X), graded(Y))
        else:
            _, slopes = (nine_nodes if self.middles else eight_nodes)(X, Y)
        slopes = slopes.reshape(len(X), -1, 2)
        J = np.einsum("qabr,eabd->eqrd", of_map, self.points[cells])
        volume = abs(np.linalg.det(J)) * np.outer(weight, weight).ravel()
        G = np.einsum("qar,eqdr->edqa", slopes, np.linalg.inv(J))
        return np.asarray((G * volume[:, None, :, None]).transpose(0, 1, 3, 2)[:, :, None] @ G[:, None])


def _stiffness(products: np.ndarray, numbers: np.ndarray, n: int, components: int, poisson_ratio: float) -> np.ndarray:
    """Stiffness for a shear modulus of 1, from integrals (cell, i, j, a, b) and node numbers (cell, k, k)."""
    lam = 2.0 * poisson_ratio / (1.0 - 2.0 * poisson_ratio)
    shear = products[:, 0, 0] + products[:, 1, 1]
    if components == 2:
        blocks = lam * products + products.transpose(0, 2, 1, 3, 4) + np.eye(2)[:, :, None, None] * shear[:, None, None]
    else:
        blocks = shear[:, None, None]
    out = np.zeros((components * n, components * n))
    for block, number in zip(blocks, numbers, strict=True):
        size = components * number.size
        own = (components * number.ravel()[:, None] + np.arange(components)).ravel()
        out[np.ix_(own, own)] += block.transpose(2, 0, 3, 1).reshape(size, size)
    return out


def _on_sides(numbers: np.ndarray) -> np.ndarray:
    """Numbers (cell, 4, k) on the sides xi = 0, xi = 1, eta = 0, eta = 1 of arrays (cell, k, k)."""
    return np.stack([numbers[:, 0], numbers[:, -1], numbers[:, :, 0], numbers[:, :, -1]], axis=1)


def _largest(energy: np.ndarray, least: float, count: int | None) -> np.ndarray:
    """Combinations (case, m) above `least` by descending energy: the first `count`, or all, scaled to energy 1."""
    value, vector = la.eigh(0.5 * (energy + energy.T))
    order = np.argsort(-value)
    order = order[value[order] > least * max(value[-1], 0.0)][:count]
    if count is not None:
        return np.asarray(vector[:, order])
    return np.asarray(vector[:, order] / np.sqrt(value[order]))
