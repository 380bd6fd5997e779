"""The features of several recordings side by side, and their differences in dB over the first one.

Levels are 20 log10 of the features in the mean over the channels that all recordings have, as a verdict takes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.diagnosis.comparison.part import Part
from pipelines.diagnosis.verdict import counted
from pipelines.signals.features.recorded import feature_table
from pipelines.signals.features.table import WHOLE, FeatureTable
from pipelines.signals.orders.kinematics import Kinematics

Line = tuple[str, str]  # component and feature


@dataclass(frozen=True, eq=False, kw_only=True)
class Features:
    """`level` (recording, line), dB re 1 in the unit of the feature; NaN where a recording does not have a line."""

    tables: tuple[FeatureTable, ...]
    lines: tuple[Line, ...]
    level: np.ndarray

    @property
    def value(self) -> np.ndarray:
        """Values (recording, line) in the unit of the feature, geometric means over the channels."""
        return 10.0 ** (self.level / 20.0)

    @property
    def difference(self) -> np.ndarray:
        """Levels (recording, line) over those of the first recording, dB.

        Weak orders of a shaft hardly count, as in a verdict.
        """
        rms = self.level[0, self.lines.index((WHOLE, "rms"))]
        level = counted(self.level, [feature for _, feature in self.lines], rms)
        return level - level[0]

    @property
    def rms(self) -> np.ndarray:
        """Root mean square (recording, channel), m/s2."""
        return np.array([table.value[:, table.feature.index("rms")] for table in self.tables])


def features_of(parts: Sequence[Part]) -> Features:
    """The features of recordings with the same channels and rate.

    Raises
    ------
    FeatureError : nothing turns often enough, see `pipelines.signals.features.recorded`
    """
    tables = tuple(feature_table(part.dataset(), part.kinematics, part.rotation, part.spans) for part in parts)
    lines = tuple(dict.fromkeys(line for table in tables for line in table.lines))
    level = np.full((len(parts), len(lines)), np.nan)
    for row, table in zip(level, tables, strict=True):
        positive = np.all(table.value > 0.0, axis=0)
        for line, one, known in zip(table.lines, table.levels, positive, strict=True):
            row[lines.index(line)] = one if known else np.nan
    return Features(tables=tables, lines=lines, level=level)


def most_different_shaft(found: Features, kinematics: Kinematics, among: Sequence[str]) -> str:
    """The shaft of which the features, with those of what sits on it, differ most in the mean."""
    size = np.abs(found.difference[1:])

    def mean(name: str) -> float:
        values = size[:, [kinematics.shaft_of(component) == name for component, _ in found.lines]]
        return float(values[np.isfinite(values)].mean()) if np.isfinite(values).any() else 0.0

    return max(among, key=mean)
