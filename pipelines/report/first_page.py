"""The first screen as parts of the page: verdict, numbers, figures, ranking of components."""

from __future__ import annotations

from collections.abc import Sequence

from pipelines.diagnosis.verdict import decibels
from pipelines.diagnosis.words import STRENGTH
from pipelines.io.grid import grid
from pipelines.report import page

RANKED_AT_ONCE = 5  # components on the first screen; the others open on a click


def first_screen(
    *,
    sentences: Sequence[str] = (),
    found: bool | None = None,
    figures: Sequence[tuple[str, str]] = (),
    evidence: Sequence[str] = (),
    ranking: Sequence[tuple[str, float, str, str]] = (),
    ranking_note: str = "",
) -> list[str]:
    """The parts of the page: verdict, numbers, figures, ranking; parts that a run does not have are omitted.

    Parameters
    ----------
    sentences, found : the verdict, the answer first; whether damage is found, None without a diagnosis
    figures : names with their values: f_m, f_r, speed
    evidence : the figures that support the verdict, as HTML
    ranking : components with their increase in dB, their evidence ("-" where it has no limit), and a remark
    ranking_note : explains the columns of the ranking
    """
    return [
        *_verdict(sentences, found),
        *_figures(figures),
        *([f'<div id="evidence">{"".join(evidence)}</div>'] if evidence else []),
        *_ranking(ranking, ranking_note),
    ]


def _verdict(sentences: Sequence[str], found: bool | None) -> list[str]:
    style = {True: "fault", False: "none", None: "open"}[found]
    parts = [page.paragraph(sentence) for sentence in sentences]
    return [f'<div class="verdict {style}" id="verdict">{"".join(parts)}</div>']


def _figures(figures: Sequence[tuple[str, str]]) -> list[str]:
    pairs = (f"<div><dt>{page.typeset(n)}</dt><dd>{page.typeset(v)}</dd></div>" for n, v in figures)
    return [f'<dl id="numbers">{"".join(pairs)}</dl>']


def _ranking(ranking: Sequence[tuple[str, float, str, str]], note: str) -> list[str]:
    if not ranking:
        return []
    rows = [
        {"component": component, "increase dB": decibels(increase), STRENGTH: strength, "remark": remark}
        for component, increase, strength, remark in ranking
    ]
    more = rows[RANKED_AT_ONCE:]
    parts = [page.table(grid("Components by their evidence", rows[:RANKED_AT_ONCE]))]
    if more:
        parts.append(page.folded(f"{len(more)} more components", page.table(grid("", more))))
    parts += [page.note(note)] if note else []
    return [f'<div id="ranking">{"".join(parts)}</div>']
