"""Compliance of a toothed ring in space, solid or with a web, from one of its sectors, with free end faces.

The sector of one tooth, a prism that follows the helix, is condensed onto the loaded unknowns (the normal displacement
of the nodes of one flank) and onto its two cut faces in the middle of the tooth spaces. There the displacement is
smooth: its polar components are products of polynomials in the radius, zero at the rigid bore, and Legendre polynomials
along the face. Both cuts have the same functions, so that sectors conform, and the ring of z superelements is solved by
the discrete Fourier transform over the teeth (`fem.contact.wheels.ring`). The number of functions is an option; tests
compare with all nodes of the cut.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from fem.contact.wheels.ring import SectorReduction, load_directions, ring_response
from fem.contact.wheels.sector_face_functions import CUT, CutFunctions, cut_ties, webbed_ties
from fem.elements.nested_condensation import FIXED, INNER, KEPT, TIED, Prism
from fem.elements.twisted_hexahedra import section_blocks, turned_blocks
from fem.gears.sector_mesh import SectorMesh
from fem.numerics.quadratic_grids import with_middles


@dataclass(frozen=True, eq=False, kw_only=True)
class SolidFlank:
    """Displacement normal to the flank by nodal forces normal to it, m/N, transverse quantities.

    matrix[n][i, j]: at flank node i of tooth n by a force at flank node j of tooth 0, nodes numbered row * axial nodes
    + axial node; tooth numbers increase with the angle towards the loaded flank, the axial coordinate with the twist.
    """

    rows: np.ndarray  # the flank rows (section nodes) that can be loaded, as indices of `SectorMesh.flank`
    ends: np.ndarray  # axial element ends, m, 0 at mid face
    matrix: dict[int, np.ndarray]


def node_frames(mesh: SectorMesh) -> np.ndarray:
    """Unit vectors (nodes, 3, 3) as columns: polar on the cuts, the load direction first on the flank, else x, y, z."""
    frames = np.tile(np.eye(3), (len(mesh.points), 1, 1))
    cut = np.concatenate([mesh.cut_low, mesh.cut_high])
    radial = mesh.points[cut] / np.linalg.norm(mesh.points[cut], axis=1)[:, None]
    frames[cut, :2, 0] = radial
    frames[cut, 0, 1], frames[cut, 1, 1] = -radial[:, 1], radial[:, 0]
    first = load_directions(mesh)
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.column_stack([-first[:, 1], first[:, 0], np.zeros(len(first))])
    second /= np.linalg.norm(second, axis=1)[:, None]
    frames[mesh.flank] = np.stack([first, second, np.cross(first, second)], axis=-1)
    return frames


def sector_prism(
    mesh: SectorMesh,
    young: float,
    poisson: float,
    ends: np.ndarray,
    rows: np.ndarray,
    cut: CutFunctions = CUT,
    web: tuple[float, float] | None = None,
) -> Prism:
    """The sector of one tooth, as a prism for condensation.

    Parameters
    ----------
    mesh, young, poisson, ends, rows, cut, web : those of `solid_flank`; the unknowns of the rows are kept
    """
    frames = node_frames(mesh)
    roles = np.full((len(mesh.points), 3), INNER)
    roles[mesh.flank[rows], 0] = KEPT
    roles[np.concatenate([mesh.bore, mesh.cut_bore])] = FIXED
    roles[np.concatenate([mesh.cut_low, mesh.cut_high])] = TIED
    side, at = np.full(len(mesh.points), -1), np.zeros(len(mesh.points), dtype=int)
    for number, nodes in enumerate((mesh.cut_low, mesh.cut_high)):
        side[nodes], at[nodes] = number, np.arange(len(nodes))
    radius = np.linalg.norm(mesh.points[mesh.cut_low], axis=1)
    bore = float(np.linalg.norm(mesh.points[mesh.cut_bore[0]]))
    filled = np.ones((len(mesh.elements), len(ends) - 1), dtype=bool)
    if web is None:
        filling = mesh.filling
        ties = cut_ties(cut, side, at, radius, bore, with_middles(ends))
    else:
        filling = np.ones(len(mesh.elements))
        middle = (ends[1:] + ends[:-1]) / 2
        filled[mesh.web] = (middle > web[0]) & (middle < web[1])
        rim = float(np.linalg.norm(mesh.points[mesh.elements[mesh.web]], axis=2).max())
        ties = webbed_ties(cut, side, at, radius, bore, with_middles(ends), rim, web)
    blocks = section_blocks(mesh.points, mesh.elements, young, poisson, mesh.twist, filling)
    return Prism(
        elements=mesh.elements,
        grid=mesh.grid,
        blocks=turned_blocks(blocks, frames[mesh.elements]),
        ends=ends,
        roles=roles,
        ties=ties,
        filled=filled,
    )


def reduce_prism(mesh: SectorMesh, prism: Prism, rows: np.ndarray) -> tuple[SectorReduction, np.ndarray]:
    """The condensed sector, and the numbers of its unknowns: loads, then cuts.

    Loads are unit transverse forces on the nodes of the kept rows, row by row; `load_size` times its unknown is the
    displacement along a load.
    """
    numbers, matrix = prism.condense()
    loads = np.flatnonzero(numbers < prism.size)
    order = np.full(len(mesh.points), -1)
    order[mesh.flank[rows]] = np.arange(len(rows))
    node, place = numbers[loads] // 3 % len(mesh.points), numbers[loads] // (3 * len(mesh.points))
    loads = loads[np.lexsort((place, order[node]))]
    size = load_size(mesh, rows, len(loads) // len(rows))
    cut = np.arange(len(loads), len(numbers))
    factor = cho_factor(matrix[np.ix_(loads, loads)], lower=True)
    right = matrix[np.ix_(loads, cut)]
    by_load = cho_solve(factor, np.diag(size))
    schur = matrix[np.ix_(cut, cut)] - right.T @ cho_solve(factor, right)
    direct = size[:, None] * by_load
    sector = SectorReduction(
        teeth=mesh.teeth,
        stiffness=(schur + schur.T) / 2,
        transfer=-(right.T @ by_load),
        direct=(direct + direct.T) / 2,
    )
    return sector, numbers[np.concatenate([loads, cut])]


def load_size(mesh: SectorMesh, rows: np.ndarray, axial_nodes: int) -> np.ndarray:
    """Length (load,) of the load directions, 1 for straight teeth."""
    return np.repeat(np.linalg.norm(load_directions(mesh)[rows], axis=1), axial_nodes)


def solid_flank(
    mesh: SectorMesh,
    young: float,
    poisson: float,
    ends: np.ndarray,
    rows: np.ndarray,
    reach: int,
    cut: CutFunctions = CUT,
    web: tuple[float, float] | None = None,
) -> SolidFlank:
    """Compliance between the nodes of some flank rows of a tooth and of its neighbours.

    Parameters
    ----------
    mesh : section of one sector
    young, poisson : Pa, 1
    ends : axial element ends, m
    rows : int (rows,), indices into `mesh.flank`
    reach : number of neighbouring teeth on either side
    cut : functions on the cut faces
    web : ends of the web along the axis, m, both among `ends`; None if the body below the rim fills the face or is an
        equivalent ring
    """
    sector, _ = reduce_prism(mesh, sector_prism(mesh, young, poisson, ends, rows, cut, web), rows)
    return SolidFlank(rows=rows, ends=ends, matrix=ring_response(sector, reach))
