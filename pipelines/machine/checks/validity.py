"""A scene that can be run: everything that can be known before computing, asked in one place by every command."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pipelines.io.errors import Problem, Problems, SceneError
from pipelines.machine.checks.collisions import find_collisions
from pipelines.machine.checks.cost import too_long
from pipelines.machine.checks.flank_checks import bad_flanks
from pipelines.machine.checks.held_shafts import unheld
from pipelines.machine.checks.machine_checks import long_shafts, off_shaft
from pipelines.machine.checks.strength import bursting, overloaded
from pipelines.machine.checks.window_checks import bad_windows
from pipelines.machine.layout import lay_out
from pipelines.machine.plant import REFUSALS, Plant, drivetrain, in_casing
from pipelines.scene.scene import Scene
from pipelines.scene.tables.casing import FlexibleBase
from pipelines.scene.tables.housing import HousingBase

FARTHEST_SENSOR_MM = 50.0  # a sensor farther from the housing is a mistake in the scene


def checked_plant(scene: Scene, source: str) -> Plant:
    """The plant of a scene after every check that needs no computation.

    Raises
    ------
    SceneError : everything that does not fit, at once
    """
    made = Problems(*REFUSALS)
    train = drivetrain(scene, lay_out(scene, source), made)
    layout = train.layout
    places = [*off_shaft(scene, layout)]
    problems = [
        *find_collisions(scene, layout),
        *bad_flanks(scene, train),
        *overloaded(scene, layout),
        *bursting(scene, layout),
        *too_long(scene),
        *places,
    ]
    if isinstance(scene.casing, FlexibleBase) and isinstance(scene.casing.housing, HousingBase):
        problems += _far_sensors(scene, scene.casing.housing)
    plant = in_casing(train, scene, source, made)
    if plant is None:
        # what is off its shaft is listed by its key already
        more = [one for one in dict.fromkeys(made) if not (places and one.path == "shafts")]
        raise SceneError(source, [*problems, *more])
    if not places:
        problems += long_shafts(scene, plant.machine)
    problems += unheld(scene, plant)
    if isinstance(scene.casing, FlexibleBase):
        from pipelines.machine.checks.casing_checks import bad_casing

        problems += bad_casing(scene, plant)
    if scene.control is not None:  # without a control there is no diagnosis
        problems += bad_windows(scene, plant)
    if problems:
        raise SceneError(source, problems)
    return plant


def _far_sensors(scene: Scene, box: HousingBase) -> Iterator[Problem]:
    """Sensors outside the box around the housing and its feet by more than the limit."""
    low = (box.left_end_mm, -box.width_mm / 2, -box.shaft_height_mm - box.foot_height_mm - box.pad_height_mm)
    high = (box.left_end_mm + box.length_mm, box.width_mm / 2, box.height_mm - box.shaft_height_mm)
    for number, sensor in enumerate(scene.sensors, 1):
        outside = (max(a - x, x - b, 0.0) for a, x, b in zip(low, sensor.position_mm, high, strict=True))
        distance = math.hypot(*outside)
        if distance > FARTHEST_SENSOR_MM:
            yield Problem(
                f"sensors.{number}.position_mm",
                f"{sensor.name} is {distance:.0f} mm outside the housing; the limit is {FARTHEST_SENSOR_MM:.0f} mm",
                f"Set a place near the housing, x {low[0]:g} to {high[0]:g}, y {low[1]:g} to {high[1]:g}, z "
                f"{low[2]:g} to {high[2]:g} mm.",
            )
