"""A study of the spread as text and as a figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.io.errors import InputError
from pipelines.io.text_table import grid
from pipelines.signals.features.definitions import BY_NAME
from pipelines.studies.spread.population_spread import FeatureSpread

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

LINES = 12  # in the figure
_ROWS = 20  # in the text
_BARS = 3  # contributors of a line
INTERVAL = 1.645  # standard errors


def text(found: FeatureSpread) -> str:
    """The shares of the variables over all lines, and the lines with the widest intervals."""
    rows = found.means()
    shares = rows[list(found.variables)]
    first = shares.fillna(-np.inf).to_numpy().argmax(axis=1)
    variables = [
        {
            "variable": name,
            "mean index": _number(shares[name].mean()),
            "largest in": f"{np.sum(first == number)} of {len(rows)}",
        }
        for number, name in sorted(enumerate(found.variables), key=lambda one: -np.nan_to_num(shares[one[1]].mean()))
    ]
    lines = [
        {
            "component": row.component,
            "feature": BY_NAME[row.feature].words,
            "unit": row.unit,
            "median": f"{row['median']:.1f}",
            "90 % interval": f"{row.low:.1f} to {row.high:.1f}",
            "largest first-order indices (90 % interval)": ", ".join(
                f"{name} {_number(row[name])} ± {INTERVAL * row[f'{name}_error']:.2f}"
                for name in contributors(found, row)
            )
            or "-",
        }
        for _, row in rows.head(_ROWS).iterrows()
    ]
    few = f" {found.left_out} lines are left out, because some machines do not have them." if found.left_out else ""
    parts = [
        f"{found.name}: {found.machines} machines. Levels are means over all channels.{few}",
        grid("First-order Sobol indices, mean over the lines", variables).to_text(),
        f"The indices explain {1.0 - rows.remainder.mean():.0%} of the variance, mean over the lines. Interactions and "
        "variables without an index make the rest.",
        grid(f"The {len(lines)} widest of {len(rows)} lines", lines).to_text(),
    ]
    return "\n\n".join(parts) + "\n"


def _number(value: float) -> str:
    """An index, "-" if there is none."""
    return "-" if np.isnan(value) else f"{value:.2f}"


def contributors(found: FeatureSpread, row: pandas.Series) -> list[str]:
    """At most three variables with the largest indices of a line whose intervals do not hold 0."""
    clear = [name for name in found.variables if row[name] > INTERVAL * row[f"{name}_error"]]
    return sorted(clear, key=lambda name: -row[name])[:_BARS]


def chosen(found: FeatureSpread, features: Sequence[str]) -> pandas.DataFrame:
    """The lines of a figure: those of the features, or the widest ones.

    Raises
    ------
    InputError : no line has this feature
    """
    rows = found.means()
    asked = rows[rows.feature.isin(features)]
    if features and asked.empty:
        raise InputError(
            f"--feature {features[0]}: this scene does not have it. Allowed: {', '.join(set(rows.feature))}."
        )
    return asked if features else rows.head(LINES)


def figure(found: FeatureSpread, rows: pandas.DataFrame) -> Figure:
    """Interval of each line, and the indices of its largest contributors."""
    from pipelines.report.figures.colours import PAIR_COLOURS
    from pipelines.report.figures.plots import FIRST, dress, new_figure, plain

    made = new_figure(1.2 + 0.55 * len(rows))
    left, right = made.subplots(1, 2, sharey=True, width_ratios=[2, 3])
    largest = [contributors(found, row) for _, row in rows.iterrows()]
    colours = {name: PAIR_COLOURS[number % len(PAIR_COLOURS)] for number, name in enumerate(found.variables)}
    places = np.arange(len(rows))
    ends = rows["median"] - rows.low, rows.high - rows["median"]
    left.errorbar(np.zeros(len(rows)), places, xerr=ends, fmt="o", ms=4, lw=1.5, capsize=3, color=FIRST)
    height = 0.8 / _BARS
    for number, ((_, row), names) in enumerate(zip(rows.iterrows(), largest, strict=True)):
        for bar, name in enumerate(names):
            where: Any = number + (bar - 1) * height
            error = INTERVAL * row[f"{name}_error"]
            right.barh(where, max(row[name], 0.0), 0.9 * height, xerr=error, color=colours[name], capsize=2)
    for name in [name for name in found.variables if any(name in names for names in largest)]:
        right.barh(0, 0, color=colours[name], label=plain(name))
    words = [plain(f"{row.component}: {BY_NAME[row.feature].words}") for _, row in rows.iterrows()]
    left.set_yticks(places, labels=words)
    left.invert_yaxis()
    right.set_xlim(0.0, 1.0)
    unit = "dB" if set(rows.unit) == {"dB"} else "dB, or the unit of the feature"
    dress(left, f"90 % interval of {found.machines} machines", f"difference from the median, {unit}", "")
    dress(right, "Largest first-order Sobol indices, 90 % intervals", "share of the variance", "")
    made.legend(frameon=False, fontsize=9, ncols=4, loc="outside lower center")
    return made
