"""Table of `gearcase starts`: mean and spread of levels over several initial states of one motion.

The standard deviation s over n initial states is that of a single level from the mean. The 95 % confidence interval of
the mean is +/- t s/sqrt(n), where t is the 97.5 % point of Student's distribution with n - 1 degrees of freedom. Levels
in dB are averaged in dB.

References
----------
Student (1908), Biometrika 6(1), 1-25.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.io.text_table import Grid, grid
from pipelines.studies.trade.probes import Value


def spread_table(starts: Sequence[Sequence[Value]]) -> Grid:
    """Table with one row for each value; `starts` are two initial states or more, with the same values in one order."""
    from scipy.stats import t

    count = len(starts)
    factor = float(t.ppf(0.975, count - 1)) / np.sqrt(count)
    levels = np.array([[value.value for value in start] for start in starts])
    spreads = levels.std(axis=0, ddof=1)
    rows = [
        {
            "level": f"{value.name}, {value.unit}",
            "mean": float(own.mean()),
            "mean +/- (95 % interval)": factor * float(spread),
            "standard deviation": float(spread),
            "lowest": float(own.min()),
            "highest": float(own.max()),
        }
        for value, own, spread in zip(starts[0], levels.T, spreads, strict=True)
    ]
    return grid(f"{count} initial states", rows)
