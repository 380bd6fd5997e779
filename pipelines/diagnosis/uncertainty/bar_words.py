"""Error bars as text: a table for each window, and notes on the errors that they contain."""

from __future__ import annotations

from collections.abc import Sequence

from pipelines.diagnosis.uncertainty.bar_records import Band, LineBar, LineBars
from pipelines.io.text_table import Grid


def bars_grid(bars: Sequence[LineBar], window: str) -> Grid:
    """Table of the error bars of a window; without the columns of the numerical uncertainty where it is not known."""
    numerical = any(bar.numerical is not None for bar in bars)
    known = ("numerical uncertainty dB", "main source (of variance)") if numerical else ()
    headers = ("line", "frequency Hz", "level m/s²", *known, "uncertain damping dB")
    rows = tuple(
        (
            f"envelope {bar.label}" if bar.kind == "envelope" else bar.label,
            f"{bar.frequency:.3f}",
            f"{bar.level:.3g}",
            *(_numerical_cells(bar.numerical) if numerical else ()),
            str(bar.inputs),
        )
        for bar in bars
    )
    title = f"Error bars in the window {window}: 5 to 95 % of the samples, in dB relative to the faulty run"
    return Grid(
        title=title,
        headers=headers,
        rows=rows,
        marked=frozenset(i for i, bar in enumerate(bars) if bar.detected),
    )


def bars_words(found: LineBars | str) -> str:
    """Tables and notes for the terminal, or the reason why there are no error bars."""
    if isinstance(found, str):
        return found + "\n"
    windows = dict.fromkeys(bar.window for bar in found.bars)
    parts = [bars_grid(found.of(window), window).to_text() for window in windows]
    return "\n\n".join([*parts, "\n".join(found.notes)]) + "\n"


def _numerical_cells(band: Band | None) -> tuple[str, str]:
    return ("", "") if band is None else (str(band), f"{band.source} ({100 * band.share:.0f} %)")
