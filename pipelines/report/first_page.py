"""The first screen as parts of the page: verdict, numbers, figures, ranking of components."""

from __future__ import annotations

from collections.abc import Sequence

from pipelines.diagnosis.verdict import decibels
from pipelines.diagnosis.words import STRENGTH
from pipelines.io.grid import Grid
from pipelines.report import page
from pipelines.report.first_figures import Average, Envelope, average_figure, envelope_figure

RANKED_AT_ONCE = 5  # components on the first screen; the others open on a click


def first_screen(
    *,
    sentences: Sequence[str] = (),
    found: bool | None = None,
    figures: Sequence[tuple[str, str]] = (),
    average: Average | None = None,
    envelope: Envelope | None = None,
    ranking: Sequence[tuple[str, float, str, str]] = (),
    ranking_note: str = "",
) -> list[str]:
    """The parts of the page: verdict, numbers, figures, ranking; parts that a run does not have are omitted.

    Parameters
    ----------
    sentences, found : the verdict, the answer first; whether damage is found, None without a diagnosis
    figures : names with their values: f_m, f_r, speed
    average, envelope : the two figures that support the verdict
    ranking : components with their increase in dB, their evidence ("-" where it has no limit), and a remark
    ranking_note : explains the columns of the ranking
    """
    return [
        *_verdict(sentences, found),
        *_figures(figures),
        *_evidence(average, envelope),
        *_ranking(ranking, ranking_note),
    ]


def _verdict(sentences: Sequence[str], found: bool | None) -> list[str]:
    if not sentences:
        return []
    style = {True: "fault", False: "none", None: "open"}[found]
    parts = [page.paragraph(sentence) for sentence in sentences]
    return [f'<div class="verdict {style}" id="verdict">{"".join(parts)}</div>']


def _figures(figures: Sequence[tuple[str, str]]) -> list[str]:
    if not figures:
        return []
    pairs = (f"<div><dt>{page.typeset(n)}</dt><dd>{page.typeset(v)}</dd></div>" for n, v in figures)
    return [f'<dl id="numbers">{"".join(pairs)}</dl>']


def _evidence(average: Average | None, envelope: Envelope | None) -> list[str]:
    parts = []
    if average is not None:
        parts.append(page.picture(average_figure(average), average.caption))
    if envelope is not None:
        parts.append(page.picture(envelope_figure(envelope), envelope.caption))
    return [f'<div id="evidence">{"".join(parts)}</div>'] if parts else []


def _ranking(ranking: Sequence[tuple[str, float, str, str]], note: str) -> list[str]:
    if not ranking:
        return []
    rows = [(component, decibels(evidence), *others) for component, evidence, *others in ranking]
    headers = ("component", "increase dB", STRENGTH, "remark")
    first, more = rows[:RANKED_AT_ONCE], rows[RANKED_AT_ONCE:]
    parts = [page.table(Grid(title="Components by their evidence", headers=headers, rows=tuple(first)))]
    if more:
        rest = Grid(title="", headers=headers, rows=tuple(more))
        parts.append(page.folded(f"{len(more)} more components", page.table(rest)))
    parts += [page.note(note)] if note else []
    return [f'<div id="ranking">{"".join(parts)}</div>']
