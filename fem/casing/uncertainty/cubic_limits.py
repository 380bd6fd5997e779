"""Extrapolated frequencies and uncertainty bands of cubic elements, by p-refinement on the same mesh.

The discretisation error of cubic elements is estimated from the change e = f_2 / f_3 - 1 of the frequencies with
quadratic elements: f_0 = f_3 (1 - g e). The mesh is reused, so mesh scatter cancels. In smooth parts of a body errors
decrease fast with the degree p. At a re-entrant edge they decrease as p^-2q, with the order q = 1.09 in the element
size, which gives g = 1 / (1.5^2.18 - 1) = 0.70 (Szabo & Babuska 1991, Finite Element Analysis, section 10.1). In
general g is between 0 and that.

`SHARES` are the range of g that contains 95 % of the modes of each of six housings meshed with tetrahedra of 1.3 to 5
wall thicknesses; three of the six were blind predictions. Hexahedra have edge-singularity enrichment
(`fem.casing.enrichment`), and hence another range of g, from four housings; it contains all modes of a fifth, predicted
blindly (module `benchmarks.casing_limits`). The extrapolated frequency uses the middle of the range; the band extends
to both ends.
"""

from __future__ import annotations

import numpy as np

from fem.casing.uncertainty.frequency_limits import LEAST_MODES, FrequencyLimits, LimitError

SHARES = {4: (0.08, 0.47), 8: (0.06, 0.62)}  # g, by the corners of the element
ORDER = 1.5  # order of e in the element size: 1.1 to 1.9 for tetrahedra, 1.0 (15 mm) to 2.4 (37 mm) on the rig


def cubic_limits(cubic: np.ndarray, quadratic: np.ndarray, *, corners: int) -> FrequencyLimits:
    """Extrapolated frequencies f_3 (1 - g e), and bands, for which e is at least its median.

    Parameters
    ----------
    cubic, quadratic : (mode,), Hz, of the same modes; nan without counterpart on the quadratic elements
    corners : of the elements, 4 or 8

    Raises
    ------
    LimitError : fewer than three modes with counterparts
    """
    excess = quadratic / cubic - 1.0
    known = np.isfinite(excess)
    if known.sum() < LEAST_MODES:
        raise LimitError(
            f"{int(known.sum())} modes have counterparts among those of quadratic elements, at least {LEAST_MODES} are "
            "needed; use a smaller element size"
        )
    usual = float(np.median(excess[known]))
    excess = np.where(known, excess, usual)
    least, most = SHARES[corners]
    limits = cubic * (1.0 - 0.5 * (least + most) * excess)
    return FrequencyLimits(
        frequencies=cubic,
        order=ORDER,
        orders=np.full(len(cubic), np.nan),
        limits=limits,
        bands=0.5 * (most - least) * cubic * np.maximum(excess, usual),
        fixed_bands=np.zeros(len(cubic)),
        correction=float(np.mean(1.0 - limits[known] / cubic[known])),
    )
