"""Features of several recordings, and their differences from those of the first one in dB.

Levels are 20 log10 of the features, averaged over the common channels of all recordings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.diagnosis.comparison.compared_recording import ComparedRecording
from pipelines.diagnosis.evidence import counted
from pipelines.signals.features.feature_table import WHOLE, FeatureTable, confirmed
from pipelines.signals.features.recording_features import FeatureError, recording_features
from pipelines.signals.orders.kinematics import Kinematics

Line = tuple[str, str]  # component and feature


@dataclass(frozen=True, eq=False, kw_only=True)
class Features:
    """Features of recordings; `level` (recording, line) in dB re 1 unit of the feature, NaN if a line is missing."""

    tables: tuple[FeatureTable, ...]
    lines: tuple[Line, ...]
    level: np.ndarray

    @property
    def value(self) -> np.ndarray:
        """Values (recording, line) in the unit of the feature, geometric means over the channels."""
        return 10.0 ** (self.level / 20.0)

    @property
    def difference(self) -> np.ndarray:
        """Levels (recording, line) over those of the first recording, dB."""
        return self.level - self.level[0]

    @property
    def rms(self) -> np.ndarray:
        """Root mean square (recording, channel), m/s2."""
        return np.array([table.value[:, table.feature.index("rms")] for table in self.tables])


def features_of(parts: Sequence[ComparedRecording]) -> Features:
    """The features of recordings with the same channels and rate.

    Raises
    ------
    FeatureError : all shafts make too few turns, see `recording_features`
    """
    tables = confirmed([_table(part) for part in parts])
    lines = tuple(dict.fromkeys(line for table in tables for line in table.lines))
    known = [np.where(np.all(table.value > 0.0, axis=0), table.levels, np.nan) for table in tables]
    by_line = [dict(zip(table.lines, own, strict=True)) for table, own in zip(tables, known, strict=True)]
    level = np.array([[own.get(line, np.nan) for line in lines] for own in by_line])
    return Features(tables=tuple(tables), lines=lines, level=level)


def _table(part: ComparedRecording) -> FeatureTable:
    try:
        return recording_features(part.dataset(), part.kinematics, part.rotation, part.spans)
    except FeatureError as error:
        raise FeatureError(f"{part.name}: {error}") from error


def most_different_shaft(found: Features, kinematics: Kinematics, among: Sequence[str]) -> str:
    """The shaft whose features, with those of its gears and bearings, have the largest mean difference.

    Weak orders of a shaft have little weight, as in a verdict.
    """
    rms = found.level[0, found.lines.index((WHOLE, "rms"))]
    level = counted(found.level, [feature for _, feature in found.lines], rms)
    size = np.abs(level[1:] - level[0])

    def mean(name: str) -> float:
        values = size[:, [kinematics.shaft_of(component) == name for component, _ in found.lines]]
        return float(values[np.isfinite(values)].mean()) if np.isfinite(values).any() else 0.0

    return max(among, key=mean)
