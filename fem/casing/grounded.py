"""A meshed casing held at its feet: matrices, interface rows and constraint modes, ready for reduction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fem.casing.coupling import AXES, CouplingError, mean_motion_rows
from fem.casing.mesh import CasingMesh
from fem.casing.reduction import Interface, held_interface
from fem.elasticity import assemble
from fem.linear_solver import Solver
from fem.materials import Material

BEARING_AXES = ("ux", "uy", "uz", "rx", "rz")  # the rotation ry about the shaft is left free


@dataclass(frozen=True, eq=False)
class GroundedCasing:
    """Free-body matrices, the unknowns left free by clamping the foot undersides, and the held interface."""

    mesh: CasingMesh
    material: Material
    K: sp.csr_matrix  # (3 node, 3 node), the free body
    M: sp.csr_matrix
    free: np.ndarray  # unknowns that are not clamped
    clamped: np.ndarray
    K_free: sp.csr_matrix  # of the free unknowns
    M_free: sp.csr_matrix
    coordinate_names: tuple[str, ...]  # of the interface, "bearing_1:ux", ...
    interface: Interface


def ground_casing(
    mesh: CasingMesh, material: Material, *, interfaces: Sequence[str] | None = None, solver: Solver = "auto"
) -> GroundedCasing:
    """Assemble, clamp every node of the ground patches, and factorise.

    Parameters
    ----------
    interfaces : names of the bearing patches that carry loads, all by default; five coordinates each

    Raises
    ------
    CouplingError : no ground patch, an interface that touches the clamped nodes
    MeshError : unknown patch
    SingularMatrixError : a part of the mesh hangs loose
    """
    K, M = assemble(
        mesh.nodes,
        mesh.elements,
        elastic_modulus=material.elastic_modulus,
        poisson_ratio=material.poisson_ratio,
        density=material.density,
    )
    grounds = mesh.patches("ground_")
    if not grounds:
        raise CouplingError("casing mesh has no patch ground_1, ...; name at least one foot")
    held_nodes = np.unique(np.concatenate([mesh.patch(name).ravel() for name in grounds]))
    clamped = _unknowns(held_nodes)
    free = _unknowns(np.setdiff1d(np.arange(len(mesh.nodes)), held_nodes))
    picked = [AXES.index(axis) for axis in BEARING_AXES]
    rows, names = [], []
    for name in mesh.patches("bearing_") if interfaces is None else interfaces:
        facets = mesh.patch(name)
        if np.isin(facets, held_nodes).any():
            raise CouplingError(f"{name} shares nodes with a clamped foot; move the foot or the bore")
        rows.append(mean_motion_rows(mesh.nodes, facets, mesh.point(name))[picked])
        names += [f"{name}:{axis}" for axis in BEARING_AXES]
    B = sp.vstack(rows, format="csr")[:, free] if rows else sp.csr_matrix((0, len(free)))
    K_free, M_free = K[free][:, free], M[free][:, free]
    return GroundedCasing(
        mesh=mesh,
        material=material,
        K=K,
        M=M,
        free=free,
        clamped=clamped,
        K_free=K_free,
        M_free=M_free,
        coordinate_names=tuple(names),
        interface=held_interface(K_free, B, solver=solver),
    )


def _unknowns(nodes: np.ndarray) -> np.ndarray:
    return (3 * nodes[:, None] + np.arange(3)).ravel()
