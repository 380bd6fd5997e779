"""A toothed ring with a crack surface through one of its teeth, in the plane or in space.

The sector of the tooth has duplicate nodes on the surface. In addition to loads and cuts (`fem.contact.wheels.ring`) it
keeps the relative displacement g of the two sides, g = u(tooth) - u(body). With closed surface it equals the other
sectors, so that the ring is known: B_n is the motion of the low cut of tooth n by forces on that of tooth 0, R the
flexibility of the ring, at both cuts of the cracked tooth. For the remaining unknowns g

    K g = sum_n F_n f_n,    K = K_gg - K_gq R K_qg,    F_0 = H_g - K_gq R H_q,    F_n = -K_gq q_n,

with the forces H of unit loads on g and on the cuts q when both are held, and the motion q_n of the cuts by loads on
tooth n. F_n are the forces on the closed surface. If the surface is opened where springs k are finite (0: open), the
added compliance is

    F_o^T (K_oo + k)^-1 F_o,

which is positive semidefinite and increases as springs weaken. It is exact for the ring and needs one small dense
solution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve

from fem.contact.wheels.ring import SectorReduction, condensed, cut_flexibility, cut_rotation
from fem.contact.wheels.solid_ring import CUT, load_size, node_frames, sector_prism
from fem.elements.nested_condensation import KEPT
from fem.elements.sections import stiffness
from fem.gears.sector_mesh import SectorMesh
from fem.numerics.unknowns import unknowns_of
from fem.storage.ledger import count


@dataclass(frozen=True, eq=False, kw_only=True)
class CrackedRing:
    """Stiffness K (g, g) against opening, N/m, and forces F_n (g, load) by unit loads on tooth n.

    n is -reach .. reach. In the plane both are per unit face width. Tooth numbers are those of `ring_response`.
    """

    stiffness: np.ndarray
    force: dict[int, np.ndarray]


def plane_cracked_ring(mesh: SectorMesh, young: float, poisson: float, loads: sparse.spmatrix) -> CrackedRing:
    """The ring in plane deformation; g by slit node and component.

    Parameters
    ----------
    mesh : section of the sector with a slit
    young, poisson : Pa, 1
    loads : those of `reduce_sector`

    Raises
    ------
    RingError : the factorisation fails
    """
    full = stiffness(mesh.points, mesh.elements, young, poisson, mesh.twist, mesh.filling)
    components, first = full.shape[0] // len(mesh.points), mesh.slit_first
    turn = cut_rotation(mesh, components)
    on_tooth = unknowns_of(mesh.slit, components)
    opening = components * first + np.arange(len(on_tooth))
    places = np.tile(opening, 2), np.concatenate([on_tooth, opening])
    change = sparse.csc_matrix((np.repeat([1.0, -2.0], len(opening)), places), shape=full.shape)
    turn = (turn @ (sparse.identity(full.shape[0], format="csc") + change)).tocsc()  # u(body) = u(tooth) - g
    full = (turn.T @ full @ turn).tocsc()
    cut = unknowns_of(np.concatenate([mesh.cut_low, mesh.cut_high]), components)
    schur, transfer, _ = condensed(mesh, full, np.concatenate([opening, cut]), loads)
    return _closed_to_ring(mesh.teeth, len(opening), schur, transfer, 0)


def solid_cracked_ring(
    mesh: SectorMesh, young: float, poisson: float, ends: np.ndarray, rows: np.ndarray, reach: int
) -> CrackedRing:
    """The ring in space; g by slit node, axial node and component, loads by flank row and axial node.

    Parameters
    ----------
    mesh : section of the sector with a slit
    young, poisson, ends, rows, reach : those of `solid_flank`; no load on row 0, the mouth
    """
    prism = sector_prism(mesh, young, poisson, ends, rows, CUT)
    doubles = mesh.slit_first + np.arange(len(mesh.slit))
    prism.roles[mesh.slit] = prism.roles[doubles] = KEPT
    count("gear_meshes")
    numbers, matrix = prism.condense()
    count("gear_factorisations")
    on_mesh = numbers < prism.size
    unknown = np.where(on_mesh, numbers, -1)
    node, place, component = unknown // 3 % len(mesh.points), unknown // (3 * len(mesh.points)), unknown % 3
    place_in_order = np.full(len(mesh.points), -1)

    def found(nodes: np.ndarray, components: int) -> np.ndarray:
        """Positions of kept unknowns, sorted by the order of the nodes, axial node and component."""
        place_in_order[:] = -1
        place_in_order[nodes] = np.arange(len(nodes))
        these = np.flatnonzero(on_mesh & (place_in_order[node] >= 0) & (component < components))
        return these[np.lexsort((component[these], place[these], place_in_order[node[these]]))]

    flank, tooth, body = found(mesh.flank[rows], 1), found(mesh.slit, 3), found(doubles, 3)
    cut = np.flatnonzero(~on_mesh)
    mouth = tooth[: 3 * (2 * len(ends) - 1)]  # the mouth is on the flank, where unknowns are along the load direction
    turn = np.kron(np.eye(len(mouth) // 3), node_frames(mesh)[mesh.slit[0]])
    matrix[mouth] = turn @ matrix[mouth]
    matrix[:, mouth] = matrix[:, mouth] @ turn.T
    order = np.concatenate([flank, tooth, body, cut])
    matrix = matrix[np.ix_(order, order)]
    f, n = len(flank), len(tooth)
    m, b = slice(f, f + n), slice(f + n, f + 2 * n)
    matrix[:, m] += matrix[:, b]  # u(tooth) = m, u(body) = m - g
    matrix[m] += matrix[b]
    matrix[:, b] *= -1.0
    matrix[b] *= -1.0
    out, kept = slice(0, f + n), slice(f + n, None)
    load = np.zeros((f + n, f))
    load[np.arange(f), np.arange(f)] = load_size(mesh, rows, f // len(rows))
    right = matrix[out, kept]
    factor = cho_factor(matrix[out, out], lower=True, overwrite_a=False)
    schur = matrix[kept, kept] - right.T @ cho_solve(factor, right)
    return _closed_to_ring(mesh.teeth, n, schur, -(right.T @ cho_solve(factor, load)), reach)


def _closed_to_ring(teeth: int, size: int, schur: np.ndarray, transfer: np.ndarray, reach: int) -> CrackedRing:
    """K and F_n from the sector's stiffness (g and cuts) and the forces (g and cuts, load) of its loads."""
    g, q = slice(0, size), slice(size, None)
    closed = SectorReduction(
        teeth=teeth, stiffness=(schur[q, q] + schur[q, q].T) / 2, transfer=transfer[q], direct=np.zeros((0, 0))
    )
    motion = cut_flexibility(closed, reach + 2)
    half = len(motion[0])
    low, high = closed.transfer[:half], closed.transfer[half:]
    ring = np.block([[motion[0], motion[-1]], [motion[1], motion[0]]])
    coupling = schur[g, q]
    matrix = schur[g, g] - coupling @ ring @ coupling.T
    force = {}
    for n in range(-reach, reach + 1):
        moved = [motion[side - n] @ low + motion[side - n - 1] @ high for side in (0, 1)]
        force[n] = -coupling @ np.vstack(moved)
    force[0] = force[0] + transfer[g]
    return CrackedRing(stiffness=(matrix + matrix.T) / 2, force=force)
