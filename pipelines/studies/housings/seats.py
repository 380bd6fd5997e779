"""The shafts of a scene and the bores of a file: which bore is the seat of which bearing, in which unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fem.casing.mesh.imported_housing import UNITS
from fem.casing.recognition.housing_contents import GeometryContents
from fem.casing.recognition.shaft_fit import FittedShaft, ShaftFit, fit_shafts
from pipelines.machine.layout import lay_out
from pipelines.machine.scene_bearings import placed_bearings
from pipelines.scene.scene import Scene


def shaft_places(scene: Scene, source: str) -> tuple[FittedShaft, ...]:
    """The shafts that have bearings in the casing; SceneError if its gears do not work."""
    layout = lay_out(scene, source)
    found: dict[int, list[tuple[str, float]]] = {}
    for one in placed_bearings(scene):
        if one.support == "casing":
            found.setdefault(one.shaft, []).append((one.name, one.y))
    return tuple(
        FittedShaft(
            x=layout.axes[shaft][0],
            z=layout.axes[shaft][1],
            bearings=tuple(bearings),
            diameter=min(_diameter(scene, shaft, y) for _, y in bearings),
        )
        for shaft, bearings in found.items()
    )


def _diameter(scene: Scene, shaft: int, y: float) -> float:
    """Diameter of the shaft at a bearing, m."""
    sections = (one.made() for one in scene.shafts[shaft].sections)
    return min(one.outer_diameter for one in sections if one.y_start <= y <= one.y_end)


def fitting_units(contents: GeometryContents, shafts: Sequence[FittedShaft]) -> dict[str, ShaftFit]:
    """Units of length for which bores coincide with the shafts, each with its fit, the best first."""
    count = sum(len(shaft.bearings) for shaft in shafts)
    found = {}
    for unit, factor in UNITS.items():
        scale = factor / UNITS[contents.unit]
        bores = (
            replace(one, centre=scale * one.centre, diameter=scale * one.diameter, length=scale * one.length)
            for one in contents.bores
        )
        fit = fit_shafts(list(bores), shafts)
        if fit is not None and len(fit.seats) >= min(count, 2):
            found[unit] = fit
    return dict(sorted(found.items(), key=lambda item: (-len(item[1].seats), round(item[1].off, 6))))
