"""A calibration as text, as plain values, and as a corner figure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pipelines.io.text_table import grid
from pipelines.studies.calibrate.calibration import IDENTIFIABLE, Calibration

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BINS = 30


def text(found: Calibration) -> str:
    """All of it for the terminal."""
    low, high = found.interval
    rows = [
        {
            "key": one.key,
            "prior": f"{one.low:g} to {one.high:g}",
            "mean": f"{found.mean[i]:.4g}",
            "90 % interval": f"{low[i]:.4g} to {high[i]:.4g}",
            "width/prior": f"{found.width[i]:.2f}",
            "identifiable": "yes" if found.width[i] <= IDENTIFIABLE else "no",
        }
        for i, one in enumerate(found.free)
    ]
    keys = [one.key for one in found.free]
    pairs = [
        {"key": keys[i], "and": keys[j], "correlation": f"{found.correlation[i, j]:+.2f}"}
        for i in range(len(keys))
        for j in range(i)
    ]
    agreement = [
        {"lines": name, "before, dB": f"{before:.1f}", "after, dB": f"{after:.1f}"}
        for name, (before, after) in found.agreement.items()
    ]
    parts = [
        grid(f"{found.name}: posterior from {found.lines} lines and {found.runs} runs", rows).to_text(),
        f"A key is identifiable if the 90 % interval is at most {IDENTIFIABLE:.2f} of that of the prior. "
        f"{found.inside} of {found.lines} lines of the recording are within the range of the runs (about "
        f"{1 - 2 / (found.runs + 1):.0%} if the scene describes the machine). Below 80 % the scene differs from the "
        "machine in other properties, and the intervals are not valid.",
        *([grid("Correlations of the posterior", pairs).to_text()] if pairs else []),
        grid("Median difference between recording and model, second halves of the windows", agreement).to_text(),
    ]
    return "\n\n".join(parts) + "\n"


def plain(found: Calibration) -> dict[str, Any]:
    """All of it as calibration.json holds it."""
    return {
        "scene": found.name,
        "runs": found.runs,
        "lines": found.lines,
        "lines_inside": found.inside,
        "keys": [
            {
                **vars(one),
                "mean": float(found.mean[i]),
                "interval": found.interval[:, i].tolist(),
                "width_over_prior": float(found.width[i]),
                "identifiable": bool(found.width[i] <= IDENTIFIABLE),
            }
            for i, one in enumerate(found.free)
        ],
        "correlation": found.correlation.tolist(),
        "agreement_dB": {name: {"before": pair[0], "after": pair[1]} for name, pair in found.agreement.items()},
    }


def figure(found: Calibration) -> Figure:
    """Distribution of each key on the diagonal, of each pair of keys below it; the axes are the priors."""
    from pipelines.report.figures.plots import FIRST, MARK, new_figure
    from pipelines.report.figures.plots import plain as plain_words

    count = len(found.free)
    made = new_figure(2.0 * count + 0.6, 2.0 * count + 1.4)
    panels = made.subplots(count, count, squeeze=False, sharex="col")
    ends = [(one.low, one.high) for one in found.free]
    for i, row in enumerate(panels):
        for j, axes in enumerate(row):
            if j > i:
                axes.set_visible(False)
                continue
            if i == j:
                axes.hist(found.samples[:, i], _BINS, range=ends[i], color=FIRST)
                axes.axvspan(*found.interval[:, i], color=MARK, alpha=0.15, lw=0)
                axes.set_yticks([])
            else:
                axes.hist2d(found.samples[:, j], found.samples[:, i], _BINS, range=[ends[j], ends[i]], cmap="Blues")
            if i == count - 1:
                axes.set_xlabel(plain_words(_two_lines(found.free[j].key)), fontsize=8)
            if j == 0 and i > 0:
                axes.set_ylabel(plain_words(_two_lines(found.free[i].key)), fontsize=8)
            elif i != j:
                axes.set_yticklabels([])
            axes.tick_params(labelsize=8)
            axes.set_xlim(*ends[j])
    made.suptitle("Posterior in the ranges of the priors; grey: 90 % intervals", fontsize=10)
    made.align_ylabels()
    return made


def _two_lines(key: str) -> str:
    table, _, name = key.rpartition(".")
    return f"{table}.\n{name}" if table else name
