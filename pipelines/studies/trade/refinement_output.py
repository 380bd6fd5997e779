"""A refinement study as a table, a figure and a verdict as text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.io.text_table import Grid, grid
from pipelines.studies.trade.probes import POSITIONS
from pipelines.studies.trade.refinement import RefinementStudy, level_name
from pipelines.studies.trade.refinement_axes import AXES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MESH_MODELS = {  # error against converged three-dimensional contact, docs/choosing-a-model.md
    "iso": "about 10 % softer than plane, with a different variation over the mesh cycle",
    "energy": "within 10 % in single contact, up to 50 % too stiff in double contact",
    "plane": "too stiff by 2 to 3 % (wide pairs), 5 % (narrow spur pairs) or 7 to 14 % (narrow helical pairs)",
    "solid": "within 0.6 % of converged contact in space",
}
CASINGS = {
    "rigid": "its elasticity is left out",
    "none": "it is left out",
    "static": "its inertia is that of the static shapes alone",
    "craig-bampton": "whose error `gearcase casing --error-check` computes",
}
LABELLED = 7  # quantities with the widest uncertainty bands, which have a colour and a name
REACH = {  # probes whose settings affect the quantities of a study, by the probe of the study
    "gears": ("gears",),
    "modes": ("modes",),
    "machine": ("gears", "modes", "machine"),
    "signals": ("gears", "modes", "machine", "signals"),
}
TRANSMISSION = "transmission"
LOWEST_ORDER = 8


def convergence_table(title: str, found: RefinementStudy) -> Grid:
    """One row for each quantity: values at all levels, order, limit, and the error and band of the setting in use."""
    names, at = [level_name(fineness) for fineness in found.fineness], found.in_use
    rows: list[dict[str, object]] = [
        {
            "quantity": f"{quantity}, {found.units[quantity]}",
            **{name: f"{value:.6g}" for name, value in zip(names, one.values, strict=True)},
            "order": one.kind if one.order is None else one.order,
            "extrapolated": f"{one.limit:.6g}",
            "error %": 100 * one.errors[at],
            "band +-%": 100 * one.relative_bands[at],
        }
        for quantity, one in found.quantities.items()
    ]
    costs = {name: f"{level.total_seconds:.3g}" for name, level in zip(names, found.levels, strict=True)}
    rows.append({"quantity": "computing time, s", **costs})
    return grid(f"{title}: convergence over the {AXES[found.axis].words} (x2: twice as fine)", rows)


def verdict(found: RefinementStudy, target: float) -> str:
    """Sentence on whether every quantity at the setting in use has at most the error `target` (relative)."""
    bands = {quantity: c.relative_bands[found.in_use] for quantity, c in found.quantities.items()}
    worst = max(bands, key=lambda quantity: bands[quantity])
    outside = [quantity for quantity, band in bands.items() if band > target]
    widest = f"the widest uncertainty band is {100 * bands[worst]:.2g} % ({worst})"
    if not outside:
        return f"The setting in use is fine enough for {100 * target:g} %: {widest}."
    return (
        f"The setting in use is not shown to be fine enough for {100 * target:g} %: {len(outside)} of {len(bands)} "
        f"quantities have a wider uncertainty band, {widest}. Refine the {AXES[found.axis].words}, or accept the band."
    )


def not_refined(mesh_models: Sequence[str], casing: str, axis: str) -> str:
    """Sentence on errors that a study over `axis` does not contain, with their sizes as far as they are known.

    Parameters
    ----------
    mesh_models : of the stages
    casing : model of the casing
    axis : one of AXES
    """
    probe = AXES[axis].probe
    models = dict.fromkeys(mesh_models) if probe != "modes" else ()
    known = [f"mesh model {model}, {MESH_MODELS[model]}" for model in models]
    if probe != "gears" and casing in CASINGS:
        known.append(f"casing model {casing}, {CASINGS[casing]}")
    others = [AXES[other].words for other in AXES if other != axis and AXES[other].probe in REACH[probe]]
    if others:
        known.append(f"other settings, if the models have them, each with its --over: {', '.join(others)}")
    return f"Not in the uncertainty bands: {'; '.join(known)}." if known else ""


def pairing_words(found: RefinementStudy) -> str:
    """Sentence on how many modes were paired on all levels, and why others were not; "" for studies without modes."""
    if AXES[found.axis].probe != "modes":
        return ""
    from fem.casing.uncertainty.pairing import LEAST_MAC

    count = len(found.quantities) + len(found.unpaired)
    text = f"{len(found.quantities)} of {count} modes have a counterpart on every level."
    if not found.unpaired:
        return text
    modes = ", ".join(f"{name.removeprefix('casing mode ')} ({mac:.2f})" for name, mac in found.unpaired.items())
    return (
        f"{text} Left out: modes {modes}. In brackets: MAC of the most similar mode on another level; a pair needs "
        f"{LEAST_MAC:g} or more and no better partner. Close modes mix from mesh to mesh: refine the mesh, or judge "
        "them together."
    )


def convergence_figure(name: str, found: RefinementStudy) -> Figure:
    """Figure of the error of every quantity over the size, in logarithmic scales, with the bands of the setting in use.

    The `LABELLED` quantities with the widest bands have a colour and a name, all others are grey.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    from pipelines.report.figures.plots import dress, new_figure, plain

    figure = new_figure(6.0)
    axes = figure.subplots()
    sizes = [1 / fineness for fineness in found.fineness]
    known = [error for c in found.quantities.values() for error in (*c.errors, *c.relative_bands) if error > 0.0]
    floor = max(min(known, default=1.0) / 10, 1e-10)  # shown instead of 0 where the finest value is the limit
    worst = sorted(found.quantities, key=lambda name: found.quantities[name].relative_bands[found.in_use])[-LABELLED:]
    for quantity, convergence in found.quantities.items():
        errors = [100 * max(error, floor) for error in convergence.errors]
        looks: dict[str, Any] = {"color": "0.75", "lw": 0.8, "zorder": 1.5}
        if quantity in worst:
            order = convergence.kind if convergence.order is None else f"order {convergence.order:.2g}"
            looks = {"color": f"C{worst.index(quantity)}", "lw": 1.4, "label": f"{quantity} ({order})", "zorder": 2.5}
        (line,) = axes.loglog(sizes, errors, marker="o", ms=4, **looks)
        band = 100 * max(convergence.relative_bands[found.in_use], floor)
        axes.plot([1.0], [band], marker="_", ms=14, mew=2, color=line.get_color(), zorder=looks["zorder"])
    rest = len(found.quantities) - len(worst)
    if rest:
        axes.plot([], [], color="0.75", marker="o", ms=4, lw=0.8, label=f"{rest} others, with narrower bands")
    axes.axvline(1.0, color="black", lw=0.8, ls=":", label="setting in use; dashes: its uncertainty bands")
    title = f"{plain(name)}: convergence over the {AXES[found.axis].words}"
    dress(axes, title, "level (x2: twice as fine)", "error relative to the limit, % (0 at the lower edge)")
    axes.set_xticks(sizes, labels=[level_name(fineness) for fineness in found.fineness])
    axes.set_xticks([], minor=True)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    figure.legend(loc="outside lower center", ncols=2, frameon=False, fontsize=9)
    return figure


def tone_and_distance(error: np.ndarray, finest: np.ndarray) -> tuple[float, float]:
    """Largest line of mesh order `LOWEST_ORDER` or above, and standard deviation, of the difference of two curves.

    The curves (position,) cover one mesh cycle.
    """
    difference = np.subtract(error, finest)
    lines = 2 * np.abs(np.fft.rfft(difference)) / difference.size
    return float(lines[LOWEST_ORDER:].max()), float(difference.std())


def slicing_table(title: str, found: RefinementStudy) -> Grid:
    """Table of the TE error against the finest level by stage and level: largest high-order line and rms, um."""
    curves = [
        np.array([v.value for v in level.by_probe[TRANSMISSION]]).reshape(-1, POSITIONS) for level in found.levels
    ]
    names = [level_name(fineness) for fineness in found.fineness[1:]]
    rows: list[dict[str, object]] = []
    for stage, (finest, *coarser) in enumerate(zip(*curves, strict=True), 1):
        errors = [tone_and_distance(one, finest) for one in coarser]
        for words, values in zip(("largest line", "rms"), zip(*errors, strict=True), strict=True):
            cells = {name: f"{value:.2g}" for name, value in zip(names, values, strict=True)}
            rows.append({"TE less that of the finest level": f"stage {stage} {words}, um", **cells})
    return grid(f"{title}: spurious excitation by slices (mesh order {LOWEST_ORDER} and above), error of TE", rows)
