"""Reference frequencies of a casing that is its own mirror image about y = 0, with their own uncertainty.

One half of the body is meshed with tetrahedra by gmsh, graded to its singular edges (`graded`) and given cubic
displacements (`cubic`); the modes of the whole are those of the half that are symmetric and those that are
antisymmetric about the middle plane. Two errors are left, and both are taken off:

    edges     one more level on the largest elements tells what the levels that are missing leave, a geometric row:
              E = (f_n - f_n+1) / (1 - s^q), s = 1/4, q = 1.09; with the element size it falls as h^q
    elements  from three sizes with n levels: g = f_n - E (h/h_3)^q = f_0 + c h^p with the median order p of all modes

The uncertainty of a mode is half of all that is taken off, and the scatter (rms over the modes) of the three meshes
about the common order. From a mode that has no counterpart on one of the larger meshes the mean of the others is taken
off, and all of it is uncertain. Frequencies on the finest mesh are upper bounds of the true ones (Ritz).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from benchmarks.casing_limits.cubic import cubic_matrices
from benchmarks.casing_limits.graded import SHARE, graded
from fem.casing.mesh.gmsh_mesh import tetrahedra
from fem.casing.mesh.gmsh_session import session
from fem.casing.reduced.lanczos import block_lanczos
from fem.casing.uncertainty.frequency_limits import EDGE_ORDER
from fem.casing.uncertainty.pairing import counterparts, sample_nodes
from fem.elements.materials import Material
from fem.numerics.linear_solver import factorize

RATIOS = (1.0, 1.3, 1.7)  # sizes of the three meshes
AROUND = 10.0  # elements around a full circle
_CUBIC_ORDER = 6.0  # of frequencies of smooth bodies on cubic elements
_FAR = 1e4  # mm
_MIDDLE = 1e-9  # m


@dataclass(frozen=True, eq=False)
class Reference:
    """Of the modes that were asked for; nan without a counterpart on the finest mesh."""

    limits: np.ndarray  # Hz
    uncertainties: np.ndarray  # Hz
    finest: np.ndarray  # Hz, on the finest mesh: upper bounds
    order: float
    unknowns: int  # of one half of the body on the finest mesh


def reference(
    build: Callable[[Any], None],
    material: Material,
    size: float,
    finest_levels: int,
    frequencies: np.ndarray,
    shapes: np.ndarray,
) -> Reference:
    """Reference of given modes.

    Parameters
    ----------
    build : makes the whole solid in an open session of gmsh, mm; its lowest plane is clamped
    material : of the casing
    size, finest_levels : of the smallest of the three element sizes, m, and how often elements are divided at edges
    frequencies, shapes : (m,) Hz and (k, m) at `sample_nodes` of the modes that are looked for
    """
    highest, sizes = 1.03 * frequencies[-1], size * np.array(RATIOS)
    rows, unknowns = [], 0
    for ratio, levels in (*((ratio, finest_levels) for ratio in RATIOS), (RATIOS[-1], finest_levels + 1)):
        mesh = half_mesh(build, ratio * size, AROUND)
        found, others, n = half_modes(*mesh, material, levels, highest)
        number = counterparts(shapes, others)
        rows.append(np.where(number < 0, np.nan, found[number]))
        unknowns = unknowns or n
        change = np.nanmean(rows[-1] / frequencies) - 1.0
        print(
            f"  reference {1000 * ratio * size:.1f} mm, {levels} levels: {n} unknowns, {100 * change:+.3f} %",
            flush=True,
        )
    f = np.array(rows)
    edges = (f[2] - f[3]) / (1.0 - SHARE**EDGE_ORDER) * (sizes[:, None] / sizes[2]) ** EDGE_ORDER
    g = f[:3] - edges
    middle, large = (g[1:] - g[0]) / g[0]
    known = np.isfinite(middle) & np.isfinite(large)
    order = _order(float(np.median(middle[known] / large[known])))
    scatter = math.sqrt(float(np.mean((middle - _ratio(order) * large)[known] ** 2)))
    taken = edges[0] / f[0] + large / (RATIOS[2] ** order - 1.0)
    uncertain = 0.5 * abs(taken) + scatter
    usual = float(np.mean(taken[known]))
    taken, uncertain = np.where(known, taken, usual), np.where(known, uncertain, abs(usual) + scatter)
    return Reference(f[0] * (1.0 - taken), uncertain * f[0], f[0], order, unknowns)


def half_modes(
    nodes: np.ndarray, elements: np.ndarray, material: Material, levels: int, highest: float
) -> tuple[np.ndarray, np.ndarray, int]:
    """Frequencies (m,) in Hz up to `highest`, shapes (k, m) at `sample_nodes` of the whole, unknowns of the half.

    Parameters
    ----------
    nodes, elements : of the half, (n, 3) m and (e, 10)
    material : of the casing
    levels : how often elements are divided at the singular edges
    highest : Hz
    """
    nodes, elements = graded(nodes, elements, _lowest(nodes), levels)
    places, stiffness, mass = cubic_matrices(nodes, elements, material)
    mirrored = np.concatenate([places, places * [1.0, -1.0, 1.0]])
    chosen = sample_nodes(mirrored)
    half, beyond = chosen % len(places), chosen >= len(places)
    frequencies, shapes = [], []
    for symmetric in (True, False):
        held = np.zeros(places.shape, bool)
        held[_lowest(places)] = True
        held[abs(places[:, 1]) < _MIDDLE] |= [not symmetric, symmetric, not symmetric]
        free = np.flatnonzero(~held.ravel())
        factor = factorize(stiffness[free][:, free], block=1)
        smallest = (2.0 * math.pi * highest) ** -2
        theta, phi = block_lanczos(factor.solve, mass[free][:, free].tocsr(), smallest=smallest)
        whole = np.zeros((held.size, len(theta)))
        whole[free] = phi
        sampled = whole.reshape(-1, 3, len(theta))[half]
        sampled[beyond] *= (1.0 if symmetric else -1.0) * np.array([1.0, -1.0, 1.0])[:, None]
        frequencies.append(1.0 / (2.0 * math.pi * np.sqrt(theta)))
        shapes.append(sampled.reshape(-1, len(theta)))
    found = np.concatenate(frequencies)
    ascending = np.argsort(found)
    return found[ascending], np.concatenate(shapes, axis=1)[:, ascending], len(stiffness.indptr) - 1


def half_mesh(build: Callable[[Any], None], size: float, around: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3), m, and ten-node tetrahedra (e, 10) of the half of a solid at y < 0.

    Parameters
    ----------
    build : makes the whole solid in an open session, mm
    size : m, wanted edge length
    around : least number of elements around a full circle
    """
    with session() as gmsh:
        build(gmsh)
        occ = gmsh.model.occ
        occ.intersect(gmsh.model.getEntities(3), [(3, occ.addBox(-_FAR, -_FAR, -_FAR, 2 * _FAR, _FAR, 2 * _FAR))])
        occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", around)
        raw = tetrahedra(gmsh, size, [], {})
    used, elements = np.unique(raw.elements, return_inverse=True)
    return raw.nodes[used], elements.reshape(raw.elements.shape)


def _lowest(nodes: np.ndarray) -> np.ndarray:
    """Bool (node,): on the lowest plane."""
    return np.asarray(nodes[:, 2] < nodes[:, 2].min() + 1e-7)


def _ratio(order: float) -> float:
    return math.expm1(order * math.log(RATIOS[1])) / math.expm1(order * math.log(RATIOS[2]))


def _order(ratio: float) -> float:
    """The order of a ratio of changes, between those of edges and of smooth bodies."""
    if ratio >= _ratio(EDGE_ORDER):
        return EDGE_ORDER
    if ratio <= _ratio(_CUBIC_ORDER):
        return _CUBIC_ORDER
    return float(brentq(lambda order: _ratio(order) - ratio, EDGE_ORDER, _CUBIC_ORDER))
