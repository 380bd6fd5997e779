"""Unknowns added to those of the nodes, for displacements that the elements alone cannot represent.

Their functions vanish at all nodes, so that the first 3 n unknowns remain the displacements there.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fem.casing.enrichment.edge_unknowns import EdgeFunctions, edge_functions
from fem.casing.mesh.mesh import CasingMesh
from fem.elements.cubic import CubicFunctions, cubic_functions
from fem.elements.materials import Material
from fem.elements.solids import assemble
from fem.numerics.memory import give_back

KINDS_APART = 100  # offset between the numbers of cubic and of edge functions, which may have the same position


@dataclass(frozen=True, eq=False)
class AddedUnknowns:
    """Unknowns of the cubic functions, if the mesh has any, then those of the edge functions."""

    cubic: CubicFunctions | None
    edges: EdgeFunctions

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def numbers(self) -> np.ndarray:
        """Number of each unknown (m,) among those at the same position."""
        if self.cubic is None:
            return self.edges.numbers
        return np.concatenate([self.cubic.numbers, KINDS_APART + self.edges.numbers])

    @property
    def places(self) -> np.ndarray:
        """Positions of their functions (m, 3), m."""
        return self.edges.places if self.cubic is None else np.concatenate([self.cubic.places, self.edges.places])

    def matrices(self, elements: np.ndarray | None = None) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Stiffness (N/m) and mass (kg) of the nodes and these unknowns together.

        Parameters
        ----------
        elements : numbers of the elements that contribute; all by default
        """
        mesh, material = self.edges.mesh, self.edges.material
        below = self.edges.matrices(None if elements is None else elements.tolist())
        give_back()
        K, M = assemble(
            mesh.nodes,
            mesh.elements,
            elastic_modulus=material.elastic_modulus,
            poisson_ratio=material.poisson_ratio,
            density=material.density,
            cubic=self.cubic,
            chosen=elements,
        )
        if len(self.edges):
            K = _bordered(K, below[0])  # one after the other: the first is freed
            M = _bordered(M, below[1])
        return K, M


def added_functions(
    mesh: CasingMesh,
    material: Material,
    *,
    held: Collection[str],
    rigid: Collection[str] = (),
    joined: Sequence[np.ndarray] = (),
) -> AddedUnknowns:
    """Added unknowns: cubic functions for a cubic mesh, edge functions for hexahedra, none for other elements.

    Parameters
    ----------
    mesh, material : of the casing
    held, rigid : patches whose nodes are clamped, or move as a rigid body
    joined : facets (f, k) at which parts of the mesh touch without sharing nodes
    """
    cubic = cubic_functions(mesh.nodes, mesh.elements, mesh.facets_of([*held, *rigid])) if mesh.cubic else None
    return AddedUnknowns(cubic, edge_functions(mesh, material, held=held, joined=joined, cubic=cubic))


def _bordered(matrix: sp.csr_matrix, rows: sp.csr_matrix) -> sp.csr_matrix:
    """A symmetric matrix (k, k) bordered by further rows (m, k + m) and their transposes."""
    k = matrix.shape[0]
    return sp.csr_matrix(sp.block_array([[matrix, rows[:, :k].T], [rows[:, :k], rows[:, k:]]], format="csr"))
