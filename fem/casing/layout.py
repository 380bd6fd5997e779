"""The usual housing around parallel shafts: bores, bosses, feet and nine sensors placed from the shaft positions."""

from __future__ import annotations

from collections.abc import Sequence

from fem.casing.housing import Bore, Feet, Housing, Sensor

RIG_SHAFTS = (0.0, 0.07668, 0.18275, 0.31569)  # m
RIG_BORES = (0.047, 0.052, 0.072, 0.085)  # m, outer diameters of bearings 6204, 6205, 6207, 6209


def housing_for_shafts(
    shaft_x: Sequence[float] = RIG_SHAFTS,
    *,
    bore_diameters: Sequence[float] = RIG_BORES,
    shaft_z: Sequence[float] | None = None,
    length: float = 0.600,
    width: float = 0.300,
    height: float = 0.250,
    wall_thickness: float = 0.010,
    left: float = -0.130,
    axis_height: float = 0.125,
    boss_wall: float = 0.010,
    boss_length: float = 0.030,
) -> Housing:
    """A housing with two bearings per shaft, odd numbers at -y and even numbers at +y, in shaft order.

    Parameters
    ----------
    shaft_x, shaft_z : m, axes of the shafts (z = 0 by default)
    bore_diameters : m, one per shaft
    boss_wall : m, thickness of the ring around each bore
    others : m, see `Housing`

    Raises
    ------
    HousingError : the parts do not fit together
    """
    bores = []
    for i, (x, diameter) in enumerate(zip(shaft_x, bore_diameters, strict=True)):
        for side in (-1, 1):
            bores.append(
                Bore(
                    name=f"bearing_{2 * i + (1 if side < 0 else 2)}",
                    x=x,
                    z=0.0 if shaft_z is None else shaft_z[i],
                    side=side,
                    diameter=diameter,
                    boss_diameter=diameter + 2 * boss_wall,
                    boss_length=boss_length,
                )
            )
    foot = Feet(x=(0.0, 0.0, 0.0))
    ends = left + 0.05 * length + foot.length / 2, left + 0.95 * length - foot.length / 2
    feet = Feet(x=(ends[0], sum(ends) / 2, ends[1]))
    bare = Housing(
        length=length,
        width=width,
        height=height,
        wall_thickness=wall_thickness,
        left=left,
        axis_height=axis_height,
        bores=tuple(bores),
        feet=feet,
    )
    return Housing(**{**bare.__dict__, "sensors": usual_sensors(bare)})


def usual_sensors(housing: Housing) -> tuple[Sensor, ...]:
    """Nine sensors: four on bosses of the wall at -y (sensor_3 on bearing_3), one on a boss at +y, two on the cover,
    one on the end wall at the output, one on a foot. With fewer than four shafts those on missing bosses are left out.
    """
    low, high = housing.box
    middle = 0.5 * (low + high)
    known = {bore.name: bore for bore in housing.bores}
    places: dict[str, tuple[float, float, float]] = {}
    on_boss = {"sensor_1": "bearing_1", "sensor_2": "bearing_2", "sensor_3": "bearing_3"}
    on_boss |= {"sensor_4": "bearing_5", "sensor_5": "bearing_7"}
    for sensor, bearing in on_boss.items():
        if bearing in known:  # on top of the boss, in the middle of the part that stands out of the wall
            bore = known[bearing]
            y = bore.side * (housing.width + bore.boss_length - housing.wall_thickness) / 2
            places[sensor] = (bore.x, y, bore.z + bore.boss_diameter / 2)
    places["sensor_6"] = (low[0] + 0.3 * housing.length, 0.2 * housing.width, high[2])
    places["sensor_7"] = (low[0] + 0.7 * housing.length, -0.2 * housing.width, high[2])
    places["sensor_8"] = (high[0], 0.15 * housing.width, middle[2] + 0.2 * housing.height)
    foot_low, foot_high = housing.foot_boxes()["ground_5"]
    places["sensor_9"] = (
        0.5 * (foot_low[0] + foot_high[0]),
        -(housing.width + housing.feet.width) / 2,
        foot_high[2],
    )
    return tuple(Sensor(name=name, position=tuple(map(float, place))) for name, place in places.items())  # type: ignore[arg-type]
