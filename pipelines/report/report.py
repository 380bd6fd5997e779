"""report.html: the answer first, then what was run and what it rests on, in one file."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path

from pipelines.border.grid import Grid
from pipelines.figures.callouts import casing_figure, gear_figure
from pipelines.figures.plots import bars_figure, drive_figure, stiffness_figure, waveform_figure
from pipelines.figures.views import LeftOut
from pipelines.report import page, spectra
from pipelines.report.contents import ReportContents, cell, grid
from pipelines.signals.analysis import channel_names
from pipelines.signals.levels import contact_sentence, level_grid
from pipelines.signals.verdict import all_seen, criterion, directions, headline, sentences, summary_grid

__all__ = ["ReportContents", "write_report"]


def write_report(path: Path | str, contents: ReportContents) -> Path:
    """Write the report as one HTML file with all pictures inside; returns the path.

    A section without content is named with its reason; a short report names the absent sections in one sentence.
    """
    sections: list[tuple[str, Callable[[ReportContents], list[str]]]] = [
        ("What was run", _what_was_run),
        ("Gears", _gears),
        *([("Rolling bearings", _rolling)] if contents.rolling else []),
        *([("Faults of shafts", _shafts)] if contents.shafts else []),
        ("Stiffness", _stiffness),
        ("Casing", _casing),
        ("Speed", _drive),
        ("Signals", _signals),
        ("Spectra", spectra.spectra),
        ("Healthy and faulty", spectra.healthy_faulty),
        ("Windows side by side", spectra.two_windows),
        ("Two loads", spectra.two_loads),
        ("Envelope table", spectra.envelope_table),
        ("Cost", _cost),
        ("Energy balance", _energy),
        ("Provenance", _provenance),
    ]
    made = [(title, make(contents)) for title, make in sections]
    shown = [(title, parts) for title, parts in made if parts or not contents.short]
    body = [page.heading(contents.title, 1), page.paragraph(contents.lead, "lead") if contents.lead else ""]
    body += [page.paragraph(f"Warning: {text}", "missing") for text in contents.cautions]
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
    "Speed": "Left out: the run holds no motor or shaft speeds.",
    "Signals": "Left out: the run holds no acceleration of this sensor.",
    "Spectra": _NO_CONTROL,
    "Healthy and faulty": _NO_CONTROL,
    "Windows side by side": "Left out: it takes a diagnosis with two windows.",
    "Two loads": "Left out: it takes runs with two models of the load; only one of them was given.",
    "Envelope table": _NO_CONTROL,
    "Cost": "Left out: no seconds and memory were recorded.",
    "Energy balance": "Left out: no energy balance was recorded.",
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
    texts += [text for d in contents.diagnoses if (text := directions(d))]
    seen = any(all_seen(d, window) for d in every for window in d.settings.windows)
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


def _rolling(contents: ReportContents) -> list[str]:
    note = "Pass frequencies at the highest speed without slip; a spall of a rolling element passes twice per BSF."
    return [page.table(grid("", contents.rolling)), page.paragraph(note)]


def _shafts(contents: ReportContents) -> list[str]:
    note = "Orders 1x and 2x at the highest speed; the spectrum is searched for them."
    return [page.table(grid("", contents.shafts)), page.paragraph(note)]


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
    caption = "Speeds of the motors and the first shaft" + (", force in the rope." if "rope_force" in run else ".")
    return [page.picture(drive_figure(run, contents.windows), caption)]


def _signals(contents: ReportContents) -> list[str]:
    runs = {
        name: run
        for name, run in contents.runs.items()
        if contents.sensor in channel_names(run) and contents.axis in run.axis.values
    }
    if not runs:
        return []
    figure = waveform_figure(runs, contents.sensor, contents.axis, contents.windows)
    first = next(iter(contents.runs.values()))
    levels, contact = level_grid(first, contents.windows), contact_sentence(first)
    caption = "Acceleration at the sensor, without sensor noise: the whole run, and a tenth of a second."
    parts = [page.picture(figure, caption)]
    parts += [] if levels is None else [page.table(levels)]
    return parts + ([page.paragraph(contact)] if contact else [])


def _cost(contents: ReportContents) -> list[str]:
    parts = [page.table(grid("Seconds and memory per step", contents.steps))] if contents.steps else []
    if contents.ledger:
        rows = tuple((name, cell(value)) for name, value in contents.ledger.items())
        parts.append(page.table(Grid(title="Build ledger", headers=("item", "count"), rows=rows)))
    seconds = {str(row["step"]): float(row["seconds"]) for row in contents.steps if {"step", "seconds"} <= set(row)}
    if len(seconds) > 1:
        figure = bars_figure("Seconds per step", list(seconds), list(seconds.values()), "s")
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
