"""A housing around parallel shafts for tests: bores, bosses, feet and nine sensors placed from the shaft positions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from benchmarks.solids import box_mesh
from fem.casing.geometry.dimensions import Bore, Sensor
from fem.casing.geometry.housing import Housing
from fem.casing.geometry.housing_features import Feet
from fem.casing.mesh.finished_mesh import RawMesh, finished_mesh
from fem.casing.mesh.mesh import CasingMesh
from fem.elements.solid_elements import SOLIDS

RIG_SHAFTS = (0.0, 0.07668, 0.18275, 0.31569)  # m
RIG_BORES = (0.047, 0.062, 0.075, 0.095)  # m
RIG_BOSSES = (0.065, 0.080, 0.097, 0.120)  # m


def housing_for_shafts(
    shaft_x: Sequence[float] = RIG_SHAFTS,
    *,
    bore_diameters: Sequence[float] = RIG_BORES,
    boss_diameters: Sequence[float] = RIG_BOSSES,
    shaft_z: Sequence[float] | None = None,
    length: float = 0.600,
    width: float = 0.300,
    height: float = 0.250,
    wall_thickness: float = 0.010,
    left: float = -0.120,
    axis_height: float = 0.125,
    boss_length: float = 0.030,
    foot_length: float = 0.060,
    foot_height: float = 0.015,
    sensors: Sequence[Sensor] | None = None,
) -> Housing:
    """A housing with two bearings per shaft, odd numbers at -y and even numbers at +y, in shaft order.

    Parameters
    ----------
    shaft_x, shaft_z : m, axes of the shafts (z = 0 by default)
    bore_diameters, boss_diameters : m, one per shaft
    sensors : `usual_sensors` by default
    others : m, see `Housing`

    Raises
    ------
    HousingError : the parts do not fit together
    """
    bores = []
    for i, (x, bore, boss) in enumerate(zip(shaft_x, bore_diameters, boss_diameters, strict=True)):
        for number, side in ((2 * i + 1, -1), (2 * i + 2, 1)):
            bores.append(
                Bore(
                    name=f"bearing_{number}",
                    x=x,
                    z=0.0 if shaft_z is None else shaft_z[i],
                    side=side,
                    diameter=bore,
                    boss_diameter=boss,
                    boss_length=boss_length,
                )
            )
    inset = 0.05 * length + foot_length / 2
    bare = Housing(
        length=length,
        width=width,
        height=height,
        wall_thickness=wall_thickness,
        left=left,
        axis_height=axis_height,
        bores=tuple(bores),
        feet=Feet(x=(left + inset, left + length / 2, left + length - inset), length=foot_length, height=foot_height),
    )
    return replace(bare, sensors=usual_sensors(bare) if sensors is None else tuple(sensors))


def small_housing(**changes) -> Housing:
    """A one-stage housing: two shafts, four bearings, six feet."""
    usual = {
        "bore_diameters": (0.047, 0.062),
        "boss_diameters": (0.065, 0.080),
        "length": 0.26,
        "width": 0.16,
        "height": 0.16,
        "left": -0.07,
        "axis_height": 0.08,
        "foot_length": 0.04,
    }
    return housing_for_shafts((0.0, 0.07668), **(usual | changes))


def short_housing(**changes) -> Housing:
    """One shaft, two bearings and four feet: half the elements of `small_housing`, all kinds of edges and seats."""
    usual = {
        "bore_diameters": (0.047,),
        "boss_diameters": (0.065,),
        "length": 0.14,
        "width": 0.12,
        "height": 0.12,
        "left": -0.07,
        "axis_height": 0.06,
    }
    bare = housing_for_shafts((0.0,), foot_length=0.03, boss_length=0.02, **(usual | changes))
    ends = bare.left + 0.015, bare.left + bare.length - 0.015
    return replace(bare, feet=replace(bare.feet, x=ends))


def usual_sensors(housing: Housing) -> tuple[Sensor, ...]:
    """Nine sensors: eight on the bosses (sensor_i on the rim of bearing_i, above the bore), one on the cover.

    With fewer than four shafts, those on missing bosses are left out.
    """
    sensors = []
    for bore in housing.bores[:8]:
        above = bore.z + (bore.diameter + bore.boss_diameter) / 4
        name = bore.name.replace("bearing", "sensor")
        sensors.append(Sensor(name=name, position=(bore.x, bore.side * housing.width / 2, above)))
    low, high = housing.box
    middle = 0.5 * (low + high)
    sensors.append(Sensor(name="sensor_9", position=(float(middle[0]), 0.0, float(high[2]))))
    return tuple(sensors)


def angle_casing(
    element: str = "hexahedron-20", divided: int = 1, move: Callable[[np.ndarray], np.ndarray] | None = None
) -> CasingMesh:
    """An angle of two plates with four feet and two seats, a mirror plane and a re-entrant edge: 36 cells, no mesher.

    Legs of 100 mm, 20 mm thick and 80 mm wide; the seats are at the top of the upright leg. A housing has many times
    the edge functions and unknowns: what holds for any casing is tested on this one in a fraction of the time.

    Parameters
    ----------
    divided : cells through the thickness, of which a tetrahedron takes a sixth
    move : places (n, 3) of the nodes, m, to other ones
    """
    leg, width, thick = 0.1, 0.08, 0.02
    counts = [divided * round(side / thick) for side in (leg, width, leg)]
    nodes, elements = box_mesh((leg, width, leg), counts, element=element)
    nodes = nodes - [0.0, width / 2, 0.0]
    middle = nodes[elements[:, : SOLIDS[element].corners]].mean(axis=1)
    used, flat = np.unique(elements[middle[:, [0, 2]].min(axis=1) < thick], return_inverse=True)
    nodes = nodes[used]
    corners = {
        f"ground_{2 * row + side + 1}": ((x, (width - thick) * (side - 0.5), 0.0), (thick, thick, 0.0))
        for row, x in enumerate((thick / 2, leg - thick / 2))
        for side in (0, 1)
    } | {
        f"bearing_{side + 1}": ((0.0, (width - thick) * (side - 0.5), leg - thick / 2), (0.0, thick, thick))
        for side in (0, 1)
    }
    sets = {
        name: np.flatnonzero((abs(nodes - middle) < np.array(size) / 2 + 1e-9).all(axis=1))
        for name, (middle, size) in corners.items()
    }
    return finished_mesh(
        RawMesh(
            nodes=nodes if move is None else move(nodes), elements=flat.reshape(-1, elements.shape[1]), node_sets=sets
        ),
        lambda surface: (
            {name: np.flatnonzero(surface.groups[name]) for name in sets},
            {name: np.array(middle) for name, (middle, _) in corners.items()},
        ),
        name="angle",
        element=element,
        element_size=thick / divided,
        remedy="",
    )
