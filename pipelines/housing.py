"""The housing of a scene, in SI: its bores follow the shaft layout."""

from __future__ import annotations

from fem.casing.housing import Bore, Feet, Housing, HousingError, Sensor
from pipelines.errors import Problem, SceneError
from pipelines.layout import Layout
from pipelines.scene import Scene
from pipelines.tables.casing import HousingTable

END_DISTANCE = 0.05  # from the end of the box to the outer feet, in lengths of the box


def bores(table: HousingTable, layout: Layout) -> tuple[Bore, ...]:
    """Two bores per shaft, odd numbers in the wall at -y."""
    return tuple(
        Bore(
            name=f"bearing_{2 * number + (1 if side < 0 else 2)}",
            x=x,
            z=z,
            side=side,
            diameter=bore / 1000,
            boss_diameter=boss / 1000,
            boss_length=table.boss_length_mm / 1000,
        )
        for number, ((x, z), bore, boss) in enumerate(
            zip(layout.axes, table.bore_diameters_mm, table.boss_diameters_mm, strict=True)
        )
        for side in (-1, 1)
    )


def housing(scene: Scene, table: HousingTable, layout: Layout, source: str = "scene") -> Housing:
    """The housing with the sensors of the scene. SceneError with every reason when its parts do not fit together."""
    length, left, side = table.length_mm / 1000, table.left_end_mm / 1000, table.foot_length_mm / 1000
    first, last = left + END_DISTANCE * length + side / 2, left + (1 - END_DISTANCE) * length - side / 2
    try:
        return Housing(
            length=length,
            width=table.width_mm / 1000,
            height=table.height_mm / 1000,
            wall_thickness=table.wall_thickness_mm / 1000,
            left=left,
            axis_height=table.shaft_height_mm / 1000,
            bores=bores(table, layout),
            feet=Feet(x=(first, (first + last) / 2, last), length=side, height=table.foot_height_mm / 1000),
            sensors=tuple(
                Sensor(
                    name=sensor.name,
                    position=(
                        sensor.position_mm[0] / 1000,
                        sensor.position_mm[1] / 1000,
                        sensor.position_mm[2] / 1000,
                    ),
                )
                for sensor in scene.sensors
            ),
        )
    except HousingError as error:
        raise SceneError(source, [Problem("casing.housing", str(error))]) from error
