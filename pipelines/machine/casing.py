"""The casing of a scene, in SI: its model, and the structure that the model reduces."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from fem.casing.geometry.dimensions import Sensor
from fem.casing.geometry.housing import Housing
from fem.casing.mesh.source import Geometry
from fem.casing.models.casing import Casing, Structure
from fem.casing.models.registry import casing_class
from mbd.parts.bearings import BEARING_AXES, BearingSpec
from pipelines.io.errors import Problem, SceneError
from pipelines.machine.bearings import bearing_points
from pipelines.machine.housing import housing
from pipelines.machine.layout import Layout
from pipelines.machine.parts import MachineParts
from pipelines.scene.scene import Scene
from pipelines.scene.tables.casing import ElasticBase, FlexibleBase
from pipelines.scene.tables.housing import MatricesHousingTable

if TYPE_CHECKING:
    from fem.casing.reduced.grounded import ForcedPoint


def casing(scene: Scene, layout: Layout, machine: MachineParts, source: str) -> tuple[Casing, Structure]:
    """The model with its options, and what it reduces, with the sensors on it. SceneError if it does not fit.

    Parameters
    ----------
    scene, layout, machine : the scene, where its shafts are, and the machine that the casing carries
    source : of the scene, for messages
    """
    table, points = scene.casing, bearing_points(scene.shafts, layout)
    model: Casing = table.made()
    if not isinstance(table, FlexibleBase):
        return model, Structure(bearings={f"bearing_{number}": point for number, point in enumerate(points, 1)})
    sensors: tuple[Sensor, ...] = tuple(sensor.made() for sensor in scene.sensors)
    if isinstance(table.housing, MatricesHousingTable):
        from pipelines.machine.foreign_housing import foreign_housing

        model = casing_class("matrices")(of=model)
        found = Structure(housing=foreign_housing(table.housing, sensors, points, source))
    else:
        found = shaped(table, housing(table.housing, sensors, layout, points, source), source)
    loads, forced = loaded_axes(machine.bearings), forced_points(machine, found.sensors)
    return model, replace(found, interfaces=loads, forced=forced)


def shaped(table: FlexibleBase, made: Geometry, source: str) -> Structure:
    """A housing with its material and its bolts, without loads.

    Raises
    ------
    SceneError : bolts that do not fit, elements by the wavelength in a wall whose thickness is not known
    """
    thinnest = made.thinnest_wall if isinstance(made, Housing) else table.housing.si.wall_thickness
    if thinnest is None and getattr(table, "elements_per_wavelength", None) is not None:
        problem = "is needed for casing.elements_per_wavelength of a housing from a file"
        raise SceneError(
            source, [Problem("casing.housing.wall_thickness_mm", problem, "Set the thickness of its thinnest wall.")]
        )
    joint, bolts = None, getattr(table.housing, "joint", None)
    if isinstance(table, ElasticBase) and bolts is not None:
        from pipelines.machine.joint import bolted_joint  # late, like all that only elastic ones need

        joint = bolted_joint(bolts, made, source)
    return Structure(housing=made, material=table.material.made(name="casing"), joint=joint, wall=thinnest)


def forced_points(machine: MachineParts, sensors: Sequence[Sensor]) -> tuple[ForcedPoint, ...]:
    """Sensors that bear outside forces, with the axes along which they do."""
    pulled = {row for force in machine.forces for row in force.casing_rows}
    if not pulled:
        return ()
    from fem.casing.reduced.grounded import GROUND_AXES, ForcedPoint

    points = ((s, tuple(axis for axis in GROUND_AXES if f"{s.name}:{axis}" in pulled)) for s in sensors)
    return tuple(ForcedPoint(sensor=sensor, axes=axes) for sensor, axes in points if axes)


def loaded_axes(bearings: Iterable[BearingSpec]) -> dict[str, tuple[str, ...]]:
    """Axes along which every bearing loads the casing; an axis without stiffness needs no interface."""
    return {
        spec.name: tuple(axis for axis, k in zip(BEARING_AXES, spec.stiffness, strict=True) if k > 0.0)
        for spec in bearings
    }
