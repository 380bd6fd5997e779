"""Reactions of the ground on clamped feet, as rows of a reduced casing at rest.

The body obeys K u = f - M X a at rest. u = E q excludes clamped nodes, u_b = B q are the bearings, and the forces f act
only at the bearings. With the constraint modes Psi and P, the inverse of E^T K E on B q = 0 (see
`fem.casing.reduced.reduction`),

    q = Psi u_b - P E^T M X a,    F = W (K E q + M X a) = (W K E Psi) u_b + W (M X - K E P E^T M X) a

W sums the nodes of every foot along x, y, z; X moves the whole body by 1 along these axes. The first term is the force
per displacement of the interface (3 feet, b), in N/m and N/rad. The second is the force per acceleration of the ground
(3 feet, 3), in kg, with the interface held. It is independent of the modes kept, so that the feet together always carry
the whole weight.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp


def foot_sums(unknowns: Sequence[np.ndarray], size: int) -> sp.csr_matrix:
    """W (3 feet, size), which sums the unknowns of every foot; unknowns shared by two feet contribute half to each.

    Parameters
    ----------
    unknowns : per foot, those along x, along y, along z
    size : number of unknowns
    """
    rows = np.repeat(np.arange(len(unknowns)), [len(one) for one in unknowns])
    at = np.concatenate(unknowns)
    shared = np.bincount(at, minlength=size)
    return sp.csr_matrix((1.0 / shared[at], (rows, at)), shape=(len(unknowns), size))
