"""Page of a trend over recordings: their answers, evidence and levels over the recordings, and links to their pages."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path

from pipelines.diagnosis.trend import LEVELS, Course, trend_grid
from pipelines.io.user_files import write_whole
from pipelines.report import page
from pipelines.report.figures.trend_plots import trend_figure
from pipelines.runs.judged_recording import JudgedFile, notes_of
from pipelines.runs.judged_words import files_grid


def write_trend_page(
    path: Path,
    names: Sequence[str],
    judged: Sequence[JudgedFile],
    refused: Mapping[str, str],
    order: str,
    timed: bool,
    courses: Sequence[Course],
) -> Path:
    """Write the page as one HTML file with its figures inside; returns the path.

    Parameters
    ----------
    path : of the file; the page of recording 1 is 1/report.html in its folder
    names, judged : of the recordings, in the order of the trend
    refused : name -> reason, of those that cannot be judged
    order, timed : this order in words, and whether it is that of time
    courses : from `pipelines.runs.judged_recording.courses_of`
    """
    title = f"Trend over {len(judged)} recordings"
    begins = [one.recorded.begin for one in judged if one.recorded.begin is not None] if timed else None
    links = ", ".join(
        f'<a href="{number}/report.html">{number} {html.escape(name)}</a>' for number, name in enumerate(names, 1)
    )
    body = [page.heading(title, 1), page.paragraph(order), page.table(files_grid(names, judged, refused))]
    notes = [*(f"Refused: {reason}" for reason in refused.values()), *notes_of(judged)]
    body += [*map(page.paragraph, notes), f"<p>{links}</p>"]
    for unit, group in groupby(courses, key=lambda one: one.unit):
        what = LEVELS.get(unit, unit.capitalize())
        own = list(group)
        body.append(page.section(what, [page.picture(trend_figure(own, begins), what + _caption(own))], opened=True))
    body.append(page.section("Values", [page.table(trend_grid(courses))]))
    write_whole(path, page.document(title, body))
    return path


def _caption(courses: Sequence[Course]) -> str:
    """Explanation of what the panels show."""
    explained = [
        (any(one.limit is not None for one in courses), " Dashed: limit."),
        (any(one.healthy is not None for one in courses), " Shaded: range of the healthy recordings."),
        (
            any(one.first is not None for one in courses),
            " Red: the limit is reached; the title gives the number of the first such recording.",
        ),
    ]
    return " of every recording." + "".join(words for shown, words in explained if shown)
