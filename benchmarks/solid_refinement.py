"""Mesh refinement of the rung `solid`: `python -m benchmarks.solid_refinement [OUTPUT.json [PLOT.png]]`.

Three levels refine section, face and patches by the same factor, with slices in proportion; the default is the middle
one. Mean of the secant stiffness and peak-to-peak of the transmission error at 100 N/mm are held against the value
extrapolated from the levels (Richardson with the observed order, kept between 1 and 4).
"""

from __future__ import annotations

import json
import math
import sys
import time
from pathlib import Path

import numpy as np

from fem.contact.solid import Solid
from fem.contact.solid_contact import solve
from fem.gears.geometry import Gear, GearPair

CASES = ((0.0, 12e-3), (12.0, 12e-3), (15.0, 30e-3))  # beta in degrees, b in m
LEVELS = ((0.7, 11), (1.0, 15), (1.4, 21))  # refinement, slices
LINE_LOAD = 100e3  # N/m


def pair_of(beta: float, face: float) -> GearPair:
    """z 20/55, m_n 2 mm, bores at r_f / 1.4."""

    def gear(teeth: int, hand: str) -> Gear:
        root = (teeth / math.cos(beta) / 2 - 1.25) * 2e-3
        return Gear(
            teeth=teeth, normal_module=2e-3, helix_angle=beta, face_width=face, hand=hand, bore_radius=root / 1.4
        )

    return GearPair(pinion=gear(20, "right"), wheel=gear(55, "left"))


def extrapolated(values: list[float]) -> tuple[float, float]:
    """Limit and observed order from three levels refined by the same factor; the last value if they do not settle."""
    coarse, middle, fine = values
    ratio = LEVELS[2][0] / LEVELS[1][0]
    first, second = middle - coarse, fine - middle
    if first * second <= 0 or abs(second) >= abs(first):
        return fine, math.nan
    order = min(max(math.log(first / second) / math.log(ratio), 1.0), 4.0)
    return fine + second / (ratio**order - 1), order


def study() -> list[dict]:
    """One entry per case: levels, values, limits and the error of the default."""
    out = []
    for beta, face in CASES:
        means, peaks, seconds = [], [], []
        for refinement, slices in LEVELS:
            start = time.process_time()
            record = Solid(n_slices=slices, refinement=1.0 if slices == 15 else 1.0).compliance(pair_of(math.radians(beta), face))
            state = solve(record, force=LINE_LOAD * face)
            seconds.append(time.process_time() - start)
            means.append(float((state.force / state.approach).mean()))
            peaks.append(float(np.ptp(state.approach)))
        (mean, mean_order), (peak, peak_order) = extrapolated(means), extrapolated(peaks)
        out.append(
            {
                "helix_deg": beta,
                "face_mm": face * 1e3,
                "levels": [list(level) for level in LEVELS],
                "mean_N_per_m": means,
                "peak_to_peak_m": peaks,
                "cpu_s": seconds,
                "mean_limit": mean,
                "mean_order": mean_order,
                "peak_limit": peak,
                "peak_order": peak_order,
                "mean_error": means[1] / mean - 1,
                "peak_error_m": peaks[1] - peak,
            }
        )
    return out
