"""Limits and bands of natural frequencies of cubic elements, by quadratic displacements on the same mesh.

What the quadratic elements are stiffer by, e = f_2 / f_3 - 1, tells what the cubic ones still are: f_0 = f_3 (1 - g e).
No mesh is made anew, so that nothing is left to chance. In smooth parts of a body errors fall fast with the degree p,
at a re-entrant edge as p^-2q with the order q = 1.09 in the element size: there g = 1 / (1.5^2.18 - 1) = 0.70 (Szabo &
Babuska 1991, Finite Element Analysis, section 10.1), and g lies between 0 and that.

`SHARES` hold g of 95 % of the modes of each of six housings of tetrahedra, with two or three sizes each (elements of
1.3 to 5 wall thicknesses): a casting, a drum and a box with ribs and flange gave the numbers, three more were foretold.
Hexahedra have functions at their edges (`fem.casing.enrichment`), which leave other things. The rig and a bench, with
three sizes each, gave 0.10 to 0.60; two more housings, foretold with that, lay outside in 10 and 25 % of their modes
and widened it to both sides; the modes of a fifth, a tall box, all lay inside (`python -m benchmarks.casing_limits`).
The limit lies half-way, the band reaches to both ends.
"""

from __future__ import annotations

import numpy as np

from fem.casing.uncertainty.frequency_limits import LEAST_MODES, FrequencyLimits, LimitError

SHARES = {4: (0.08, 0.47), 8: (0.06, 0.62)}  # g, by the corners of the element
ORDER = 1.5  # with which e falls with the element size: 1.1 to 1.9 of tetrahedra, 1.0 (15 mm) to 2.4 (37 mm) on the rig


def cubic_limits(cubic: np.ndarray, quadratic: np.ndarray, *, corners: int) -> FrequencyLimits:
    """Limits f_3 (1 - g e) and bands, e taken for at least its median in these.

    Parameters
    ----------
    cubic, quadratic : (mode,), Hz, of the same modes; nan where the quadratic elements have no counterpart
    corners : of the elements, 4 or 8

    Raises
    ------
    LimitError : fewer than three modes with counterparts
    """
    excess = quadratic / cubic - 1.0
    known = np.isfinite(excess)
    if known.sum() < LEAST_MODES:
        raise LimitError(
            f"{int(known.sum())} modes have counterparts among those of quadratic elements (least {LEAST_MODES}); "
            "use a smaller element size"
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
