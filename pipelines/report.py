"""report.html: the answer first, then what was run and what it rests on, in one file."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipelines import page
from pipelines.callouts import casing_figure, gear_figure
from pipelines.diagnosis import Diagnosis
from pipelines.grid import Grid
from pipelines.lines import LOADS
from pipelines.pictures import LeftOut, Picture
from pipelines.plots import (
    StiffnessPlot,
    Trace,
    bars_figure,
    comparison_figure,
    drive_figure,
    healthy_faulty_figure,
    spectrum_figure,
    stiffness_figure,
    waveform_figure,
)
from pipelines.verdict import case_name, criterion, grade, headline, lines_grid, modulation, sentences, summary_grid

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False, kw_only=True)
class ReportContents:
    """The parts of a report; each may be left out. `reasons` says why, by the title of the section.

    Tables are rows of named cells (dicts with equal keys, the keys are the headers); numbers are set to four digits.
    `runs` maps a name ("missing tooth", "healthy", ...) to a response, the run of the scene first; `diagnoses` the
    comparisons whose lines are shown in full (rope, constant torque), `seeds` those of further deviations, which enter
    the summary; `gear_names` words for the picture's "pinion", "wheel", "gone"; `short` for scenes without fault.
    """

    title: str
    lead: str = ""
    summary: Mapping[str, Any] = field(default_factory=dict)
    diagnoses: Sequence[Diagnosis] = ()
    seeds: Sequence[Diagnosis] = ()
    gears: Sequence[Mapping[str, Any]] = ()
    stiffness: Sequence[StiffnessPlot] = ()
    gear_picture: Picture | LeftOut | None = None
    gear_names: Mapping[str, str] = field(default_factory=dict)
    casing_picture: Picture | LeftOut | None = None
    casing_rows: Sequence[Mapping[str, Any]] = ()
    runs: Mapping[str, xarray.Dataset] = field(default_factory=dict)
    windows: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    sensor: str = "sensor_3"
    axis: str = "z"
    stages: Sequence[Mapping[str, Any]] = ()
    energy: Sequence[Mapping[str, Any]] = ()
    ledger: Mapping[str, Any] = field(default_factory=dict)
    provenance: Mapping[str, Any] = field(default_factory=dict)
    warnings: Sequence[str] = ()
    reasons: Mapping[str, str] = field(default_factory=dict)
    short: bool = False


def write_report(path: Path | str, contents: ReportContents) -> Path:
    """Write the report as one HTML file with all pictures inside; returns the path.

    A section without content is named with its reason; a short report names the absent sections in one sentence.
    """
    sections: list[tuple[str, Callable[[ReportContents], list[str]]]] = [
        ("What was run", _what_was_run),
        ("Gears", _gears),
        ("Stiffness", _stiffness),
        ("Casing", _casing),
        ("Speed and rope", _drive),
        ("Signals", _signals),
        ("Spectra", _spectra),
        ("Healthy and faulty", _healthy_faulty),
        ("Lifting and lowering", _directions),
        ("Rope and constant torque", _loads),
        ("Envelope table", _envelope_table),
        ("Cost", _cost),
        ("Energy books", _energy),
        ("Provenance", _provenance),
    ]
    made = [(title, make(contents)) for title, make in sections]
    shown = [(title, parts) for title, parts in made if parts or not contents.short]
    body = [page.heading(contents.title, 1), page.paragraph(contents.lead, "lead") if contents.lead else ""]
    body += _answer(contents)
    body.append(page.contents([title for title, _ in shown]))
    for title, parts in shown:
        body.append(page.heading(title))
        body += parts or [page.paragraph(contents.reasons.get(title, _REASONS[title]), "missing")]
    absent = [title.lower() for title, parts in made if not parts]
    if contents.short and absent:
        body.append(page.paragraph(f"Not part of this run: {', '.join(absent)}.", "lead"))
    path = Path(path)
    path.write_text(page.document(contents.title, body), encoding="utf-8")
    return path


_NO_CONTROL = "Left out: the scene names no healthy control, so no line can be told from those of a healthy gearbox."
_REASONS = {
    "What was run": "Left out: no description of the scene was given.",
    "Gears": "Left out: no gear table was given.",
    "Stiffness": "Left out: this run derived no stiffness curve.",
    "Casing": "Left out: this casing model has no mesh to show.",
    "Speed and rope": "Left out: the run holds no motor or shaft speeds.",
    "Signals": "Left out: the run holds no casing accelerations.",
    "Spectra": _NO_CONTROL,
    "Healthy and faulty": _NO_CONTROL,
    "Lifting and lowering": "Left out: it takes a diagnosis with two windows.",
    "Rope and constant torque": "Left out: it takes the run with the rope and the run with the constant torque; "
    "only one of them was given.",
    "Envelope table": _NO_CONTROL,
    "Cost": "Left out: no seconds and memory were recorded.",
    "Energy books": "Left out: no energy books were recorded.",
    "Provenance": "Left out: no provenance was recorded.",
}


def _answer(contents: ReportContents) -> list[str]:
    if not contents.diagnoses:
        text = contents.reasons.get("Envelope table", _NO_CONTROL).removeprefix("Left out: ")
        if contents.short:
            return []
        return [page.answer([f"No diagnosis: {text}"], positive=False)]
    every = [*contents.diagnoses, *contents.seeds]
    texts = [headline(every), criterion(every[0]), *(s for d in contents.diagnoses for s in sentences(d))]
    seen = any(grade(d.lines.where(window=w)) == "seen" for d in every for w in d.settings.windows)
    return [page.answer(texts, positive=seen), page.table(summary_grid(every))]


def _what_was_run(contents: ReportContents) -> list[str]:
    parts = [page.paragraph(f"Warning: {text}", "missing") for text in contents.warnings]
    if contents.summary:
        rows = tuple((name, cell(value)) for name, value in contents.summary.items())
        parts.append(page.table(Grid(title="", headers=("", ""), rows=rows)))
    return parts


def _gears(contents: ReportContents) -> list[str]:
    parts = [page.table(grid("", contents.gears))] if contents.gears else []
    if isinstance(contents.gear_picture, LeftOut):
        parts.append(page.paragraph(contents.gear_picture.reason, "missing"))
    elif contents.gear_picture is not None:
        curve = contents.stiffness[0] if contents.stiffness else None
        figure = gear_figure(contents.gear_picture, curve, contents.gear_names)
        caption = "The gear pair in three dimensions" + (" and its stiffness over the mesh cycle." if curve else ".")
        parts.append(page.picture(figure, caption))
    return parts


def _stiffness(contents: ReportContents) -> list[str]:
    if not contents.stiffness:
        return []
    caption = "Mesh stiffness over the mesh cycle; one cycle is the passage of one tooth pair."
    return [page.picture(stiffness_figure(contents.stiffness), caption)]


def _casing(contents: ReportContents) -> list[str]:
    parts = [page.table(grid("", contents.casing_rows))] if contents.casing_rows else []
    if isinstance(contents.casing_picture, LeftOut):
        parts.append(page.paragraph(contents.casing_picture.reason, "missing"))
    elif contents.casing_picture is not None:
        caption = "Key points of the casing: ground (yellow), bearings (red), sensors (green)."
        parts.append(page.picture(casing_figure(contents.casing_picture), caption))
    return parts


def _drive(contents: ReportContents) -> list[str]:
    run = next(iter(contents.runs.values()), None)
    if run is None or not {"motor_speed", "shaft_speed"} & set(run.data_vars):
        return []
    caption = "Speeds of both motors and the input shaft" + (", force in the rope." if "rope_force" in run else ".")
    return [page.picture(drive_figure(run, contents.windows), caption)]


def _signals(contents: ReportContents) -> list[str]:
    runs = {
        name: run
        for name, run in contents.runs.items()
        if "acceleration" in run and contents.sensor in run.sensor.values and contents.axis in run.axis.values
    }
    if not runs:
        return []
    figure = waveform_figure(runs, contents.sensor, contents.axis, contents.windows)
    caption = "Acceleration at the sensor, without sensor noise: the whole run, and a tenth of a second."
    return [page.picture(figure, caption)]


def _spectra(contents: ReportContents) -> list[str]:
    parts = []
    for diagnosis in contents.diagnoses[:1]:
        for window in diagnosis.settings.windows:
            segment = diagnosis.segments[window]
            caption = (
                f"{_named(diagnosis, window)}: one-sided peak amplitudes over {segment.revolutions} revolutions of the "
                f"faulty shaft ({segment.duration:.4g} s), {diagnosis.settings.spectrum_window} window, "
                f"sensor noise {diagnosis.noise:.3g} m/s² rms."
            )
            parts.append(page.picture(spectrum_figure(diagnosis, window), caption))
    return parts


def _healthy_faulty(contents: ReportContents) -> list[str]:
    parts = []
    for diagnosis in contents.diagnoses:
        for window in diagnosis.settings.windows:
            caption = f"{_named(diagnosis, window)}: both runs with the same deviations. Triangles: lines that stand."
            parts.append(page.picture(healthy_faulty_figure(diagnosis, window), caption))
    return parts


def _directions(contents: ReportContents) -> list[str]:
    parts = []
    for diagnosis in contents.diagnoses:
        windows = list(diagnosis.settings.windows)[:2]
        if len(windows) < 2:
            continue
        traces = [_trace(diagnosis, window, window) for window in windows]
        title = f"Faulty run, {' and '.join(windows)}, {LOADS.get(diagnosis.load, diagnosis.load)}"
        parts.append(page.picture(comparison_figure(traces, diagnosis.settings, title), title + "."))
        depths = [modulation(diagnosis.lines.where(window=w), "faulty") for w in windows]
        parts.append(
            page.paragraph(
                f"Root sum square of the sidebands of f_m over f_m, {case_name(diagnosis)}: {depths[0]:.1f} dB in "
                f"{windows[0]}, {depths[1]:.1f} dB in {windows[1]}; the modulation is clearer in "
                f"{windows[0] if depths[0] > depths[1] else windows[1]} by {abs(depths[0] - depths[1]):.1f} dB."
            )
        )
    return parts


def _loads(contents: ReportContents) -> list[str]:
    by_load = {diagnosis.load: diagnosis for diagnosis in contents.diagnoses}
    if not {"rope", "static-torque"} <= set(by_load):
        return []
    rope, torque = by_load["rope"], by_load["static-torque"]
    parts = []
    for window in rope.settings.windows:
        traces = [_trace(rope, window, LOADS["rope"]), _trace(torque, window, LOADS["static-torque"])]
        title = f"Faulty run, rope and constant torque, {window}"
        figure = comparison_figure(traces, rope.settings, title, window=window)
        parts.append(page.picture(figure, title + "."))
    return parts


def _envelope_table(contents: ReportContents) -> list[str]:
    if not contents.diagnoses:
        return []
    settings = contents.diagnoses[0].settings
    parts = [
        page.paragraph(
            f"Harmonics of f_r in the envelope and sidebands n f_m + k f_r in the spectrum at {settings.sensor} "
            f"({settings.axis}); lines that stand are shaded. The floor is the median between the orders, one f_r to "
            "either side. The stated sensor noise is in both runs. The rope mode is printed beside each line."
        )
    ]
    for diagnosis in contents.diagnoses:
        parts += [page.table(lines_grid(diagnosis, window)) for window in diagnosis.settings.windows]
    for diagnosis in contents.seeds:
        inside = "".join(page.table(lines_grid(diagnosis, window)) for window in diagnosis.settings.windows)
        parts.append(page.folded(f"Lines of {case_name(diagnosis)}", inside))
    return parts


def _cost(contents: ReportContents) -> list[str]:
    parts = [page.table(grid("Seconds and memory per stage", contents.stages))] if contents.stages else []
    if contents.ledger:
        rows = tuple((name, cell(value)) for name, value in contents.ledger.items())
        parts.append(page.table(Grid(title="Build ledger", headers=("item", "count"), rows=rows)))
    seconds = {str(row["stage"]): float(row["seconds"]) for row in contents.stages if {"stage", "seconds"} <= set(row)}
    if len(seconds) > 1:
        figure = bars_figure("Seconds per stage", list(seconds), list(seconds.values()), "s")
        parts.append(page.picture(figure, "Where the time went."))
    return parts


def _energy(contents: ReportContents) -> list[str]:
    return [page.table(grid("", contents.energy))] if contents.energy else []


def _provenance(contents: ReportContents) -> list[str]:
    if not contents.provenance:
        return []
    simple = {k: v for k, v in contents.provenance.items() if not isinstance(v, (Mapping, list, tuple))}
    nested = {k: v for k, v in contents.provenance.items() if k not in simple}
    rows = tuple((name, cell(value)) for name, value in simple.items())
    parts = [page.table(Grid(title="", headers=("", ""), rows=rows))] if rows else []
    for name, value in nested.items():
        parts.append(page.folded(name, page.preformatted(json.dumps(value, indent=1, default=str, ensure_ascii=False))))
    return parts


def _trace(diagnosis: Diagnosis, window: str, name: str) -> Trace:
    return Trace(
        name=name, spectrum=diagnosis.spectra["faulty", window], envelope=diagnosis.envelopes["faulty", window]
    )


def _named(diagnosis: Diagnosis, window: str) -> str:
    return f"{window.capitalize()}, {case_name(diagnosis)}"


def grid(title: str, rows: Sequence[Mapping[str, Any]]) -> Grid:
    """A table from rows of named cells; a cell that a row lacks stays empty."""
    headers = tuple(dict.fromkeys(name for row in rows for name in row))
    return Grid(title=title, headers=headers, rows=tuple(tuple(cell(row.get(h, "")) for h in headers) for row in rows))


def cell(value: Any) -> str:
    """A value as it is shown: floats with four significant digits, lists joined, nothing for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, (list, tuple)):
        return ", ".join(cell(v) for v in value)
    return str(value)
