"""report.html: one file with the answer on the first screen, then signals and spectra, then all inputs and results."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray

from pipelines.diagnosis.control_diagnosis import Diagnosis
from pipelines.diagnosis.known_damage import Case, Damage, cases_grid
from pipelines.diagnosis.line_words import criterion, directions
from pipelines.diagnosis.uncertainty.bar_records import LineBars
from pipelines.diagnosis.verdict_words import note
from pipelines.engine.progress import step_words
from pipelines.io.text_table import Grid, cell, grid, turned
from pipelines.report import page, signal_sections
from pipelines.report.figures.plots import drive_figure
from pipelines.report.figures.views import LeftOut
from pipelines.signals.analysis import DiagnosisSettings

Rows = Sequence[Mapping[str, Any]]
GEARS = (
    "Symbols of ISO 21771-1 and ISO 6336-1. Frequencies at the highest speed, forces at the load of the scene. The "
    "line load is the tangential force per face width."
)
ROLLING = (
    "Pass frequencies at the highest speed, without slip. A spall on a rolling element meets both rings in each "
    "turn of the element, so its frequency is 2 BSF."
)
SHAFTS = "Orders 1x and 2x of the shaft at the highest speed. The diagnosis evaluates these two lines."
CASING = (
    "Coordinates: degrees of freedom of the reduced model. Checks, if listed, compare it with the finite-element "
    "model: symmetry, rigid-body motions, mass, inertia and reactions. gearcase casing SCENE prints each of them."
)
ENERGY = (
    "Energies over the whole simulation, in joule. Stored: change of the stored energy. Parametric: work of "
    "springs whose stiffness changes in time. Residual: received plus parametric minus dissipated minus stored; 0 "
    "except for numerical errors. The residuals of shafts and casing also contain work that they exchange, because "
    "modes of the machine above simulation.band_Hz are assumed to follow statically; these parts add up to 0, and a "
    "larger band_Hz reduces them. Scale: energy with which the residual is compared. For a part this is the dissipated "
    "energy, or the largest stored energy if the part has almost no damping; for the total, the work of all sources, "
    'each counted as positive. The row "drive" is the motor couplings; the work of the motors and the rotation of the '
    "shafts are in the total only."
)


def write_report(path: Path | str, title: str, body: str, facts: Mapping[str, Any]) -> Path:
    """Write the report as one HTML file with all pictures inside; returns the path.

    Parameters
    ----------
    path, title : of the file
    body : by `report_body`
    facts : content of run.json: rows of its steps, a summary of what was computed (ledger), versions and keys
    """
    last = [("Cost", _cost(facts)), ("Provenance", _provenance(facts))]
    parts = [body, *(page.section(heading, found) for heading, found in last if found)]
    path = Path(path)
    path.write_text(page.document(title, parts), encoding="utf-8")
    return path


def report_body(
    title: str,
    sections: Sequence[str],
    *,
    first: Sequence[str] = (),
    cases: Sequence[Case] = (),
    damages: Sequence[Damage] = (),
    diagnoses: Sequence[Diagnosis] = (),
    cautions: Sequence[str] = (),
) -> str:
    """The page without its cost: the answer on the first screen, the signals, then all other sections, folded.

    Parameters
    ----------
    title, first : heading, and parts of the first screen
    sections : by `report_sections`
    cases, damages : verdicts, and known damage
    diagnoses : comparisons that are shown in full
    cautions : warnings of the motions
    """
    signals, *others = sections
    decided = _decided(cases, damages, diagnoses)
    warned = [page.paragraph(f"Warning: {text}", "caution") for text in cautions]
    before = [page.section("How it was decided", decided, opened=False)] if decided else []
    return "\n".join(filter(None, [page.heading(title, 1), *warned, *first, signals, *before, *others]))


def report_sections(
    *,
    summary: Mapping[str, Any] | None = None,
    diagnoses: Sequence[Diagnosis] = (),
    seeds: Sequence[Diagnosis] = (),
    error: LineBars | str = "",
    gears: Rows = (),
    rolling: Rows = (),
    shafts: Rows = (),
    gear_picture: str | LeftOut | None = None,
    stiffness: str = "",
    casing_picture: str | LeftOut | None = None,
    casing_rows: Rows = (),
    runs: Mapping[str, xarray.Dataset] | None = None,
    windows: Mapping[str, tuple[float, float]] | None = None,
    sensor: str = "",
    axis: str = "z",
    settings: DiagnosisSettings | None = None,
    energy: Rows = (),
    warnings: Sequence[str] = (),
) -> list[str]:
    """The sections that do not depend on the verdict, the signals first, "" for one that does not apply to the run.

    Tables are rows of named cells (the keys are the headers);
    numbers have four digits. Pictures and stiffness are elements of the page, see `pipelines.steps.pictures`.

    Parameters
    ----------
    summary : properties of the run by name
    diagnoses, seeds : comparisons that are shown in full, and those of further deviations, for the summary
    error : uncertainty of the lines of the first diagnosis, or the reason why there is none
    gears, rolling, shafts : gears, bearings with their pass frequencies, faults of shafts with their orders
    gear_picture, stiffness, casing_picture, casing_rows : of gears and casing
    runs, windows : responses by name, that of the scene first; the windows of the diagnosis
    sensor, axis : channel that is shown
    settings : of the diagnosis, for a run without control
    energy, warnings : energy balance, and warnings of the scene
    """
    runs, windows = runs or {}, windows or {}
    sections = [
        ("Signals and spectra", signal_sections.signals(runs, windows, (sensor, axis), diagnoses, settings)),
        ("Levels", signal_sections.levels(runs, windows)),
        ("Healthy and faulty", signal_sections.healthy_faulty(diagnoses, error)),
        ("Error bars", signal_sections.error_bars(error)),
        ("Windows side by side", signal_sections.two_windows(diagnoses)),
        ("Two loads", signal_sections.two_loads(diagnoses)),
        ("All lines", signal_sections.all_lines(diagnoses, seeds)),
        ("What was run", _what_was_run(summary or {}, warnings)),
        ("Gears", _noted(gears, GEARS, ("stage", "gear")) + _picture(gear_picture)),
        ("Rolling bearings", _noted(rolling, ROLLING)),
        ("Faults of shafts", _noted(shafts, SHAFTS)),
        ("Stiffness", [stiffness] if stiffness else []),
        ("Casing", _noted(casing_rows, CASING) + _picture(casing_picture)),
        ("Speed", _drive(runs, windows)),
        ("Energy balance", _noted(energy, ENERGY)),
    ]
    return [page.section(name, parts, opened=name == sections[0][0]) if parts else "" for name, parts in sections]


def _decided(cases: Sequence[Case], damages: Sequence[Damage], diagnoses: Sequence[Diagnosis]) -> list[str]:
    parts = [page.table(cases_grid(cases, damages))] if cases and damages else []
    texts = [note(cases[0].verdict)] if cases else []
    texts += [criterion(diagnoses[0])] if diagnoses else []
    return [*parts, *map(page.paragraph, texts + [text for one in diagnoses if (text := directions(one))])]


def _what_was_run(summary: Mapping[str, Any], warnings: Sequence[str]) -> list[str]:
    parts = [page.paragraph(f"Warning: {text}", "missing") for text in warnings]
    if summary:
        rows = tuple((name, cell(value)) for name, value in summary.items())
        parts.append(page.table(Grid(title="", headers=("", ""), rows=rows)))
        parts.append(page.note("Models have the names that the scene uses."))
    return parts


def _noted(rows: Rows, note: str, heads: Sequence[str] = ()) -> list[str]:
    """A table with what explains it, where there are rows; with `heads` a column for each row, headed by these."""
    if not rows:
        return []
    table = grid("", rows)
    return [page.table(turned(table, heads) if heads else table), page.note(note)]


def _picture(found: str | LeftOut | None) -> list[str]:
    """A picture, or why it is left out."""
    if found is None:
        return []
    return [page.paragraph(found.reason, "missing") if isinstance(found, LeftOut) else found]


def _drive(runs: Mapping[str, xarray.Dataset], windows: Mapping[str, tuple[float, float]]) -> list[str]:
    run = next(iter(runs.values()), None)
    if run is None or not {"motor_speed", "shaft_speed"} & set(run.data_vars):
        return []
    caption = "Speeds of the motors and the first shaft" + (", and force in the rope." if "rope_force" in run else ".")
    caption += " Shaded: the windows of the diagnosis." if windows else ""
    return [page.picture(drive_figure(run, windows), caption)]


def _cost(facts: Mapping[str, Any]) -> list[str]:
    parts = []
    if rows := facts.get("steps"):
        longest = max(row["seconds"] for row in rows) or 1.0
        steps = [
            {name: value for name, value in row.items() if name not in ("reused", "ledger")}
            | {"": "█" * round(30 * row["seconds"] / longest), "result": _step_words(str(row.get("step", "")))}
            for row in rows
        ]
        note = (
            "A step is stored in the cache. Time and memory of a reused step are those of its first computation. "
            "Steps may run at the same time."
        )
        parts = [page.table(grid("Computing time and memory of each step", steps)), page.note(note)]
    if ledger := facts.get("ledger"):
        counts = [
            {"quantity": _COUNTS.get(name, name.replace("_", " ")), "count": value}
            for name, value in ledger.items()
            if value
        ]
        parts.append(page.table(grid("Size of the computation", counts)))
    return parts


def _provenance(facts: Mapping[str, Any]) -> list[str]:
    simple = {k: v for k, v in facts.items() if not isinstance(v, (Mapping, list, tuple))}
    nested = {k: v for k, v in facts.items() if k not in (*simple, "steps", "ledger")}
    rows = tuple((name, cell(value)) for name, value in simple.items())
    parts = [page.table(Grid(title="", headers=("", ""), rows=rows))] if rows else []
    for name, value in nested.items():
        title = "keys of the results in the cache" if name == "keys" else name
        parts.append(
            page.folded(
                title, f"<pre>{html.escape(json.dumps(value, indent=1, default=str, ensure_ascii=False))}</pre>"
            )
        )
    return parts


_STARTS = {  # start of the name of a step -> what it computes; the rest of the name follows
    "unmodified_law_": "mesh law without faults and modifications, stage ",
    "law_": "mesh law, stage ",
    "crack surface of ": "flexibility of a cracked tooth, ",
    "trial casing": "coarse casing, from which the element size follows",
    "coarse": "casing with larger elements, for the discretisation error: coarse",
    "quadratic casing": "casing with quadratic elements, for the discretisation error",
}
_STEPS = {
    "casing mesh": "finite-element mesh of the casing",
    "casing modes": "natural modes and static shapes of the casing",
    "casing error": "error of the reduced casing against the finite-element model",
    "casing picture": "picture of the casing",
    "casing": "reduced casing with damping and sensors",
    "gear picture": "picture of the gear pair",
    "stiffness curves": "figures of the mesh stiffness",
    "diagnose": "lines of the faulty run compared with those of its control",
    "error bars": "error bars of the lines",
    "verdict": "ranking of the components",
    "report": "text and figures of this report",
}
_COUNTS = {
    "gear_meshes": "finite-element meshes of gears",
    "factorisations": "matrix factorisations, in total",
    "gear_factorisations": "matrix factorisations, of these for gears",
    "casing_meshes": "finite-element meshes of the casing",
    "casing_coordinates": "coordinates of the reduced casing",
    "recovery_rows": "displacements recovered at sensors",
    "simulations": "simulated motions",
    "coordinates": "coordinates of the machine, sum over all motions",
    "rope_coordinates": "coordinates of ropes, sum over all motions",
    "time_steps": "time steps, sum over all motions",
    "channels": "recorded signals, sum over all motions",
}


def _step_words(name: str) -> str:
    """What a step computes."""
    found = [text + name[len(start) :] for start, text in _STARTS.items() if name.startswith(start)]
    return found[0] if found else _STEPS.get(name) or step_words(name)
