"""Whether a claim holds: a mean over seeds, its standard error, and a limit that was stated beforehand.

The mean of n values with standard deviation s lies within t s/sqrt(n) of the true one with 95 % probability, t the
97.5 % point of Student's distribution with n - 1 degrees of freedom. A claim of at least so much holds if this whole
interval reaches it, it does not hold if the whole interval stays below. Otherwise it is undecided.

References
----------
Student (1908), Biometrika 6(1), 1-25.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

HOLDS, FAILS, OPEN = "holds", "does not hold", "undecided"
FEWEST = 2  # seeds of a standard error


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """`mean` with its `standard_error`, both in the unit of the values; `verdict` is one of HOLDS, FAILS, OPEN."""

    mean: float
    standard_error: float
    verdict: str

    def words(self) -> str:
        """The numbers as a cell of a table."""
        return f"{self.mean:+.1f} ± {self.standard_error:.1f}"


def judge(values: Sequence[float] | np.ndarray, least: float) -> Judgement:
    """Whether the mean of one value per seed (seed,) is at least so much.

    Raises
    ------
    ValueError : fewer than two values
    """
    from scipy.stats import t

    values = np.asarray(values, dtype=float)
    if values.size < FEWEST:
        raise ValueError(f"{values.size} values: a standard error needs at least {FEWEST}.")
    mean, error = float(values.mean()), float(values.std(ddof=1) / np.sqrt(values.size))
    reach = float(t.ppf(0.975, values.size - 1)) * error
    over = mean - least
    verdict = HOLDS if over >= reach else FAILS if over <= -reach else OPEN
    return Judgement(mean=mean, standard_error=error, verdict=verdict)
