"""Error bars in words: a table for each window, and the sentences on what they hold."""

from __future__ import annotations

from collections.abc import Sequence

from pipelines.bars.line_bars import Band, LineBar, LineBars
from pipelines.border.grid import Grid

HEADERS = ("line", "Hz", "m/s²", "numerical dB", "mostly by", "inputs dB")


def bars_grid(bars: Sequence[LineBar], window: str) -> Grid:
    """The bars of the lines of a window."""
    rows = tuple(
        (
            f"envelope {bar.label}" if bar.kind == "envelope" else bar.label,
            f"{bar.frequency:.3f}",
            f"{bar.level:.3g}",
            "" if bar.numerical is None else _ends(bar.numerical),
            "" if bar.numerical is None else f"{bar.numerical.source} ({100 * bar.numerical.share:.0f} %)",
            _ends(bar.inputs),
        )
        for bar in bars
    )
    title = f"Error bars, {window}: 5 to 95 %, over the level of the faulty run"
    return Grid(
        title=title,
        headers=HEADERS,
        rows=rows,
        marked=frozenset(i for i, bar in enumerate(bars) if bar.detected),
    )


def bars_words(found: LineBars | str) -> str:
    """Tables and sentences for the terminal, or why there are none."""
    if isinstance(found, str):
        return found + "\n"
    windows = dict.fromkeys(bar.window for bar in found.bars)
    parts = [bars_grid(found.of(window), window).to_text() for window in windows]
    return "\n\n".join([*parts, "\n".join(found.notes)]) + "\n"


def _ends(band: Band) -> str:
    return f"{band.low:+.2f} to {band.high:+.2f}"
