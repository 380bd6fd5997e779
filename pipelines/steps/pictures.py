"""Steps `gear picture`, `stiffness curves` and `casing picture`: figures of the machine in a report.

They do not depend on the motion, so they are rendered while the casing is computed. Each step reads only what it shows:
if the load changes, the curves are computed again at its force, but no picture is rendered.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.casing.geometry.dimensions import Sensor
from pipelines.engine.step import Step, Unkept
from pipelines.machine.machine_model import MachineModel
from pipelines.report.figures.damage import needs_law
from pipelines.report.figures.picture_geometry import PlacedPair, placed_pair
from pipelines.report.figures.views import LeftOut, NotRendered, Picture
from pipelines.steps.pair_curves import PITCHES_SHOWN, POSITIONS, PairLaws, PairState, pair_states

if TYPE_CHECKING:
    from fem.casing.mesh.mesh import CasingMesh
    from pipelines.machine.system_assembly import Laws
    from pipelines.report.figures.plots import StiffnessPlot

GEARS, CURVES, CASING = "gear picture", "stiffness curves", "casing picture"


def picture_steps(machine: MachineModel, names: Iterable[str]) -> list[Step]:
    """The picture steps of a machine; `names` are those of its other steps."""
    stage = machine.monitored.stage
    placed = placed_pair(machine, stage)
    steps = [
        Step(
            name=GEARS,
            kind="gear-picture",
            build=build_gears,
            spec=placed,
            takes={"laws": machine.healthy_law_names[stage - 1]} if needs_law(placed.damage) else {},
            libraries=("numpy", "pyvista"),
            seconds=2.0,
        ),
        Step(
            name=CURVES,
            kind="stiffness-curves",
            build=build_curves,
            spec={"pairs": pair_states(machine), "first": stage, "names": gear_names(placed)},
            takes={"picture": GEARS, "laws": machine.law_names, "unmodified": machine.healthy_law_names},
            libraries=("numpy", "matplotlib"),
        ),
    ]
    if "casing mesh" in names:
        steps.append(
            Step(
                name=CASING,
                kind="casing-picture",
                build=build_casing,
                spec=machine.sensors,
                takes={"mesh": "casing mesh"},
                libraries=("numpy", "matplotlib", "pyvista"),
                seconds=2.0,
            )
        )
    return steps


def build_gears(placed: PlacedPair, *, laws: Laws | None = None) -> Picture | Unkept:
    """The rendered pair with its first damaged tooth, or why there is none; `laws` without faults if `needs_law`."""
    from pipelines.report.figures.picture_geometry import stage_view
    from pipelines.report.figures.render import render_gears

    try:
        return render_gears(stage_view(placed, laws[0] if laws else None))
    except NotRendered as error:
        return Unkept(LeftOut(reason=str(error)))


def build_curves(
    pairs: Sequence[PairState],
    first: int,
    names: Mapping[str, str],
    *,
    picture: Picture | LeftOut,
    laws: Sequence[Laws],
    unmodified: Sequence[Laws],
) -> dict[str, Any] | Unkept:
    """Elements of the page: "gears", the picture and its curve or why there is none; "stiffness", the other curves.

    Parameters
    ----------
    pairs, first, names : pairs by stage, the stage (from 1) that is shown first, and labels for its picture
    picture : the rendered gears
    laws, unmodified : laws of each pair with modifications and faults, and without
    """
    from pipelines.report import page
    from pipelines.report.figures.labelled_pictures import gear_figure

    states = zip(pairs, laws, unmodified, strict=True)
    curves = stiffness_plots([state.with_laws(own, healthy) for state, own, healthy in states])
    shown = curves.pop(first - 1)
    if isinstance(picture, LeftOut):
        return Unkept({"gears": picture, "stiffness": stiffness([shown, *curves])})
    caption = "Gear pair and secant mesh stiffness from bore to bore. One mesh cycle is the motion by one base pitch."
    gears = page.picture(gear_figure(picture, shown, names), caption)
    return {"gears": gears, "stiffness": stiffness(curves) if curves else ""}


def stiffness(curves: Sequence[StiffnessPlot]) -> str:
    """The stiffness of stages that no picture shows, as an element of the page."""
    from pipelines.report import page
    from pipelines.report.figures.plots import stiffness_figure

    caption = (
        "Secant mesh stiffness of the other stages from bore to bore. One mesh cycle is the motion by one base pitch."
    )
    return page.picture(stiffness_figure(curves), caption)


def build_casing(sensors: Sequence[Sensor], *, mesh: CasingMesh) -> str | Unkept:
    """The picture of the casing with its key points as an element of the page, or why there is none."""
    from pipelines.report import page
    from pipelines.report.figures.labelled_pictures import casing_figure

    try:
        picture = rendered_casing(mesh, sensors)
    except NotRendered as error:
        return Unkept(LeftOut(reason=str(error)))
    return page.picture(
        casing_figure(picture), "The casing with its feet (yellow), bearings (red) and sensors (green)."
    )


def stiffness_plots(pairs: Sequence[PairLaws]) -> list[StiffnessPlot]:
    """Secant stiffness of every stage at its load, without deviations; with faults around the first damaged tooth."""
    from pipelines.report.figures.plots import StiffnessPlot

    plots = []
    for found in pairs:
        cycle = found.cycle + np.linspace(-PITCHES_SHOWN, PITCHES_SHOWN, POSITIONS)
        plots.append(
            StiffnessPlot(
                title=f"Stage {found.stage}, {found.force:.4g} N, model {found.drive.model}",
                cycle=cycle,
                healthy=found.stiffness(cycle).secant,
                faulty=found.stiffness(cycle, faulty=True).secant if found.faults else None,
                label=found.faults,
            )
        )
    return plots


def gear_names(placed: PlacedPair) -> dict[str, str]:
    """Labels for the picture of a pair."""
    pair, fault = placed.pair, placed.fault
    names = {"pinion": f"pinion, {pair.pinion.teeth} teeth", "wheel": f"wheel, {pair.wheel.teeth} teeth"}
    return names | ({"marked": fault.name.replace("-", " ")} if fault else {})


def rendered_casing(mesh: CasingMesh, sensors: Sequence[Sensor]) -> Picture:
    """Picture of the casing mesh with ground, bearing and sensor points."""
    from fem.casing.reduced.attachment import nearest_surface_point
    from pipelines.report.figures.picture_geometry import casing_surface
    from pipelines.report.figures.render import render_casing

    points = dict(zip(mesh.patch_names, mesh.patch_points, strict=True))
    for sensor in sensors:
        _, _, points[sensor.name] = nearest_surface_point(mesh.nodes, mesh.facets, np.array(sensor.position))
    return render_casing(*casing_surface(mesh.nodes, mesh.facets), points)
