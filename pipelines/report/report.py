"""report.html: the answer on the first screen, then signals and spectra, then what it rests on, in one file."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pipelines.diagnosis.control_verdict import criterion, directions, sentences, summary_grid
from pipelines.io.grid import Grid
from pipelines.report import page, spectra
from pipelines.report.contents import ReportContents, RunCost, cell, grid, turned
from pipelines.report.cost_words import count_words, step_words
from pipelines.report.figures.plots import drive_figure
from pipelines.report.figures.views import LeftOut
from pipelines.report.first_page import first_screen


def write_report(path: Path | str, title: str, body: str, cost: RunCost) -> Path:
    """Write the report as one HTML file with all pictures inside; returns the path.

    Parameters
    ----------
    path, title : of the file
    body : by `report_body`
    cost : of the run
    """
    last = [("Cost", _cost(cost)), ("Provenance", _provenance(cost))]
    parts = [body, *(page.section(heading, found) for heading, found in last if found)]
    path = Path(path)
    path.write_text(page.document(title, parts), encoding="utf-8")
    return path


def report_body(contents: ReportContents) -> str:
    """The page but for its cost: the answer on the first screen, then the signals, then everything else, folded.

    A section that does not apply to the run is not there.
    """
    sections: list[tuple[str, Callable[[ReportContents], list[str]]]] = [
        ("Signals and spectra", spectra.signals),
        ("How it was decided", _decided),
        ("Levels", spectra.levels),
        ("Healthy and faulty", spectra.healthy_faulty),
        ("Error bars", spectra.error_bars),
        ("Windows side by side", spectra.two_windows),
        ("Two loads", spectra.two_loads),
        ("All lines", spectra.all_lines),
        ("What was run", _what_was_run),
        ("Gears", _gears),
        ("Rolling bearings", _rolling),
        ("Faults of shafts", _shafts),
        ("Stiffness", _stiffness),
        ("Casing", _casing),
        ("Speed", _drive),
        ("Energy balance", _energy),
    ]
    body = [page.heading(contents.title, 1)]
    body += [page.paragraph(f"Warning: {text}", "caution") for text in contents.cautions]
    body += first_screen(contents.first)
    for number, (title, make) in enumerate(sections):
        if parts := make(contents):
            body.append(page.section(title, parts, opened=number == 0))
    return "\n".join(body)


def _decided(contents: ReportContents) -> list[str]:
    if not contents.diagnoses:
        return []
    every = [*contents.diagnoses, *contents.seeds]
    texts = [criterion(every[0]), *(s for d in contents.diagnoses for s in sentences(d))]
    texts += [text for d in contents.diagnoses if (text := directions(d))]
    note = (
        "In each cell: detected lines of all lines of this kind. Envelope harmonics: k f_r in the envelope spectrum. "
        "Sidebands of n f_m: n f_m + k f_r in the spectrum."
    )
    return [*map(page.paragraph, texts), page.table(summary_grid(every)), page.note(note)]


def _what_was_run(contents: ReportContents) -> list[str]:
    parts = [page.paragraph(f"Warning: {text}", "missing") for text in contents.warnings]
    if contents.summary:
        rows = tuple((name, cell(value)) for name, value in contents.summary.items())
        parts.append(page.table(Grid(title="", headers=("", ""), rows=rows)))
        parts.append(page.note("Models have the names that the scene uses."))
    return parts


def _gears(contents: ReportContents) -> list[str]:
    note = (
        "Symbols of ISO 21771-1 and ISO 6336-1. Frequencies at the highest speed, forces at the load of the scene. The "
        "line load is the tangential force per face width."
    )
    parts = []
    if contents.gears:
        parts = [page.table(turned(grid("", contents.gears), ("stage", "gear"))), page.note(note)]
    return parts + _picture(contents.gear_picture)


def _rolling(contents: ReportContents) -> list[str]:
    return _noted(
        contents.rolling,
        "Pass frequencies at the highest speed, without slip. A spall on a rolling element meets both rings in each "
        "turn of the element, so its frequency is 2 BSF.",
    )


def _shafts(contents: ReportContents) -> list[str]:
    return _noted(
        contents.shafts, "Orders 1x and 2x of the shaft at the highest speed. The diagnosis evaluates these two lines."
    )


def _stiffness(contents: ReportContents) -> list[str]:
    return [contents.stiffness] if contents.stiffness else []


def _casing(contents: ReportContents) -> list[str]:
    return _noted(
        contents.casing_rows,
        "Coordinates: degrees of freedom of the reduced model. The checks compare it with the finite-element model: "
        "symmetry, rigid-body motions, mass, inertia and reactions. gearcase casing SCENE prints each of them.",
    ) + _picture(contents.casing_picture)


def _noted(rows: Sequence[Mapping[str, Any]], note: str) -> list[str]:
    """A table with what explains it, where there are rows."""
    return [page.table(grid("", rows)), page.note(note)] if rows else []


def _picture(found: str | LeftOut | None) -> list[str]:
    """A picture, or why it is left out."""
    if found is None:
        return []
    return [page.paragraph(found.reason, "missing") if isinstance(found, LeftOut) else found]


def _drive(contents: ReportContents) -> list[str]:
    run = next(iter(contents.runs.values()), None)
    if run is None or not {"motor_speed", "shaft_speed"} & set(run.data_vars):
        return []
    caption = "Speeds of the motors and the first shaft" + (", and force in the rope." if "rope_force" in run else ".")
    caption += " Shaded: the windows of the diagnosis." if contents.windows else ""
    return [page.picture(drive_figure(run, contents.windows), caption)]


def _cost(cost: RunCost) -> list[str]:
    parts = []
    if cost.steps:
        longest = max(row["seconds"] for row in cost.steps) or 1.0
        steps = [
            {**row, "": "█" * round(30 * row["seconds"] / longest), "result": step_words(str(row.get("step", "")))}
            for row in cost.steps
        ]
        note = (
            "A step is stored in the cache. Of a reused step, time and memory are those of its first computation. "
            "Steps may run at the same time."
        )
        parts = [page.table(grid("Computing time and memory of each step", steps)), page.note(note)]
    if cost.ledger:
        rows = tuple((count_words(name), cell(value)) for name, value in cost.ledger.items() if value)
        parts.append(page.table(Grid(title="Size of the computation", headers=("quantity", "count"), rows=rows)))
    return parts


def _energy(contents: ReportContents) -> list[str]:
    return _noted(
        contents.energy,
        "Energies over the whole simulation, in joule. Stored: change of the stored energy. Parametric: work of "
        "springs whose stiffness changes in time. Residual: received plus parametric minus dissipated minus stored; 0 "
        "except for numerical errors. Scale: the energy with which the residual is compared. The total includes the "
        "rotation of the shafts.",
    )


def _provenance(cost: RunCost) -> list[str]:
    if not cost.provenance:
        return []
    simple = {k: v for k, v in cost.provenance.items() if not isinstance(v, (Mapping, list, tuple))}
    nested = {k: v for k, v in cost.provenance.items() if k not in simple}
    rows = tuple((name, cell(value)) for name, value in simple.items())
    parts = [page.table(Grid(title="", headers=("", ""), rows=rows))] if rows else []
    for name, value in nested.items():
        title = "keys of the results in the cache" if name == "keys" else name
        parts.append(
            page.folded(title, page.preformatted(json.dumps(value, indent=1, default=str, ensure_ascii=False)))
        )
    return parts
