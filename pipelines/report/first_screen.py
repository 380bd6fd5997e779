"""The first screen of a report: the verdict, the numbers and two figures it rests on, and the ranking of components."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.border.grid import Grid
from pipelines.report import page
from pipelines.report.first_figures import average_figure, envelope_figure

RANKED_AT_ONCE = 5  # components on the first screen; the others open on a click


@dataclass(frozen=True, eq=False, kw_only=True)
class Average:
    """A time-synchronous average over one turn of a shaft, at rising places.

    `reference` is that of the healthy recordings, None if there are none; `marked` the stretch of places that the
    suspected tooth takes, None without a suspicion, and `marked_name` words for it.
    """

    place: np.ndarray  # (n,), deg or teeth
    value: np.ndarray  # (n,), in `unit`
    reference: np.ndarray | None = None  # (n,), in `unit`
    across: str  # what `place` is, with its unit: "tooth of the stage 1 wheel in mesh"
    unit: str
    marked: tuple[float, float] | None = None
    marked_name: str = ""
    caption: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Envelope:
    """An envelope spectrum; `marked` are lines (place, label) that the verdict reads, `band` the words for its band."""

    line: np.ndarray  # (n,), order or Hz
    amplitude: np.ndarray  # (n,), in `unit`
    reference: np.ndarray | None = None  # (n,), in `unit`
    across: str  # what `line` is, with its unit
    unit: str
    marked: Sequence[tuple[float, str]] = ()
    band: str
    caption: str


@dataclass(frozen=True, kw_only=True)
class Ranked:
    """A component with its evidence in dB and its p-value ("-" where there is none)."""

    component: str
    evidence: float
    p_value: str
    remark: str = ""


@dataclass(frozen=True, eq=False, kw_only=True)
class FirstScreen:
    """What stands before everything else; parts that a run does not have are left out.

    `sentences` are the verdict, the answer first; `found` says whether a fault is seen, None if nothing was looked for;
    `label` says what was compared with, such as "against 8 healthy recordings". `figures` are names with their values:
    f_m, f_r, speed.
    """

    sentences: Sequence[str] = ()
    found: bool | None = None
    label: str = ""
    figures: Sequence[tuple[str, str]] = ()
    average: Average | None = None
    envelope: Envelope | None = None
    ranking: Sequence[Ranked] = ()


def first_screen(content: FirstScreen) -> list[str]:
    """The parts of the page: verdict, numbers, figures, ranking."""
    return [*_verdict(content), *_figures(content), *_evidence(content), *_ranking(content)]


def _verdict(content: FirstScreen) -> list[str]:
    if not content.sentences:
        return []
    style = {True: "fault", False: "none", None: "open"}[content.found]
    parts = [page.paragraph(sentence) for sentence in content.sentences]
    parts += [page.paragraph(content.label, "label")] if content.label else []
    return [f'<div class="verdict {style}" id="verdict">{"".join(parts)}</div>']


def _figures(content: FirstScreen) -> list[str]:
    if not content.figures:
        return []
    pairs = (f"<div><dt>{page.typeset(n)}</dt><dd>{page.typeset(v)}</dd></div>" for n, v in content.figures)
    return [f'<dl id="numbers">{"".join(pairs)}</dl>']


def _evidence(content: FirstScreen) -> list[str]:
    parts = []
    if content.average is not None:
        parts.append(page.picture(average_figure(content.average), content.average.caption))
    if content.envelope is not None:
        parts.append(page.picture(envelope_figure(content.envelope), content.envelope.caption))
    return [f'<div id="evidence">{"".join(parts)}</div>'] if parts else []


def _ranking(content: FirstScreen) -> list[str]:
    if not content.ranking:
        return []
    rows = [(one.component, f"{one.evidence:+.1f}", one.p_value, one.remark) for one in content.ranking]
    headers = ("component", "evidence dB", "p-value", "remark")
    first, others = rows[:RANKED_AT_ONCE], rows[RANKED_AT_ONCE:]
    parts = [page.table(Grid(title="Components, the most suspected first", headers=headers, rows=tuple(first)))]
    if others:
        rest = Grid(title="", headers=headers, rows=tuple(others))
        parts.append(page.folded(f"{len(others)} more components", page.table(rest)))
    return [f'<div id="ranking">{"".join(parts)}</div>']
