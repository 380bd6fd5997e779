"""What the slices of a mesh law do to the transmission error: its distance from the finest level, and the tones in it.

The slices enter and leave contact n / eps_beta times in a mesh cycle, far above the orders of the mesh itself: the
largest line of the distance from `LOWEST_ORDER` on is taken for their tone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipelines.io.grid import Grid
from pipelines.report.contents import grid
from pipelines.studies.trade.probes import POSITIONS

if TYPE_CHECKING:
    from pipelines.studies.trade.refinement import RefinementStudy

PROBE = "transmission"
LOWEST_ORDER = 8


def tone_and_distance(error: np.ndarray, finest: np.ndarray) -> tuple[float, float]:
    """Largest line from `LOWEST_ORDER` on, and rms without its mean, of the difference of two curves (position,)."""
    apart = np.subtract(error, finest)
    lines = 2 * np.abs(np.fft.rfft(apart)) / apart.size
    return float(lines[LOWEST_ORDER:].max()), float(apart.std())


def slicing_table(name: str, found: RefinementStudy) -> Grid:
    """Tone and rms distance of e from the finest level, by stage and level, um."""
    curves = [np.array([v.value for v in level.by_probe[PROBE]]).reshape(-1, POSITIONS) for level in found.levels]
    rows = []
    for stage, finest in enumerate(curves[0]):
        for number, words in enumerate(("largest line", "rms")):
            row: dict[str, object] = {"TE less that of the finest level": f"stage {stage + 1} {words}, um"}
            for fineness, level in zip(found.fineness[1:], curves[1:], strict=True):
                value = tone_and_distance(level[stage], finest)[number]
                row["in use" if fineness == 1.0 else f"x{fineness:.3g}"] = f"{value:.2g}"
            rows.append(row)
    return grid(f"{name}: tones of the slices (mesh order {LOWEST_ORDER} and above) and error of e", rows)
