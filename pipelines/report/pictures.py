"""The figures of gears, stiffness and casing as elements of the page: they show the machine, not its motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipelines.report import page
from pipelines.report.figures.callouts import casing_figure, gear_figure
from pipelines.report.figures.plots import StiffnessPlot, stiffness_figure
from pipelines.report.figures.views import Picture


def gears(picture: Picture, curve: StiffnessPlot, names: Mapping[str, str]) -> str:
    """The rendered pair and its stiffness; `names` are words for the places "pinion", "wheel" and "marked"."""
    caption = "The gear pair and its secant stiffness from bore to bore. One mesh cycle is the motion by one pitch."
    return page.picture(gear_figure(picture, curve, names), caption)


def stiffness(curves: Sequence[StiffnessPlot]) -> str:
    """The stiffness of stages that no picture shows."""
    caption = "Secant mesh stiffness of the other stages from bore to bore. One mesh cycle is the motion by one pitch."
    return page.picture(stiffness_figure(curves), caption)


def casing(picture: Picture) -> str:
    """The rendered casing with its bearings, sensors and points on the ground."""
    caption = "The casing with its feet (yellow), bearings (red) and sensors (green)."
    return page.picture(casing_figure(picture), caption)
