"""Figure of a trend: a small panel for each component or channel over the recordings."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

import numpy as np
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter, date2num
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from pipelines.diagnosis.trend import LEVELS, Course
from pipelines.report.figures.plots import FAULTY, HEALTHY, MARK, dress, fixed_figure, plain

COLUMNS = 3
_PANEL, _DOWN = 1.15, 0.7  # inches, height of a panel and distance to the next
_BAND = "#d7e3ea"


def trend_figure(courses: Sequence[Course], begins: Sequence[datetime] | None) -> Figure:
    """Values over the numbers of the recordings, or over time, with the range of the healthy ones and the limit.

    Parameters
    ----------
    courses : one panel each
    begins : times of the recordings; None if they are not known
    """
    rows = -(-len(courses) // COLUMNS)
    figure = fixed_figure(
        0.88 + rows * _PANEL + (rows - 1) * _DOWN, rows=rows, columns=COLUMNS, left=0.8, down=_DOWN, across=0.7
    )
    place = np.arange(1, len(courses[0].values) + 1) if begins is None else date2num(begins)
    for number, course in enumerate(courses):
        axes = figure.add_subplot(rows, COLUMNS, number + 1)
        if course.healthy is not None:
            axes.axhspan(*course.healthy, color=_BAND, lw=0)
        if course.limit is not None:
            axes.axhline(course.limit, color=MARK, lw=0.9, ls=(0, (4, 3)))
        axes.plot(place, course.values, color=HEALTHY, lw=0.9, marker="o", ms=3.5)
        axes.plot(place[course.above], course.values[course.above], color=FAULTY, lw=0, marker="o", ms=4.5)
        if begins is None:
            axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
        else:
            dates = AutoDateLocator(minticks=2, maxticks=4)
            axes.xaxis.set_major_locator(dates)
            axes.xaxis.set_major_formatter(ConciseDateFormatter(dates))
        axes.yaxis.set_major_locator(MaxNLocator(4))
        name = course.name.partition(" ")[2] if course.unit in LEVELS else course.name  # the page names the level
        first = "" if course.first is None else f", above {'from' if course.above[-1] else 'at'} {course.first}"
        last = begins is None and number + COLUMNS >= len(courses)
        dress(axes, plain(name) + first, "recording" if last else "", "" if number % COLUMNS else course.unit)
    return figure
