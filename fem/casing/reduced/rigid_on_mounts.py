"""The model `rigid`: a rigid housing on six mount springs, with its mass from the volumes of its parts, or a mesh.

q = [translation of the centre of gravity, rotation], M = diag(m, m, m, I), K = sum R_i^T k_i R_i with
u(x) = R q = t + r x (x - x_cg).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fem.casing.geometry.dimensions import Sensor
from fem.casing.geometry.housing import Housing
from fem.casing.mesh.mesh import CasingMesh
from fem.casing.parts.casing_choices import DampingRatio
from fem.casing.reduced.attachment import AXES, nearest_surface_point
from fem.casing.reduced.damping import modal_damping
from fem.casing.reduced.reduced_body import BEARING_AXES, ReducedBody
from fem.elements.solids import mass_properties, rigid_body_modes


def housing_mass(housing: Housing, density: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass (kg), centre of gravity (3,) (m) and inertia about it (3, 3) (kg m2), exact for a plain housing.

    Box minus cavity plus boss cylinders inside the box minus bores plus feet.
    """
    wall = housing.wall("side")
    parts = [_block(*housing.box, 1.0), _block(*housing.cavity, -1.0)]
    parts += [_block(*corners, 1.0) for corners in housing.foot_boxes().values()]
    for bore in housing.bores:
        start, end = housing.bore_span(bore)
        inner = (start + wall, end) if bore.side < 0 else (start, end - wall)
        parts.append(_cylinder(bore.x, bore.z, *inner, bore.boss_diameter, 1.0))
        parts.append(_cylinder(bore.x, bore.z, start, end, bore.diameter, -1.0))
    volume = sum(part[0] for part in parts)
    centre = np.sum([part[0] * part[1] for part in parts], axis=0) / volume
    second = np.sum([part[2] + part[0] * np.outer(part[1] - centre, part[1] - centre) for part in parts], axis=0)
    return density * volume, centre, density * (np.trace(second) * np.eye(3) - second)


_Part = tuple[float, np.ndarray, np.ndarray]  # signed volume, centre, second moments about the centre


def _block(low: np.ndarray, high: np.ndarray, sign: float) -> _Part:
    size = high - low
    volume = sign * float(np.prod(size))
    return volume, 0.5 * (low + high), volume * np.diag(size**2) / 12.0


def _cylinder(x: float, z: float, start: float, end: float, diameter: float, sign: float) -> _Part:
    radius, length = diameter / 2.0, end - start
    volume = sign * math.pi * radius**2 * length
    second = np.diag([radius**2 / 4.0, length**2 / 12.0, radius**2 / 4.0])
    return volume, np.array([x, 0.5 * (start + end), z]), volume * second


def rigid_body(
    body: Housing | CasingMesh,
    *,
    density: float,
    mount_stiffness: float,
    damping_ratio: DampingRatio = 0.01,
    sensors: Sequence[Sensor] = (),
) -> ReducedBody:
    """Reduced body of a rigid housing on springs.

    Parameters
    ----------
    body : a `plain` parametric housing, or the mesh of any housing: with ribs, a flange, bolt pads or fillets the mass
        needs the mesh, which then also gives the key points and the positions of the sensors
    density : kg/m3
    mount_stiffness : N/m of each foot, in x, y and z
    damping_ratio : of all six modes, or rows (Hz, ratio)
    sensors : three rows each, along their own axes

    Raises
    ------
    AttachmentError : a sensor far from the surface of the mesh
    """
    if isinstance(body, CasingMesh):
        mass, centre, inertia = mass_properties(body.nodes, body.elements, density)
        grounds, bearings = ({n: body.point(n) for n in body.patches(kind)} for kind in ("ground_", "bearing_"))
        spots = {s.name: nearest_surface_point(body.nodes, body.facets, np.array(s.position))[2] for s in sensors}
    else:
        mass, centre, inertia = housing_mass(body, density)
        grounds, bearings = body.ground_points(), {bore.name: body.bore_centre(bore) for bore in body.bores}
        spots = {sensor.name: np.array(sensor.position) for sensor in sensors}
    mounts = rigid_body_modes(np.array(list(grounds.values())), centre)
    stiffness = mount_stiffness * (mounts.T @ mounts)
    M = np.zeros((6, 6))
    M[:3, :3], M[3:, 3:] = mass * np.eye(3), inertia
    places = {**grounds, **bearings, **spots}
    rows, row_names = [], []
    for name, place in bearings.items():
        motion = np.vstack([rigid_body_modes(place[None], centre), np.eye(6)[3:]])
        rows.append(motion[[AXES.index(axis) for axis in BEARING_AXES]])
        row_names += [f"{name}:{axis}" for axis in BEARING_AXES]
    for sensor in sensors:
        rows.append(np.array(sensor.axes) @ rigid_body_modes(places[sensor.name][None], centre))
        row_names += [f"{sensor.name}:{axis}" for axis in AXES[:3]]
    return ReducedBody(
        model="rigid",
        mass=M,
        stiffness=stiffness,
        damping=modal_damping(M, stiffness, damping_ratio),
        coordinate_names=tuple(f"body:{axis}" for axis in AXES),
        row_names=tuple(row_names),
        rows=np.vstack(rows),
        ground_inertia=M[:, :3],
        row_shifts=np.vstack(rows)[:, :3],
        point_names=tuple(places),
        point_positions=np.array(list(places.values())),
        foot_stiffness=-mount_stiffness * mounts,
        foot_inertia=np.zeros((len(mounts), 3)),
    )
