"""Crack surface of a tooth in space: its stiffness against opening, and the compliance added by a crack.

A sector with a slit as deep as a crack can be, over the whole face, is condensed once
(`fem.contact.wheels.cracked_ring`). A crack of any depth and extent opens a part of that surface. Every pair of nodes
represents a cell of the surface. If the crack covers the share x of its depth and the share y of its width, the pair is
connected by springs, equal in all three directions,

    k = E area (THROUGH (1 - x) / x / node spacing + ALONG (1 - y) / y / width),

rigidly for x = 0 or y = 0 and not at all for x = y = 1. The compliance is then a continuous function of depth and
extent, and never decreases with them.

The surface has few nodes, and springs only approximate a crack front. The error is corrected by plane deformation,
where a fine mesh is inexpensive: at every position along the face the front is at the depth at which the coarse section
has the compliance of the fine one at the true depth. Errors of the section and of the springs then cancel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fem.contact.wheels.compliance import axial_ends
from fem.contact.wheels.cracked_ring import plane_cracked_ring, solid_cracked_ring
from fem.contact.wheels.ring import flank_loads
from fem.elements.materials import Material
from fem.gears.gear import Gear
from fem.gears.sector_mesh import SectorMesh, Slit, root_chord, sector_mesh
from fem.numerics.side_by_side import side_by_side
from fem.storage.records import Record, array, scalar

DEEPEST = 0.8  # of the tooth's root chord: the deepest crack
MARGIN = 0.05  # of the chord: extension of the surface beyond the deepest crack
THROUGH, ALONG = 0.5, 0.4  # of the springs; fitted together with CORNER for a smooth increase of compliance
CORNER = 0.2  # share of an element in the cell of each of its ends; the rest is in that of its middle
BACK = 0.16  # of an element: correction of the ends of the extent, fitted to `benchmarks/cracked_teeth.py`
COARSE = 0.25  # section refinement and spacing (m_n) of the surface in space, at refinement 1
SPACING = 0.25
FINE, FINE_SPACING = 0.5, 0.05  # of the section in plane deformation: within 0.4 % for a fifth of the chord and more
LOADED_ROWS = 8  # loaded rows of flank nodes; a load between them is interpolated
DEPTHS = 48  # number of depths for the comparison of both sections
REACH = 1  # teeth on either side whose loads affect the surface
_SAMPLES = 16  # of the depth, in the covered part of a cell


@dataclass(frozen=True, eq=False, kw_only=True)
class CrackSurface(Record):
    """Stiffness K of the surface against opening and forces F on it from loads, see `cracked_ring`.

    Openings are numbered pair * 3 + component, pairs slit node * axial nodes + axial node.
    """

    stiffness: np.ndarray = array("opening", "opening_too", units="N/m")  # K
    force: np.ndarray = array("tooth", "row", "axial_node", "opening", units="1")  # F by loads on tooth -1, 0, 1
    load_arc: np.ndarray = array("row", units="m")  # arc length of the loaded rows from the base circle
    ends: np.ndarray = array("axial_end", units="m")  # of the elements along the face, in the direction of twist
    slit_node: np.ndarray = array("slit_node", units="m")  # distance from the mouth, without the tip
    depth: np.ndarray = array("depth", units="m")  # of a crack, from 0
    front: np.ndarray = array("depth", units="m")  # corresponding depth of covered cells
    elastic_modulus: float = scalar(units="Pa")


@dataclass(frozen=True, kw_only=True)
class CrackSurfaceSpec:
    """Input of a crack surface: the gear, and the angle (rad) of cracks to the centre line of its tooth.

    face_width : common face of the pair, m
    refinement : divides the element sizes of section and surface
    axial_elements : along the face, see `axial_ends`
    """

    gear: Gear
    material: Material
    angle: float
    face_width: float
    refinement: float
    axial_elements: int


def crack_surface(spec: CrackSurfaceSpec) -> CrackSurface:
    """Condense a tooth onto its crack surface and its flank; the mouth is below the loaded flank.

    Raises
    ------
    RingError, CondensationError : a stiffness matrix cannot be factorised
    """
    from threadpoolctl import threadpool_limits

    gear, material = spec.gear, spec.material
    young, poisson = material.elastic_modulus, material.poisson_ratio
    module, chord = gear.normal_module, root_chord(gear)[1]
    deepest = (DEEPEST + MARGIN) * chord

    def section(refinement: float, spacing: float) -> SectorMesh:
        return sector_mesh(gear, refinement, Slit(depth=deepest, angle=spec.angle, spacing=spacing * module))

    coarse = section(COARSE * spec.refinement, SPACING / spec.refinement)
    fine = section(FINE, FINE_SPACING)
    ends = axial_ends(spec.face_width, spec.axial_elements)
    rows = _loaded_rows(coarse)
    depth = chord * DEEPEST * np.linspace(0.0, 1.0, DEPTHS) ** 1.5
    with threadpool_limits(1):
        ring, found = side_by_side(
            lambda: solid_cracked_ring(coarse, young, poisson, ends, rows, REACH),
            lambda: [_plane_release(mesh, young, poisson, deepest) for mesh in (coarse, fine)],
        )
    grid = np.linspace(0.0, deepest, 4 * DEPTHS)
    reached = np.array([found[0](float(d)) for d in grid])
    front = np.interp([found[1](float(d)) for d in depth], reached, grid)
    axial = 2 * len(ends) - 1
    force = np.stack([ring.force[n].T.reshape(len(rows), axial, -1) for n in range(-REACH, REACH + 1)])
    return CrackSurface(
        stiffness=ring.stiffness,
        force=force,
        load_arc=coarse.flank_arc[rows],
        ends=ends,
        slit_node=_distances(coarse),
        depth=depth,
        front=front,
        elastic_modulus=young,
    )


def _loaded_rows(mesh: SectorMesh) -> np.ndarray:
    """Flank rows (row,) between elements, uniformly spaced over the involute."""
    between = np.arange(2, len(mesh.flank_arc), 2)
    wanted = np.linspace(mesh.form_arc, mesh.tip_arc, LOADED_ROWS)
    return np.unique(between[np.abs(mesh.flank_arc[between][:, None] - wanted).argmin(axis=0)])


def _distances(mesh: SectorMesh) -> np.ndarray:
    """Distance (slit node,) from the mouth, m."""
    return np.linalg.norm(mesh.points[mesh.slit] - mesh.points[mesh.slit[0]], axis=1)


def _plane_release(mesh: SectorMesh, young: float, poisson: float, deepest: float) -> Callable[[float], float]:
    """Function from depth (m) to the compliance (m2/N) added by a crack in plane deformation, mean over the flank."""
    from scipy.linalg import cho_solve

    loaded = np.flatnonzero(mesh.flank_arc >= mesh.form_arc)
    ring = plane_cracked_ring(mesh, young, poisson, flank_loads(mesh)[:, loaded])
    nodes = _distances(mesh)
    low, high = _slit_cells(nodes)
    components = len(ring.stiffness) // len(nodes)
    weight = np.gradient(mesh.flank_arc[loaded])  # nodes are closer at the tip; equal weight per height
    weight[[0, -1]] /= 2  # the trapezoidal rule

    def compliance(depth: float) -> float:
        covered = np.clip((depth - low) / (high - low), 0.0, 1.0)
        springs = young * (high - low) * THROUGH / nodes[1] * _held(covered)
        open_, factor = _released(ring.stiffness, springs, components)
        force = ring.force[0][open_]
        return float(weight @ np.einsum("gp,gp->p", force, cho_solve((factor, True), force)))

    return compliance


def node_cells(ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bounds (node,), m, of the cells of the nodes and middles of elements with these ends."""
    low, sizes = np.empty(2 * len(ends) - 1), np.diff(ends)
    low[0] = ends[0]
    low[2::2] = ends[1:] - CORNER * sizes
    low[1::2] = ends[:-1] + CORNER * sizes
    return low, np.append(low[1:], ends[-1])


def _slit_cells(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bounds of the cells of uniformly spaced slit nodes, mouth first, without the tip."""
    low, high = node_cells(np.append(nodes, nodes[-1] + nodes[1])[::2])
    return low[:-1], high[:-1]


def opened(
    surface: CrackSurface, depth_at: Callable[[np.ndarray], np.ndarray], extent: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Free openings (o,) of a crack, and the lower Cholesky factor (o, o) of K_oo + k.

    Parameters
    ----------
    surface : crack surface
    depth_at : depth (m) at axial coordinates (n,), continuous within the extent
    extent : both of its ends in the axial coordinate, m, ascending
    """
    low, high = _slit_cells(surface.slit_node)
    first, last = node_cells(surface.ends)
    start, end = (np.clip(bound, *_drawn_back(surface, extent)) for bound in (first, last))
    place = start[:, None] + (end - start)[:, None] * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    front = np.interp(depth_at(place), surface.depth, surface.front)
    through = np.clip((front - low[:, None, None]) / (high - low)[:, None, None], 0.0, 1.0).mean(axis=2)
    springs = THROUGH / surface.slit_node[1] * _held(through) + ALONG * _held((end - start) / (last - first)) / (
        last - first
    )
    springs = surface.elastic_modulus * np.outer(high - low, last - first) * springs
    return _released(surface.stiffness, springs.ravel(), 3)


def _drawn_back(surface: CrackSurface, extent: tuple[float, float]) -> tuple[float, float]:
    """The ends of the extent (m), shortened inside the face, as free pairs act slightly beyond their cells.

    The correction is complete at one mean element from the ends of the crack and of the face, and zero at them.
    """
    low, high = float(surface.ends[0]), float(surface.ends[-1])
    size, reach = (high - low) / (len(surface.ends) - 1), extent[1] - extent[0]
    back = [BACK * min(size, reach / 2, inside) for inside in (extent[0] - low, high - extent[1])]
    return extent[0] + back[0], extent[1] - back[1]


def _held(covered: np.ndarray) -> np.ndarray:
    """(1 - x) / x, infinite at 0."""
    with np.errstate(divide="ignore"):
        return (1.0 - covered) / covered


def _released(stiffness: np.ndarray, springs: np.ndarray, components: int) -> tuple[np.ndarray, np.ndarray]:
    """Free openings (o,) and the lower Cholesky factor of their stiffness with the springs.

    Parameters
    ----------
    stiffness : (pairs * components, same), N/m or per unit face width
    springs : (pair,) likewise; infinite for a rigid connection
    components : of the displacement
    """
    each = np.repeat(springs, components)
    open_ = np.flatnonzero(np.isfinite(each))
    matrix = stiffness[np.ix_(open_, open_)]
    matrix[np.arange(len(open_)), np.arange(len(open_))] += each[open_]
    return open_, np.linalg.cholesky(matrix)


def load_weights(surface: CrackSurface, arc: np.ndarray) -> np.ndarray:
    """Weights (load, row) of the loaded rows for loads at arc lengths (load,), m, on the flank."""
    from scipy.interpolate import CubicSpline

    rows = surface.load_arc
    weights: np.ndarray = CubicSpline(rows, np.eye(len(rows)))(np.clip(arc, rows[0], rows[-1]))
    return weights
