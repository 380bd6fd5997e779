"""A design study as text for the terminal, and as a page with figures and TOML to paste."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.contact.models.solid import Solid
from pipelines.io.text_table import grid
from pipelines.io.user_files import whole_file
from pipelines.studies.design.design_study import COMPROMISE, FINE, DesignStudy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CAPTION = (
    "Left: candidates as evaluated in the search, and, filled, the unmodified pair and the best designs with more "
    "positions in the mesh cycle. Middle and right: transmission error of the nominal pair and the amplitude of its "
    "first order; dashed: their 90 % quantiles over the pairs with deviations"
)
_LEVELS = "Levels at the torque of the scene, by the linearised machine and by the time loop"
_MAP_CAPTION = (
    "Recommended design and the same gears without modifications over the torque, and along the face at the least, a "
    "middle and the largest torque. Contact patterns: largest pressure of a tooth over its engagement; grey: no contact"
)


def words(found: DesignStudy) -> Iterator[str]:
    """The table of the front, and the settings of the best designs."""
    yield grid(found.title, found.rows()).to_text()
    yield _conditions(found)
    if found.levels:
        yield grid(_LEVELS, found.levels).to_text()
        yield _louder(found)
    for name, purpose in _purposes(found).items():
        settings = " ".join(f"--set {key}={value}" for key, value in found.settings(name).items())
        yield f"{purpose}: design {name}\n{settings}"
    yield from _remarks(found)


def _remarks(found: DesignStudy) -> Iterator[str]:
    """What to know of the best designs before one is taken."""
    best = found.best()
    if COMPROMISE in best:
        yield (
            "Compromise: of the designs of the Pareto front that are better than the unmodified pair in every "
            "objective, the nearest to the best values of all objectives, each divided by its range on the front."
        )
    elif len(best) > 1:
        yield "There is no compromise that is better than the unmodified pair in every objective."
    for name in _purposes(found):
        if exceeded := found.exceeded(name):
            yield (
                f"Design {name} exceeds {', '.join(exceeded)} on the finer positions, as all designs shown. Reduce the "
                "limit of the search a little."
            )
        if edges := found.edges(name):
            yield f"Design {name} is at the edge of the range of {', '.join(edges)}. Extend the range with --vary."
    yield from _model(found)


def _conditions(found: DesignStudy) -> str:
    task = found.designs.task
    conditions, torques = task.conditions, ", ".join(f"{torque:.4g}" for torque in task.torques)
    text = (
        f"{len(found.designs.index)} candidates, {torques} N m on the pinion. The table was computed with {FINE} "
        f"positions in the mesh cycle, the search with {conditions.positions}."
    )
    if task.limits:
        text += f" Limits: {', '.join(f'{one.quantity.label} <= {one.most:g}' for one in task.limits)}."
    if conditions.samples:
        flanks = "" if conditions.grade is None else f" of class {conditions.grade}"
        text += (
            f" Deviations: {len(conditions.samples)} pairs{flanks} from seed {task.seed}, "
            f"misalignment up to {1e6 * conditions.misalignment:.3g} um."
        )
    return text


def _model(found: DesignStudy) -> Iterator[str]:
    """What a model without coupling of the slices along the face does not compute."""
    scene = found.evaluate.scene
    if not isinstance(scene.machine.laws[scene.stage - 1].mesh, Solid):
        yield (
            "This mesh model does not couple the parts of a tooth along the face. It underestimates the effect of "
            f"crownings and misalignments. Repeat the search with --set stages.{scene.stage}.mesh.model=solid, which "
            "takes some seconds more."
        )


def _louder(found: DesignStudy) -> str:
    """Designs with less transmission error than the unmodified pair but a level at least as high."""
    changes = [key for key in found.levels[0] if key.endswith(" dB")]
    names = [
        row["design"]
        for row in found.levels[1:]
        if row["te um"] < found.levels[0]["te um"] and max(row[key] for key in changes) >= 0.0
    ]
    if not names:
        return "Every design with less transmission error than the unmodified pair has a lower level, too."
    return f"Less transmission error than the unmodified pair, but a level at least as high: {', '.join(names)}."


def write_page(found: DesignStudy, path: Path) -> None:
    """Write the page: table, figures, TOML of the recommended design."""
    from pipelines.report.figures.load_map_plots import load_map_figure
    from pipelines.report.page import document, heading, paragraph, picture, table

    name = found.recommended
    body = [
        heading(found.title, 1),
        table(grid("", ({re.sub("[._]", " ", key): value for key, value in row.items()} for row in found.rows()))),
        *map(paragraph, (_conditions(found), *_remarks(found))),
        *([table(grid(_LEVELS, found.levels)), paragraph(_louder(found))] if found.levels else []),
        picture(design_figure(found), _CAPTION),
        picture(load_map_figure(found.title, found.load_map(name)), _MAP_CAPTION),
        heading(f"Design {name}"),
        paragraph('Write these lines into a new file, below extends = "..." with the path of the scene:'),
        f"<pre>{html.escape(toml(found.settings(name)))}</pre>",
    ]
    with whole_file(path) as partial:
        partial.write_text(document(found.title, body), encoding="utf-8")


def toml(settings: Mapping[str, Any]) -> str:
    """Settings of a stage as TOML, with a table for each gear."""
    tables: dict[str, list[str]] = {}
    for key, value in settings.items():
        parts = key.split(".")
        depth = min(len(parts) - 1, 3)
        lines = tables.setdefault(f"[{'.'.join(parts[:depth])}]", [])
        lines.append(f"{'.'.join(parts[depth:])} = {json.dumps(value)}")
    return "\n\n".join("\n".join([head, *lines]) for head, lines in tables.items())


def design_figure(found: DesignStudy) -> Figure:
    """Figure of the candidates with the front, and of the transmission error over the torque."""
    from pipelines.report.figures.plots import new_figure

    figure = new_figure(4.6, 16.0)
    front, *loads = figure.subplots(1, 3)
    _draw_front(front, found)
    _draw_loads(loads[0], found, found.results.peak_to_peak, "peak to peak, µm")
    _draw_loads(loads[1], found, found.results.orders[..., 0], "amplitude of order 1, µm")
    return figure


def _draw_front(axes: Axes, found: DesignStudy) -> None:
    """Two objectives near the front, or the objective over the first variable."""
    from pipelines.report.figures.plots import dress

    designs, task = found.designs, found.designs.task
    shown = [(one.label, designs.objectives[:, n], one.of(found.results)) for n, one in enumerate(task.objectives)]
    if len(shown) == 1:
        over = task.variables.given[0]
        named = [np.nan if at is None else designs.values(at)[0] for at in found.candidates]
        shown.insert(0, (over.key, np.array(over.values)[designs.index[:, 0]], np.array(named)))
        axes.axhline(shown[1][2][0], color="black", lw=0.8, ls="--", label="unmodified")
    (x_label, x, x_named), (y_label, y, y_named) = shown[:2]
    met = (designs.excess <= 0.0).all(axis=1)
    axes.plot(x[met], y[met], ".", ms=3, color="0.7", label="candidates")
    if task.limits:
        axes.plot(x[~met], y[~met], "x", ms=3, color="0.85", label="beyond a limit")
    axes.plot(x[designs.front], y[designs.front], "o", ms=6, mfc="none", color="0.3", label="Pareto front")
    colours = {"unmodified": "black"} | {one: f"C{number}" for number, one in enumerate(_purposes(found))}
    for name, at_x, at_y in zip(found.names, x_named, y_named, strict=True):
        axes.plot(at_x, at_y, "o", ms=6, color=colours.get(name, "none"))
        axes.annotate(
            name,
            (at_x, at_y),
            xytext=(5, -13 if name == "unmodified" else 5),
            textcoords="offset points",
            fontsize=9,
            annotation_clip=True,
        )
    for axis, _, values, named in list(zip("xy", *zip(*shown, strict=False), strict=False))[-len(task.objectives) :]:
        near = np.concatenate([values[designs.front], named])
        low, high = np.nanmin(near), np.nanmax(near)
        axes.set(**{f"{axis}lim": (low - 0.1 * (high - low), high + 0.3 * (high - low))})
    dress(axes, f"{len(designs.index)} candidates", x_label, y_label)
    axes.legend(fontsize=8, frameon=False)


def _purposes(found: DesignStudy) -> dict[str, str]:
    """The best designs, and what they are best in."""
    purposes: dict[str, str] = {}
    for purpose, name in found.best().items():
        words = purpose if purpose == COMPROMISE else f"least {purpose}"
        purposes[name] = f"{purposes[name]}, {words}" if name in purposes else words
    return purposes


def _draw_loads(axes: Axes, found: DesignStudy, values: np.ndarray, label: str) -> None:
    """Values (candidate, sample, load), m, of the nominal pair, and the 90 % quantile of the samples."""
    from pipelines.report.figures.plots import dress

    torques = np.array(found.designs.task.torques)
    for number, (name, words) in enumerate({"unmodified": "", **_purposes(found)}.items()):
        own, colour = 1e6 * values[found.names.index(name)], f"C{number - 1}" if number else "black"
        axes.plot(torques, own[0], "o-", ms=4, color=colour, label=f"{name} {words}")
        if len(own) > 1:
            axes.plot(torques, np.quantile(own[1:], 0.9, axis=0), "o--", ms=4, mfc="none", color=colour)
    dress(axes, "transmission error over the torque", "torque on the pinion, N m", label)
    axes.set_ylim(0.0, 1.3 * axes.get_ylim()[1])  # room for the legend
    axes.legend(fontsize=8, frameon=False, loc="upper left", ncols=2)
