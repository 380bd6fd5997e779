"""The lines of a run and its control as sentences and tables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.diagnosis.control_diagnosis import Diagnosis
from pipelines.diagnosis.known_damage import deviation_words
from pipelines.io.text_table import Grid
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
    headers = ("line", "Hz", "faulty m/s²", "healthy m/s²", "difference dB", "over floor dB", "healthy over floor dB")
    rows, marked = [], set()
    for i in range(len(lines)):
        where = "envelope " if lines.kind[i] in IN_ENVELOPE else ""
        found = "detected" if lines.detected[i] else "-"
        if lines.kind[i] in ("mesh", "bearing"):
            found = f"{lines.kind[i]} line"
        elif lines.detected[i]:
            marked.add(i)
        near = ("on this line" if lines.near_rope[i] else f"{rope:.2f}",) if rope else ()
        rows.append(
            (
                where + lines.label[i],
                f"{lines.frequency[i]:.3f}",
                f"{lines.faulty[i]:.3g}",
                f"{lines.healthy[i]:.3g}",
                f"{lines.difference[i]:+.1f}",
                f"{lines.over_floor[i]:+.1f}",
                f"{lines.healthy_over_floor[i]:+.1f}",
                found,
                *near,
            )
        )
    place = f"{diagnosis.settings.sensor} {diagnosis.settings.axis}"
    title = f"{_capital(window)}, {case_name(diagnosis)}, {place}; envelope of {low:.4g} to {high:.4g} Hz"
    last = ("mark", "rope mode Hz") if rope else ("mark",)
    return Grid(title=title, headers=(*headers, *last), rows=tuple(rows), marked=frozenset(marked))


def seeds_grid(diagnoses: Sequence[Diagnosis], load: str, window: str) -> Grid:
    """Table of the difference of every line, faulty over healthy, with one column for each set of deviations."""
    chosen = sorted((d for d in diagnoses if d.load == load), key=lambda d: _seed_order(d.deviations))
    tables = [d.lines.where(window=window).of("envelope", "sideband", "pass", "shaft") for d in chosen]
    rows = []
    for i, label in enumerate(tables[0].label):
        where = "envelope " if tables[0].kind[i] in IN_ENVELOPE else ""
        cells = [f"{t.difference[i]:+.1f}" + (" ●" if t.detected[i] else "") for t in tables]
        rows.append(
            (where + label, f"{tables[0].frequency[i]:.3f}", *cells, str(sum(int(t.detected[i]) for t in tables)))
        )
    names = ["error-free" if d.deviations == "off" else d.deviations for d in chosen]
    title = f"{_capital(window)}, {LOADS.get(load, load)}: faulty over healthy in dB (● detected)"
    return Grid(title=title, headers=("line", "Hz", *names, "detected in"), rows=tuple(rows))


def markdown(diagnoses: Sequence[Diagnosis]) -> str:
    """Markdown tables of all lines by load and window, with one column for each set of deviations."""
    parts = [criterion(diagnoses[0]), directions(diagnoses[0])]
    for load in dict.fromkeys(d.load for d in diagnoses):
        for window in dict.fromkeys(w for d in diagnoses if d.load == load for w in d.settings.windows):
            parts.append(_titled(seeds_grid(diagnoses, load, window)))
    return "\n\n".join(filter(None, parts)) + "\n"


def _titled(grid: Grid) -> str:
    return f"**{grid.title}**\n\n{grid.to_markdown()}"


def _seed_order(deviations: str) -> tuple[int, int]:
    """Error-free gears first, then the seeds in their order."""
    return (0, 0) if deviations == "off" else (1, int(deviations.split()[-1]))


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]
