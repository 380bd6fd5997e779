"""Compliance of a whole toothed ring from one of its sectors.

All teeth are equal. One sector is condensed onto its two cut lines (bore held rigid), and the ring of z such
superelements is block-circulant. The discrete Fourier transform over the teeth divides it into z small systems,

    A_k = S_hh + S_ll + S_lh exp(i 2 pi k / z) + S_hl exp(-i 2 pi k / z),      k = 0 .. z-1,

with l, h the cut at -pi/z, +pi/z of a sector in its frame. The result is that of the fully meshed ring, to round-off,
at the cost of one sector (Thomas, 1979, Int. J. Num. Meth. Eng. 14, 81-102).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fem.elements.sections import lagrange, stiffness
from fem.gears.sector_mesh import SectorMesh
from fem.numerics.linear_solver import SingularMatrixError, factorize
from fem.numerics.unknowns import unknowns_of
from fem.storage.ledger import count


class RingError(RuntimeError):
    """The stiffness matrix of a sector cannot be factorised."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SectorReduction:
    """A sector with fixed bore, condensed to its cut lines and given load vectors p.

    stiffness S (2 c, 2 c): cut at -pi/z first, polar components; transfer H (2 c, p): cut forces of unit loads with the
    cuts held, sign reversed; direct (p, p): displacement along load i by load j with held cuts.
    """

    teeth: int
    stiffness: np.ndarray
    transfer: np.ndarray
    direct: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class FlankCompliance:
    """Displacement normal to the flank by normal nodal forces per unit face width, in m2/N, transverse quantities.

    matrix[n][i, j]: at flank node i of tooth n by a force at flank node j of tooth 0; tooth numbers increase with the
    angle towards the loaded flank. matrix[n][i, j] = matrix[-n][j, i].
    """

    arc: np.ndarray  # (node,) arc length of the flank nodes, m
    tip_arc: float
    matrix: dict[int, np.ndarray]

    def patches(self, centre: np.ndarray, half_width: float) -> tuple[np.ndarray, np.ndarray]:
        """Elliptical pressure patches as nodal forces of unit sum.

        A patch that would extend beyond the tip corner is narrowed, to at least half of `half_width`, and then moved to
        end at the corner. It is also moved up if necessary to remain on the meshed flank.

        Parameters
        ----------
        centre : (position,) m, arc lengths
        half_width : m

        Returns
        -------
        weight (position, node), half_width (position,) as used
        """
        centre = np.asarray(centre, dtype=float)
        used = np.clip(self.tip_arc - centre, half_width / 2, half_width)
        centre = np.clip(centre, self.arc[0] + used, self.tip_arc - used)
        n = 48  # Gauss-Chebyshev points of the second kind: their weight function is the ellipse
        angle = np.pi * np.arange(1, n + 1) / (n + 1)
        weight = 2.0 / (n + 1) * np.sin(angle) ** 2
        place = centre[:, None] + used[:, None] * np.cos(angle)
        element = np.clip(np.searchsorted(self.arc[2::2], place), 0, len(self.arc) // 2 - 1)
        start, end = self.arc[2 * element], self.arc[2 * element + 2]
        values, _ = lagrange((place - start) / (end - start))
        out = np.zeros((len(centre), len(self.arc)))
        row = np.arange(len(centre))[:, None, None]
        np.add.at(out, (row, 2 * element[..., None] + np.arange(3)), weight[:, None] * values)
        return out, used


def load_directions(mesh: SectorMesh) -> np.ndarray:
    """Forces (flank, 3) on the flank nodes with the transverse part 1, normal to the flank in space, into the tooth.

    The axial part is twist * (x n_y - y n_x), so that the moment about the axis is r_b on the involute.
    """
    normal, place = mesh.flank_normal, mesh.points[mesh.flank]
    axial = mesh.twist * (place[:, 0] * normal[:, 1] - place[:, 1] * normal[:, 0])
    return np.column_stack([-normal, axial])


def flank_loads(mesh: SectorMesh) -> sparse.csc_matrix:
    """Unit forces into the tooth along the flank normal, one column per flank node; (dofs, flank).

    On a helical gear the transverse component is 1 and the axial one tan(beta) at the radius of the node times n_theta,
    so that the force is normal to the flank in space and its moment about the axis is r_b on the involute.
    """
    components, count = 3 if mesh.twist else 2, len(mesh.flank)
    values = load_directions(mesh)[:, :components]
    rows = components * mesh.flank[:, None] + np.arange(components)
    cols = np.repeat(np.arange(count), components)
    return sparse.csc_matrix((values.ravel(), (rows.ravel(), cols)), shape=(components * len(mesh.points), count))


def reduce_sector(mesh: SectorMesh, young: float, poisson: float, loads: sparse.spmatrix) -> SectorReduction:
    """Condense one sector onto its cut lines.

    Parameters
    ----------
    mesh : section of the sector
    young, poisson : Pa, 1
    loads : sparse (dofs, p), not on cuts and bore, e.g. `flank_loads`

    Raises
    ------
    RingError : the factorisation fails
    """
    full = stiffness(mesh.points, mesh.elements, young, poisson, mesh.twist, mesh.filling)
    components = full.shape[0] // len(mesh.points)
    turn = cut_rotation(mesh, components)
    cut = unknowns_of(np.concatenate([mesh.cut_low, mesh.cut_high]), components)
    schur, transfer, direct = condensed(mesh, (turn.T @ full @ turn).tocsc(), cut, loads)
    return SectorReduction(
        teeth=mesh.teeth, stiffness=(schur + schur.T) / 2, transfer=transfer, direct=(direct + direct.T) / 2
    )


def condensed(
    mesh: SectorMesh, full: sparse.csc_matrix, kept: np.ndarray, loads: sparse.spmatrix
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stiffness (kept, kept), forces (kept, p) of the loads on the kept unknowns, and compliance (p, p) of the loads.

    Parameters
    ----------
    mesh : its bore is held
    full : (dofs, dofs) stiffness of the sector
    kept : numbers of the kept unknowns
    loads : sparse (dofs, p), not on kept or held unknowns

    Raises
    ------
    RingError : the factorisation fails
    """
    inner = np.ones(full.shape[0], dtype=bool)
    inner[kept] = False
    inner[unknowns_of(np.concatenate([mesh.bore, mesh.cut_bore]), full.shape[0] // len(mesh.points))] = False
    k_ii, k_ic = full[inner][:, inner].tocsc(), full[inner][:, kept]
    try:
        factor = factorize(k_ii, block=full.shape[0] // len(mesh.points))
    except SingularMatrixError as error:
        raise RingError(
            f"gear z={mesh.teeth}: the stiffness matrix of the tooth sector ({k_ii.shape[0]} unknowns) is singular "
            f"({error}). Check bore radius and material."
        ) from error
    count("gear_factorisations")
    p = loads.tocsr()[inner]
    answer = factor.solve(sparse.hstack([k_ic, p]).toarray())
    by_kept, by_load = answer[:, : len(kept)], answer[:, len(kept) :]
    schur = full[kept][:, kept].toarray() - k_ic.T @ by_kept
    return schur, -(k_ic.T @ by_load), p.T @ by_load


def cut_flexibility(sector: SectorReduction, reach: int) -> dict[int, np.ndarray]:
    """Motion (cut, cut) of the low cut of tooth n by unit forces on the low cut of tooth 0, n = -reach .. reach."""
    z, half = sector.teeth, sector.stiffness.shape[0] // 2
    s, low, high = sector.stiffness, slice(0, half), slice(half, None)
    same, ahead = s[low, low] + s[high, high], s[low, high]
    out = {n: np.zeros((half, half)) for n in range(-reach, reach + 1)}
    for k in range(z // 2 + 1):
        phase = np.exp(2j * np.pi * k / z)
        inverse = np.linalg.inv(same + ahead * phase + ahead.T / phase)
        twice = 1.0 if 2 * k in (0, z) else 2.0  # harmonic z - k is the conjugate
        for n in out:
            out[n] += twice / z * (inverse * phase**n).real
    return out


def ring_motion(sector: SectorReduction, reach: int) -> dict[int, np.ndarray]:
    """Motion (both cuts, load) of the cuts of tooth n by unit loads on tooth 0, n = -reach .. reach."""
    half = sector.transfer.shape[0] // 2
    low, high = sector.transfer[:half], sector.transfer[half:]
    ring = cut_flexibility(sector, reach + 1)
    cut = {n: ring[n] @ low + ring[n - 1] @ high for n in range(-reach, reach + 2)}  # the low cut of tooth n
    return {n: np.vstack([cut[n], cut[n + 1]]) for n in range(-reach, reach + 1)}


def ring_response(sector: SectorReduction, reach: int = 2) -> dict[int, np.ndarray]:
    """Displacement along load i of tooth n by unit load j on tooth 0, m2/N; (p, p) for each n = -reach .. reach."""
    out = {n: sector.transfer.T @ motion for n, motion in ring_motion(sector, reach).items()}
    out[0] = out[0] + sector.direct
    return out


def flank_compliance(mesh: SectorMesh, young: float, poisson: float, reach: int = 2) -> FlankCompliance:
    """Compliance between all flank nodes of a tooth and of its neighbours up to `reach` teeth away.

    Parameters
    ----------
    mesh : section of one sector
    young, poisson : Pa, 1
    reach : in teeth; z > 2 reach, so that all these teeth differ
    """
    sector = reduce_sector(mesh, young, poisson, flank_loads(mesh))
    return FlankCompliance(arc=mesh.flank_arc, tip_arc=mesh.tip_arc, matrix=ring_response(sector, reach))


def changed_tooth(sound: SectorReduction, changed: SectorReduction) -> np.ndarray:
    """Compliance (p, p), m2/N, of the flank of one changed tooth in a ring whose other teeth are healthy.

    With the flexibility G of the two cuts of the tooth in the healthy ring, and D = S_changed - S_healthy the motion of
    the cuts under the loads h of the changed tooth is (1 + G D)^-1 G h. This is exact, at the cost of the healthy ring.
    """
    s, h, block = sound.stiffness, changed.transfer, cut_flexibility(sound, 1)
    ring = np.block([[block[0], block[-1]], [block[1], block[0]]])
    motion = np.linalg.solve(np.eye(len(s)) + ring @ (changed.stiffness - s), ring @ h)
    answer = h.T @ motion + changed.direct
    return (answer + answer.T) / 2


def cut_rotation(mesh: SectorMesh, components: int) -> sparse.csc_matrix:
    """Orthogonal matrix T (dofs, dofs): u = T u', u' in polar components (radial, tangential, axial) on the cuts."""
    nodes = np.concatenate([mesh.cut_low, mesh.cut_high])
    x, y = (mesh.points[nodes] / np.linalg.norm(mesh.points[nodes], axis=1)[:, None]).T
    size = components * len(mesh.points)
    diagonal = np.ones(size)
    diagonal[components * nodes] = diagonal[components * nodes + 1] = x
    rows = np.concatenate([np.arange(size), components * nodes, components * nodes + 1])
    cols = np.concatenate([np.arange(size), components * nodes + 1, components * nodes])
    return sparse.csc_matrix((np.concatenate([diagonal, -y, y]), (rows, cols)), shape=(size, size))
