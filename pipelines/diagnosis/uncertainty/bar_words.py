"""Error bars as text: a table for each window, and notes on the errors that they contain."""

from __future__ import annotations

from collections.abc import Sequence

from pipelines.diagnosis.uncertainty.bar_records import LineBar, LineBars
from pipelines.io.text_table import Grid, grid


def bars_grid(bars: Sequence[LineBar], window: str) -> Grid:
    """Table of the error bars of a window; without the columns of the numerical uncertainty where it is not known."""
    rows = []
    for bar in bars:
        row = {"line": f"envelope {bar.label}" if bar.kind == "envelope" else bar.label}
        row |= {"frequency Hz": f"{bar.frequency:.3f}", "level m/s²": f"{bar.level:.3g}"}
        if bar.numerical is not None:
            source = f"{bar.numerical.source} ({100 * bar.numerical.share:.0f} %)"
            row |= {"numerical uncertainty dB": str(bar.numerical), "main source (of variance)": source}
        rows.append(row | {"uncertain damping dB": str(bar.inputs)})
    title = f"Error bars in the window {window}: 5 to 95 % of the samples, in dB relative to the faulty run"
    return grid(title, rows, frozenset(i for i, bar in enumerate(bars) if bar.detected))


def bars_words(found: LineBars | str) -> str:
    """Tables and notes for the terminal, or the reason why there are no error bars."""
    if isinstance(found, str):
        return found + "\n"
    windows = dict.fromkeys(bar.window for bar in found.bars)
    parts = [bars_grid(found.of(window), window).to_text() for window in windows]
    return "\n\n".join([*parts, "\n".join(found.notes)]) + "\n"
