"""The first screen as parts of the page: verdict, numbers, figures, ranking of components."""

from __future__ import annotations

from pipelines.diagnosis.verdict import decibels
from pipelines.io.grid import Grid
from pipelines.report import page
from pipelines.report.first_figures import average_figure, envelope_figure
from pipelines.report.first_screen import FirstScreen

RANKED_AT_ONCE = 5  # components on the first screen; the others open on a click


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
    rows = [(one.component, decibels(one.evidence), one.p_value, one.remark) for one in content.ranking]
    headers = ("component", "increase dB", "p-value", "remark")
    first, others = rows[:RANKED_AT_ONCE], rows[RANKED_AT_ONCE:]
    parts = [
        page.table(
            Grid(
                title="Components in the order of their mean increase over the healthy machine",
                headers=headers,
                rows=tuple(first),
            )
        )
    ]
    if others:
        rest = Grid(title="", headers=headers, rows=tuple(others))
        parts.append(page.folded(f"{len(others)} more components", page.table(rest)))
    parts += [page.note(content.ranking_note)] if content.ranking_note else []
    return [f'<div id="ranking">{"".join(parts)}</div>']
