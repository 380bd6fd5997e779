"""Records of the error bars of lines: numerical uncertainty of levels, and the effect of uncertain inputs.

`pipelines.diagnosis.uncertainty.sampled_bars` computes them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.storage import shown_html

SAMPLES = 200  # of each uncertainty
LOW, HIGH = 5.0, 95.0  # per cent of the samples


@dataclass(frozen=True, kw_only=True)
class Band:
    """Range of 5 to 95 % of the samples, `low` to `high` in dB relative to the level of the run.

    `source` is its largest contribution, `share` the part of the variance that it causes.
    """

    low: float
    high: float
    source: str
    share: float

    @property
    def width(self) -> float:
        """Width of the band, dB."""
        return self.high - self.low

    def __str__(self) -> str:
        low, high = (round(end, 2) + 0.0 for end in (self.low, self.high))  # + 0.0 makes zero of minus zero
        return f"{low:+.2f} to {high:+.2f}" if low or high else "below 0.01"


@dataclass(frozen=True, kw_only=True)
class LineBar:
    """A line with its uncertainty bands; `numerical` is None if the error of the casing mesh is not known."""

    window: str
    kind: str  # of `pipelines.signals.line_table`
    label: str
    frequency: float  # Hz
    level: float  # m/s2
    detected: bool
    numerical: Band | None
    inputs: Band


@dataclass(frozen=True, kw_only=True)
class LineBars:
    """Error bars of all lines clearly over their floor; `notes` state which errors they contain and which they omit."""

    bars: tuple[LineBar, ...]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<LineBars: {len(self.bars)} lines in {len({bar.window for bar in self.bars})} windows>"

    def of(self, window: str) -> tuple[LineBar, ...]:
        """Error bars of a window."""
        return tuple(bar for bar in self.bars if bar.window == window)

    def _repr_html_(self) -> str:
        """Table of the lines with their bands, and the notes, for a notebook."""
        head = ("window", "line", "Hz", "m/s²", "numerical uncertainty, dB", "uncertain damping, dB")
        rows = (
            (
                bar.window,
                bar.label,
                bar.frequency,
                bar.level,
                *(one and str(one) for one in (bar.numerical, bar.inputs)),
            )
            for bar in self.bars
        )
        notes = shown_html.table("Notes", (), ((note,) for note in self.notes))
        return shown_html.table("Error bars, 5 to 95 %, relative to the level of the run", head, rows) + notes


def band(changes: np.ndarray, alone: dict[str, float]) -> Band:
    """The band of sampled changes of a level.

    Parameters
    ----------
    changes : (sample,) dB
    alone : change in dB by one standard deviation of each single source
    """
    low, high = np.percentile(changes, (LOW, HIGH))
    total = sum(change**2 for change in alone.values())
    source = max(alone, key=lambda name: abs(alone[name]), default="")
    share = alone[source] ** 2 / total if total > 0.0 else 0.0
    return Band(low=float(low), high=float(high), source=source if share else "none", share=float(share))
