"""Unknowns that are added to those of the nodes of a mesh: displacements that its elements do not hold themselves.

Their functions vanish at all nodes, so that the first 3 n unknowns remain the displacements there.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp


@dataclass(frozen=True, eq=False)
class AddedUnknowns(ABC):
    """m unknowns behind k others: those of the nodes, and what was added to them before."""

    numbers: np.ndarray  # (m,), of an unknown among those of its place
    places: np.ndarray  # (m, 3), m, where their functions are

    def __len__(self) -> int:
        return len(self.numbers)

    def extended(self, matrix: sp.csr_matrix) -> sp.csr_matrix:
        """A matrix (k, k) of the others with empty rows and columns for the unknowns that are added."""
        if not len(self):
            return matrix
        size, ends = len(self) + matrix.shape[0], np.full(len(self), matrix.nnz, matrix.indptr.dtype)
        return sp.csr_matrix((matrix.data, matrix.indices, np.append(matrix.indptr, ends)), shape=(size, size))

    def added_to(self, K: sp.csr_matrix, M: sp.csr_matrix) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Stiffness and mass (k + m, k + m) of the elements with their functions, from those without."""
        if not len(self):
            return K, M
        stiffness, mass = self.matrices()
        return sp.csr_matrix(self.extended(K) + stiffness), sp.csr_matrix(self.extended(M) + mass)

    @abstractmethod
    def matrices(self, elements: Collection[int] | None = None) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Stiffness (N/m) and mass (kg), both (k + m, k + m), without the entries of others with others.

        Parameters
        ----------
        elements : numbers of those that are meant; all by default
        """


_APART = 100  # between numbers of functions of different kinds: they may lie at the same place


@dataclass(frozen=True, eq=False)
class Together(AddedUnknowns):
    """Several kinds, those of each behind all before."""

    kinds: Sequence[AddedUnknowns]

    @classmethod
    def of(cls, kinds: Sequence[AddedUnknowns]) -> Together:
        """One or more."""
        numbers = np.concatenate([_APART * place + one.numbers for place, one in enumerate(kinds)])
        return cls(numbers, np.concatenate([one.places for one in kinds]), kinds)

    def matrices(self, elements: Collection[int] | None = None) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """As `AddedUnknowns.matrices`."""
        K, M = self.kinds[0].matrices(elements)
        for one in self.kinds[1:]:
            if len(one):
                stiffness, mass = one.matrices(elements)
                K, M = sp.csr_matrix(one.extended(K) + stiffness), sp.csr_matrix(one.extended(M) + mass)
        return K, M
