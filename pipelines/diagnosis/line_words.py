"""The lines of a run and its control as sentences and tables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.diagnosis.control_diagnosis import Diagnosis
from pipelines.diagnosis.known_damage import deviation_words
from pipelines.io.text_table import Grid, grid
from pipelines.signals.line_table import IN_ENVELOPE, LOADS, LineTable

EQUAL = 1.0  # dB; modulations this close are called equal


def criterion(diagnosis: Diagnosis) -> str:
    """Sentences on the criterion for a detected line, or on why no line is detected."""
    settings = diagnosis.settings
    if diagnosis.chance:
        return (
            f"No line is marked as detected: {diagnosis.chance}, so that differences from the healthy control need not "
            "be effects of the fault."
        )
    return (
        f"A line is marked as detected if it is at least {settings.difference_limit:g} dB over the same line of the "
        f"healthy control and at least {settings.floor_limit:g} dB over its floor, the median of the bins between the "
        "orders. Marks show where a fault is visible; the verdict does not depend on them."
    )


def case_name(diagnosis: Diagnosis) -> str:
    """Load and deviations as text."""
    return f"{LOADS.get(diagnosis.load, diagnosis.load)}, {deviation_words(diagnosis.deviations)}"


def modulation(lines: LineTable, state: str, mesh_harmonic: int = 1) -> float:
    """Root sum square of the sidebands around a mesh order, relative to the line at the mesh order, dB."""
    sidebands = getattr(lines.where(kind="sideband", mesh_harmonic=mesh_harmonic), state)
    carrier = getattr(lines.where(kind="mesh", mesh_harmonic=mesh_harmonic), state)
    tiny = np.finfo(float).tiny
    return float(20 * np.log10(max(np.linalg.norm(sidebands), tiny) / max(carrier[0], tiny)))


def directions(diagnosis: Diagnosis) -> str:
    """Sentences on the modulation of the faulty run in the first two windows; "" with one window."""
    windows = list(diagnosis.settings.windows)[:2]
    if len(windows) < 2:
        return ""
    first, second = (modulation(diagnosis.lines.where(window=window), "faulty") for window in windows)
    if abs(first - second) < EQUAL:
        end = f"equal within {EQUAL:g} dB"
    else:
        end = f"{abs(first - second):.1f} dB higher in {windows[0] if first > second else windows[1]}"
    return (
        f"Modulation of the faulty run with {case_name(diagnosis)}: {first:.1f} dB in {windows[0]} and {second:.1f} dB "
        f"in {windows[1]}, {end}. Modulation: the root sum square of the sidebands around f_m over the line at f_m."
    )


def lines_grid(diagnosis: Diagnosis, window: str) -> Grid:
    """Table of the lines of one case and window."""
    lines = diagnosis.lines.where(window=window)
    rope = diagnosis.settings.rope_mode.get(window, 0.0)
    low, high = diagnosis.band
    marks = [
        f"{kind} line" if kind in ("mesh", "bearing") else "detected" if detected else "-"
        for kind, detected in zip(lines.kind, lines.detected, strict=True)
    ]
    rows = [
        {
            "line": _named(lines, i),
            "Hz": f"{lines.frequency[i]:.3f}",
            "faulty m/s²": f"{lines.faulty[i]:.3g}",
            "healthy m/s²": f"{lines.healthy[i]:.3g}",
            "difference dB": f"{lines.difference[i]:+.1f}",
            "over floor dB": f"{lines.over_floor[i]:+.1f}",
            "healthy over floor dB": f"{lines.healthy_over_floor[i]:+.1f}",
            "mark": mark,
            **({"rope mode Hz": "on this line" if lines.near_rope[i] else f"{rope:.2f}"} if rope else {}),
        }
        for i, mark in enumerate(marks)
    ]
    place = f"{diagnosis.settings.sensor} {diagnosis.settings.axis}"
    title = f"{_capital(window)}, {case_name(diagnosis)}, {place}; envelope of {low:.4g} to {high:.4g} Hz"
    return grid(title, rows, frozenset(i for i, mark in enumerate(marks) if mark == "detected"))


def seeds_grid(diagnoses: Sequence[Diagnosis], load: str, window: str) -> Grid:
    """Table of the difference of every line, faulty over healthy, with one column for each set of deviations."""
    chosen = sorted((d for d in diagnoses if d.load == load), key=lambda d: _seed_order(d.deviations))
    names = ["error-free" if d.deviations == "off" else d.deviations for d in chosen]
    tables = [d.lines.where(window=window).of("envelope", "sideband", "pass", "shaft") for d in chosen]
    rows = [
        {
            "line": _named(tables[0], i),
            "Hz": f"{frequency:.3f}",
            **{name: f"{t.difference[i]:+.1f}{' ●' * t.detected[i]}" for name, t in zip(names, tables, strict=True)},
            "detected in": str(sum(t.detected[i] for t in tables)),
        }
        for i, frequency in enumerate(tables[0].frequency)
    ]
    return grid(f"{_capital(window)}, {LOADS.get(load, load)}: faulty over healthy in dB (● detected)", rows)


def markdown(diagnoses: Sequence[Diagnosis]) -> str:
    """Markdown tables of all lines by load and window, with one column for each set of deviations."""
    parts = [criterion(diagnoses[0]), directions(diagnoses[0])]
    for load in dict.fromkeys(d.load for d in diagnoses):
        for window in dict.fromkeys(w for d in diagnoses if d.load == load for w in d.settings.windows):
            table = seeds_grid(diagnoses, load, window)
            parts.append(f"**{table.title}**\n\n{table.to_markdown()}")
    return "\n\n".join(filter(None, parts)) + "\n"


def _named(lines: LineTable, row: int) -> str:
    return ("envelope " if lines.kind[row] in IN_ENVELOPE else "") + lines.label[row]


def _seed_order(deviations: str) -> tuple[int, int]:
    """Error-free gears first, then the seeds in their order."""
    return (0, 0) if deviations == "off" else (1, int(deviations.split()[-1]))


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]
