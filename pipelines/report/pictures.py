"""The figures of gears, stiffness and casing as elements of the page: they show the machine, not its motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipelines.figures.callouts import casing_figure, gear_figure
from pipelines.figures.plots import StiffnessPlot, stiffness_figure
from pipelines.figures.views import Picture
from pipelines.report import page


def gears(picture: Picture, curve: StiffnessPlot, names: Mapping[str, str]) -> str:
    """The rendered pair beside its stiffness; `names` are words for the places "pinion", "wheel" and "marked"."""
    caption = "The gear pair in three dimensions and its stiffness over the mesh cycle."
    return page.picture(gear_figure(picture, curve, names), caption)


def stiffness(curves: Sequence[StiffnessPlot]) -> str:
    """The stiffness of every stage."""
    caption = "Mesh stiffness over the mesh cycle; one cycle is the passage of one tooth pair."
    return page.picture(stiffness_figure(curves), caption)


def casing(picture: Picture) -> str:
    """The rendered casing with its key points."""
    caption = "Key points of the casing: ground (yellow), bearings (red), sensors (green)."
    return page.picture(casing_figure(picture), caption)
