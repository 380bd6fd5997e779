"""Error bars of lines: what the numerics leave open of their levels, and beside it what uncertain inputs do."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

LOW, HIGH = 5.0, 95.0  # per cent of the draws


@dataclass(frozen=True, kw_only=True)
class Band:
    """From `low` to `high`, 5 to 95 % of the draws, dB over the level of the run; `source` makes `share` of it."""

    low: float
    high: float
    source: str
    share: float

    @property
    def width(self) -> float:
        """Of the band, dB."""
        return self.high - self.low


@dataclass(frozen=True, kw_only=True)
class LineBar:
    """A line with its bands; `numerical` is None where the error of the casing's mesh is not known."""

    window: str
    kind: str  # that of `pipelines.signals.lines`
    label: str
    frequency: float  # Hz
    level: float  # m/s2
    detected: bool
    numerical: Band | None
    inputs: Band


@dataclass(frozen=True, kw_only=True)
class LineBars:
    """Bars of all lines clearly over their floor; `notes` say in sentences what they hold and what they do not."""

    bars: tuple[LineBar, ...]
    notes: tuple[str, ...]

    def of(self, window: str) -> tuple[LineBar, ...]:
        """Those of a window."""
        return tuple(bar for bar in self.bars if bar.window == window)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, as JSON takes them; levels in m/s2, bands in dB over the level."""
        return dataclasses.asdict(self)


def band(changes: np.ndarray, alone: dict[str, float]) -> Band:
    """The band of drawn changes.

    Parameters
    ----------
    changes : (draw,) dB
    alone : change in dB by a standard deviation of every source on its own
    """
    low, high = np.percentile(changes, (LOW, HIGH))
    total = sum(change**2 for change in alone.values())
    source = max(alone, key=lambda name: abs(alone[name]), default="")
    share = alone[source] ** 2 / total if total > 0.0 else 0.0
    return Band(low=float(low), high=float(high), source=source if share else "none", share=float(share))
