"""Limits and bands of natural frequencies whose error comes from edges and from walls, each measured on its own.

27-node hexahedra of a plain housing have one element through a wall at any size, so that meshes of several sizes do not
show the error of its inner edges. Three meshes with one change at a time do, because the energies that single elements
miss add up:

    f     the mesh itself, size h
    F     elements R times as large, divided at the edges as those of f are: what the walls between the edges miss
    D     as F, with every element beside an inner edge divided at a third of its thickness: what the edges miss

    edges:  e = F/D - 1,   missing altogether  gamma_e e,   gamma_e = 1 / (1 - 3^-q)
    walls:  i = F/f - 1,   missing altogether  gamma_i i,   gamma_i = 1 / (R^4 - 1)

The error of an edge falls with the order q = 1.09 of its singularity at last (Szabo & Babuska 1991, Finite Element
Analysis, section 10.1) and with that of smooth fields, 4, while the bending of the walls beside it is what is missed:
gamma_e = 1.43 and 1.01. The limit takes the middle and the band holds both. Between the edges the fields are smooth;
the band holds anything from no error to twice that of order 4 (order 3 at R = 1.8). Both parts add up, because larger
elements along the edges count in both; and each is in proportion to the change of the mode, at least to the median
change, because close modes turn into one another from mesh to mesh.

Edges of feet, clamped rims and circles of bosses are divided on none of the three meshes and are left out of limits
and bands. On the rig (22 mm, layers of 2 mm) cubic tetrahedra graded to all edges are 1.3 % below the mesh in the mean,
the limits 0.9 % (`benchmarks.casing_limits`, table in docs/theory.md).
"""

from __future__ import annotations

import numpy as np

from fem.casing.mesh_error.frequency_limits import EDGE_ORDER, LEAST_MODES, FrequencyLimits, LimitError

SMOOTH_ORDER = 4.0  # of frequencies on quadratic elements


def edge_limits(ratio: float, share: float, frequencies: np.ndarray) -> FrequencyLimits:
    """Limits and bands of natural frequencies.

    Parameters
    ----------
    ratio : R, size of the larger elements over that of the mesh itself
    share : of the thickness of an element beside an edge, at which it is divided
    frequencies : float (3, mode), Hz, of the same modes on f, F and D; nan where a mesh has no counterpart

    Raises
    ------
    LimitError : elements that are not larger, or fewer than three modes with counterparts
    """
    f = np.asarray(frequencies, float)
    if not ratio > 1.0 or f.ndim != 2 or len(f) != 3:
        raise LimitError(f"ratio {ratio:g} and frequencies {f.shape}: give larger elements, three rows of modes")
    edges, walls = f[1] / f[2] - 1.0, f[1] / f[0] - 1.0
    known = np.isfinite(edges) & np.isfinite(walls)
    if known.sum() < LEAST_MODES:
        raise LimitError(
            f"{int(known.sum())} modes have counterparts on both coarser meshes (least {LEAST_MODES}); use smaller "
            "elements on all meshes"
        )
    spread = np.where(known, 0.0, edges[known].std() + walls[known].std())
    edges, walls = (np.where(known, change, change[known].mean()) for change in (edges, walls))
    of_edges = [1.0 / (1.0 - share**order) for order in (EDGE_ORDER, SMOOTH_ORDER)]
    of_walls = 1.0 / (ratio**SMOOTH_ORDER - 1.0)
    limits = f[0] * (1.0 - 0.5 * sum(of_edges) * edges - of_walls * walls)
    backwards = np.maximum(-edges, 0.0) + np.maximum(-walls, 0.0) + spread
    at_edges, at_walls = (np.maximum(abs(part), np.median(abs(part))) for part in (edges, walls))
    fixed = 0.5 * (of_edges[0] - of_edges[1]) * at_edges + backwards
    return FrequencyLimits(
        frequencies=f[0],
        order=SMOOTH_ORDER,
        orders=np.full(f.shape[1], np.nan),
        limits=limits,
        bands=(fixed + of_walls * at_walls) * f[0],
        fixed_bands=fixed * f[0],
        correction=float(np.mean(1.0 - limits[known] / f[0, known])),
    )
