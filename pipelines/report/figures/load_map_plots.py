"""Figure of a gear pair over its load: transmission error and orders, pressure, load and root stress along the face."""

from __future__ import annotations

import numpy as np
import xarray
from matplotlib import colormaps
from matplotlib.figure import Figure

from pipelines.report.figures.colours import PAIR_COLOURS
from pipelines.report.figures.pattern_pictures import draw_pattern
from pipelines.report.figures.plots import dress, new_figure, plain

_ORDERS = 5  # that are drawn


def load_map_figure(title: str, found: xarray.Dataset) -> Figure:
    """Over the load, along the face, and a row of contact patterns for each state; the first of two states is dashed.

    Parameters
    ----------
    title : of the figure
    found : of `pipelines.runs.load_map.load_map`
    """
    states = [str(one) for one in found.state.values]
    lines = f"dashed: {states[0]}; solid: {states[1]}" if len(states) > 1 else states[0]
    whole = f"{plain(title)}\nhealthy pair without deviations, {plain(lines)}"
    figure = new_figure(7.6 + 2.7 * len(states), 13.0, whole)
    (cycle, ranges, orders), (pressure, load, root), *patterns = figure.subplots(2 + len(states), 3)
    torques = found.pattern_torque.values
    colours = colormaps["viridis"](np.linspace(0.0, 0.8, torques.size))
    face, most = 1e3 * found.face, float(found.pattern.max()) / 1e6
    for state, style, row in zip(states, ["--", "-"][-len(states) :], patterns, strict=True):
        own = found.sel(state=state)
        ranges.plot(own.torque, 1e6 * own.peak_to_peak, style, color="black", label=plain(state))
        for number, colour in zip(range(_ORDERS), PAIR_COLOURS, strict=False):
            label = f"order {number + 1}" if style == "-" else None
            orders.plot(own.torque, 1e6 * own.order_amplitude[:, number], style, color=colour, label=label)
        for number, (torque, colour, axes) in enumerate(zip(torques, colours, row, strict=False)):
            one = own.sel(torque=torque, method="nearest")
            error = 1e6 * (one.transmission_error - one.transmission_error.mean())
            cycle.plot(one.position, error, style, color=colour, label=f"{torque:.4g} N m" if style == "-" else None)
            pressure.plot(face, one.pressure / 1e6, style, color=colour)
            factors = found.face_load_factor.sel(torque=torque, method="nearest").values
            named = ", ".join(f"{factor:.3g} {plain(name)}" for name, factor in zip(states, factors, strict=True))
            label = f"{torque:.4g} N m: $K_{{H\\beta}}$ {named}"
            load.plot(face, one.line_load / 1e3, style, color=colour, label=label if style == "-" else None)
            pattern = one.pattern[number] / 1e6
            drawn = draw_pattern(
                axes, 1e3 * own.pattern_face, 1e3 * own.diameter, pattern, most, 1e3 * found.pitch_diameter
            )
            dress(axes, f"{plain(state)}, {torque:.4g} N m: {float(pattern.max()):.0f} MPa", "y from mid face, mm", "")
            axes.grid(visible=False)
        for axes in row[torques.size :]:
            axes.set_axis_off()
        row[0].set_ylabel("diameter on the pinion, mm")
        for gear, colour in (("pinion", PAIR_COLOURS[0]), ("wheel", PAIR_COLOURS[1])):
            stress = own.root_stress.sel(gear=gear)[-1] / 1e6
            root.plot(1e3 * own.root_face, stress, style, color=colour, label=gear if style == "-" else None)
    most_torque = float(found.torque[-1])
    for axes, *texts in (
        (cycle, "transmission error less its mean", "mesh cycle", "µm"),
        (ranges, "peak-to-peak transmission error", "torque on the pinion, N m", "µm"),
        (orders, "amplitudes of the mesh orders", "torque on the pinion, N m", "µm"),
        (pressure, "largest pressure on the active flanks", "y from mid face, mm", "Hertz pressure, MPa"),
        (load, "mean line load of all tooth pairs", "y from mid face, mm", "N/mm"),
        (root, f"root stress at {most_torque:.4g} N m", "y from mid face, mm", "von Mises stress, MPa"),
    ):
        dress(axes, *texts)
    for axes in (ranges, orders, pressure, load, root):
        axes.set_ylim(0.0, (1.5 if axes is load else 1.3) * axes.get_ylim()[1])  # room for the legend
    low, high = cycle.get_ylim()
    cycle.set_ylim(low, high + 0.3 * (high - low))
    for axes in (cycle, ranges, orders, load, root):
        axes.legend(fontsize=8, frameon=False, loc="upper left", ncols=1 if axes is load else 2)
    figure.colorbar(drawn, ax=np.concatenate(patterns), shrink=0.9, pad=0.01).set_label("Hertz pressure, MPa")
    return figure
