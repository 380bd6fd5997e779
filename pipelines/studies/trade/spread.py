"""Mean and spread of levels over several starts of one motion.

The standard deviation s over n starts tells how far one start may lie from the mean; the mean itself is known to
t s/sqrt(n), t the 97.5 % point of Student's distribution with n - 1 degrees of freedom. Levels in dB are averaged as
they are.

References
----------
Student (1908), Biometrika 6(1), 1-25.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.io.grid import Grid
from pipelines.studies.trade.probes import Value


def spread_table(starts: Sequence[Sequence[Value]]) -> Grid:
    """A row per value; the same values, in the same order, for every start (two or more)."""
    from scipy.stats import t

    count = len(starts)
    factor = float(t.ppf(0.975, count - 1)) / np.sqrt(count)
    rows = []
    for same in zip(*starts, strict=True):
        levels = np.array([value.value for value in same])
        spread = float(levels.std(ddof=1))
        numbers = (levels.mean(), factor * spread, spread, levels.min(), levels.max())
        rows.append((f"{same[0].name}, {same[0].unit}", *(f"{number:.4g}" for number in numbers)))
    headers = ("level", "mean", "mean +/- (95 % interval)", "standard deviation", "lowest", "highest")
    return Grid(title=f"{count} initial states", headers=headers, rows=tuple(rows))
