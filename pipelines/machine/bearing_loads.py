"""Direction of the static load of every bearing, by the equilibrium of rigid shafts on their bearings.

The loads are the mesh forces at the largest load, the weights of shafts and disks, and the pull of ropes on drums. The
springs are the linear references of the bearings and the shaft couplings. A shaft on two bearings is statically
determinate, so its result does not depend on these springs.

Neglected: bending of the shafts, clearances, the motion of the casing, and excitations.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mbd.parts.bearings import BEARING_AXES
from mbd.parts.gear_mesh import contact_rows
from mbd.parts.load import pull_axis
from mbd.parts.machine import STANDARD_GRAVITY
from mbd.parts.shafts import AXES
from pipelines.machine.layout import TrainLayout
from pipelines.machine.machine_model import Drivetrain

_ROTATION = 4  # ry, which the drive and the meshes hold
_UNLOADED = 1e-3  # N, below which a load has no direction


def rigid_row(shafts: int, shaft: int, y: float, coefficients: np.ndarray) -> np.ndarray:
    """Row (6 shafts,) of the motions of rigid shafts at y = 0.

    Parameters
    ----------
    shafts, shaft : their number, and the one that the row reads (from 0)
    y : m, place on this shaft
    coefficients : (6,) of the motion of the shaft there
    """
    found = np.zeros(6 * shafts)
    x, _, z = coefficients[:3]
    found[6 * shaft : 6 * shaft + 6] = coefficients + [0.0, 0.0, 0.0, y * z, 0.0, -y * x]
    return found


def flank_rows(layout: TrainLayout, stage: int) -> np.ndarray:
    """The rows (4, 12) of `mbd.parts.gear_mesh.contact_rows` of a stage (from 0)."""
    pair, (driving, driven) = layout.pairs[stage], layout.pair_shafts[stage]
    line = layout.axes[driven][0] - layout.axes[driving][0], layout.axes[driven][1] - layout.axes[driving][1]
    lead = pair.pinion.hand_sign * math.tan(pair.base_helix_angle)
    radii = pair.pinion.base_radius, pair.wheel.base_radius
    return contact_rows(line, radii, pair.working_pressure_angle, lead, layout.senses[driving])


def load_directions(machine: Drivetrain) -> dict[str, float | None]:
    """Angle (rad, from +x towards +z, 0 to 2 pi) at which the shaft presses on every bearing, by its name.

    None for a bearing without radial load. The elements are pressed against the outer ring around this angle.
    """
    parts = machine.parts
    count, numbers = len(parts.shafts), {shaft.name: number for number, shaft in enumerate(parts.shafts)}
    rows = {
        bearing.name: np.array(
            [rigid_row(count, numbers[bearing.shaft], bearing.y, np.eye(6)[AXES.index(axis)]) for axis in BEARING_AXES]
        )
        for bearing in parts.bearings
    }
    stiffness = sum(rows[one.name].T @ one.stiffness_matrix @ rows[one.name] for one in parts.bearings)
    for coupling in parts.shaft_couplings:
        one, other = (numbers[shaft] for shaft in coupling.shafts)
        for direction, strength in zip(np.eye(6), coupling.stiffness, strict=True):
            ends = rigid_row(count, one, coupling.y[0], direction), rigid_row(count, other, coupling.y[1], direction)
            stiffness = stiffness + strength * np.outer(ends[0] - ends[1], ends[0] - ends[1])
    force = sum((rigid_row(count, *load) for load in _loads(machine)), np.zeros(6 * count))
    held = np.arange(6 * count) % 6 != _ROTATION
    motion = np.zeros(6 * count)
    motion[held] = np.linalg.lstsq(stiffness[np.ix_(held, held)], force[held], rcond=None)[0]
    found: dict[str, float | None] = {}
    for bearing in parts.bearings:
        x, _, z = (bearing.stiffness_matrix @ rows[bearing.name] @ motion)[:3]
        found[bearing.name] = math.atan2(z, x) % (2 * math.pi) if math.hypot(x, z) > _UNLOADED else None
    return found


def _loads(machine: Drivetrain) -> Iterator[tuple[int, float, np.ndarray]]:
    """Forces and moments on the shafts: shaft (from 0), y (m), and the force (6,) there, N and N m."""
    layout, down = machine.layout, np.eye(6)[2] * -STANDARD_GRAVITY
    for number, shaft in enumerate(machine.parts.shafts):
        for section in shaft.sections:
            area = math.pi / 4 * (section.outer_diameter**2 - section.inner_diameter**2)
            mass = shaft.density * area * (section.y_end - section.y_start)
            yield number, (section.y_start + section.y_end) / 2, mass * down
        for disk in shaft.disks:
            yield number, disk.y, disk.mass * down
    for number, (mesh, facts, shafts) in enumerate(
        zip(machine.parts.meshes, layout.stages, layout.pair_shafts, strict=True)
    ):
        row = flank_rows(layout, number)[0 if facts.mesh_force >= 0 else 2]
        for geared, motion in zip(shafts, (row[:6], row[6:]), strict=True):
            yield geared, mesh.y, -abs(facts.mesh_force) * motion
    if machine.hoist is not None and machine.parts.load is not None:
        drums = machine.parts.load.drums
        pull = machine.hoist.torque / machine.hoist.drum_radius / len(drums)
        direction = np.array([*pull_axis(machine.hoist.rope_direction), 0.0, 0.0, 0.0])
        for y in drums:
            yield layout.loaded, y, pull * direction
