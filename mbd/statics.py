"""Equilibrium at t = 0: the load hangs, the motors hold.

0 = f + B^T lambda(B q) - K q has the rows u = B K^-1 f + (B K^-1 B^T) lambda(u): the Newton iteration of the time step
with static flexibilities. With no load at all the gears could rest anywhere in the backlash; the drive flanks are then
set to just touch, K q = f + B^T mu with delta = delta_0(c, psi). A swinging container is held at its angle by a force
square to its ropes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mbd.checks import EquilibriumError
from mbd.elements import WIDTH
from mbd.forces import LOG_COLUMNS, element_count, slope_matrix
from mbd.load import Load, Rope, RopePendulum
from mbd.mesh_reference import LARGEST_APPROACH, nominal_forces, touching_approach
from mbd.rows_solver import forces_at, solve_rows
from mbd.system import System

TOLERANCE = 1e-12
ROUNDS = 100


@dataclass(frozen=True, eq=False, kw_only=True)
class State:
    """Where the machine is at one instant: displacements q (n,), rates (n,), residual forces lambda (m,)."""

    displacement: np.ndarray
    velocity: np.ndarray
    forces: np.ndarray
    motor_angle: float
    motor_speed: float  # rad/s; at rest in the rolling frame
    motor_torque: float  # N m, all motors referred to the first one's speed, lifting positive
    mesh_force: np.ndarray  # (mesh,) N, drive flank


def equilibrium(system: System, speed: float = 0.0) -> State:
    """State of rest under the constant loads; with a motor ``speed`` (rad/s) rest in the frame that rolls, so that the
    losses oppose the rotation, at the mesh cycle and rope length of t = 0.

    Raises
    ------
    EquilibriumError : the load cannot be carried (e.g. too many teeth missing), or the iteration fails
    """
    response = system.basis / system.frequencies**2 @ system.basis.T  # K^-1 on everything that can act
    constant = system.constant_force + holding_force(system)
    rows = system.all_rows
    m = len(system.rows)
    free = rows @ (response @ constant)
    flexibility = rows @ response @ system.rows.T
    carried = list(nominal_forces(system.machine).values())
    if idle(system.machine.load):
        forces, log = _touching(system, free, flexibility, speed, np.arange(len(carried)), np.zeros(m))
    elif 0.0 in carried:  # branches that carry nothing
        start, (at, goal) = np.zeros(m), _pressed(system, free)
        start[at] = np.linalg.solve(flexibility[np.ix_(at, at)], goal - free[at])
        resting = np.flatnonzero(np.array(carried) == 0.0)
        forces, log = _touching(system, free, flexibility, speed, resting, start)
    else:
        forces, log = _loaded(system, free, flexibility, speed)
    q = response @ (constant + system.rows.T @ forces)
    ratios, lay = system.machine.ratios(), system.layout
    torque = sum(
        -c.stiffness * ratios[c.shaft] * float(lay.angle_row(c.shaft, c.y) @ q) for c in system.machine.couplings
    )
    return State(
        displacement=q,
        velocity=np.zeros_like(q),
        forces=forces[:m],
        motor_angle=0.0,
        motor_speed=speed,
        motor_torque=torque,
        mesh_force=log[: 2 * len(system.machine.meshes) : 2, 0].copy(),
    )


def idle(load: Load) -> bool:
    """Whether the train carries nothing at t = 0: no torque, or a container on the ground below a slack rope."""
    return load.stands if isinstance(load, Rope) else load.torque == 0.0


def holding_force(system: System) -> np.ndarray:
    """Force (n,) that holds a swinging container at its angle until t = 0, square to the ropes."""
    load, force = system.machine.load, np.zeros(system.layout.size)
    if isinstance(load, RopePendulum) and any(load.sway):
        along = np.array([math.tan(load.sway[0]), math.tan(load.sway[1]), -1.0])
        along /= np.linalg.norm(along)
        force[-3:] = load.container_mass * system.machine.gravity * (-along[2] * along + [0.0, 0.0, 1.0])
    return force


def _loaded(system: System, free: np.ndarray, flexibility: np.ndarray, speed: float) -> tuple[np.ndarray, np.ndarray]:
    m, n_elements = len(system.rows), element_count(system.table)
    force, log = np.zeros(m), np.zeros((n_elements, len(LOG_COLUMNS)))
    u, v, still = np.zeros(len(free)), np.zeros(len(free)), np.zeros(len(free))
    at, goal = _pressed(system, free)
    force[at] = np.linalg.solve(flexibility[np.ix_(at, at)], goal - free[at])
    _swung(system, force)
    used = solve_rows(
        system.table, 0.0, speed, free, still, flexibility, np.zeros_like(flexibility), force, u, v, log, TOLERANCE
    )
    opened = float(abs(u[: 4 * len(system.machine.meshes) : 4]).max(initial=0.0))
    if used < 0 or not opened < LARGEST_APPROACH:
        loads = ", ".join(f"{name} {value:.4g} N" for name, value in nominal_forces(system.machine).items())
        raise EquilibriumError(
            f"equilibrium at t = 0: not found within {LARGEST_APPROACH * 1e3:g} mm (nominal mesh forces: {loads}). "
            "Lower the load, or start where teeth are in mesh (mesh phase at the start)."
        )
    return force, log


def _swung(system: System, force: np.ndarray) -> None:
    """Set the residual forces of pendulum ropes to those of the held container on drums that stand: a first guess."""
    load = system.machine.load
    if not isinstance(load, RopePendulum):
        return
    along = np.array([math.tan(load.sway[0]), math.tan(load.sway[1]), 1.0])
    along /= np.linalg.norm(along)
    tension = load.container_mass * system.machine.gravity * along[2] / len(load.drums)
    distance = load.length * (1 + tension / load.stiffness_times_length)
    place = {
        "stretch": (distance * along[2] - load.length, 2),
        "x": (distance * along[0], 0),
        "y": (distance * along[1], 1),
    }
    first = len(system.rows) - len(system.table.extra.pattern)
    for r, name in enumerate(system.row_names):
        owner, _, rest = name.partition(":")
        if owner == "rope":
            displacement, axis = place[rest.partition(":")[2]]
            force[r] = system.table.extra.stiffness[r - first] * displacement - tension * along[axis]


def _pressed(system: System, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows (mesh,) of the loaded flanks and approaches with all of them well in contact: an open flank leaves the train
    without a hold, and a convex force law is found safely from the side of too much contact."""
    table, loads = system.table, nominal_forces(system.machine)
    rows, found = [], []
    for i, mesh in enumerate(system.machine.meshes):
        cycle = table.cycle_start[i] + table.cycle_rate[i] * free[len(system.rows) + i]
        back = loads[mesh.name] < 0.0  # the driven gear pushes the driving one
        law, offset = (mesh.coast, mesh.backlash) if back else (mesh.drive, 0.0)
        pinion = mesh.coast_clearance_pinion if back else mesh.drive_clearance_pinion
        wheel = mesh.coast_clearance_wheel if back else mesh.drive_clearance_wheel
        touch = touching_approach(law, cycle, pinion, wheel, 0.0) + offset
        rows.append(4 * i + 2 * back)
        found.append(touch + 4 * abs(loads[mesh.name]) / table.stiffness[2 * i, 0])
    return np.array(rows, dtype=int), np.array(found)


def _touching(
    system: System, free: np.ndarray, flexibility: np.ndarray, speed: float, resting: np.ndarray, start: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Forces that the linear reference needs to hold the drive flanks of the ``resting`` meshes at delta_0: with them
    the real force is zero.

    Without contact lambda_psi = k_psi psi cancels the tilt reference and lambda_delta holds the approach; all other
    rows carry their own forces (Newton from ``start``).
    """
    machine, table, m = system.machine, system.table, len(system.rows)
    drive = 4 * resting
    force, still = start.copy(), np.zeros(m)
    u = free + flexibility @ force
    log, held = np.zeros((element_count(table), len(LOG_COLUMNS))), np.full(len(table.tau), -1.0)
    for _ in range(ROUNDS):
        right, slope_u, slope_v = np.zeros(m), np.zeros((m, WIDTH)), np.zeros((m, WIDTH))
        forces_at(table, 0.0, speed, u, still, held, right, slope_u, slope_v, log)
        slope = slope_matrix(slope_u, table)
        slope[drive], slope[drive + 1] = 0.0, 0.0
        slope[drive + 1, drive + 1] = table.stiffness[2 * resting, 1]
        right[drive + 1] = table.stiffness[2 * resting, 1] * u[drive + 1]
        right += slope @ (free[:m] - u[:m])
        matrix = np.eye(m) - slope @ flexibility[:m]
        for i, row in zip(resting, drive, strict=True):
            mesh, cycle = machine.meshes[i], table.cycle_start[i] + table.cycle_rate[i] * u[m + i]
            right[row] = -free[row] + touching_approach(
                mesh.drive, cycle, mesh.drive_clearance_pinion, mesh.drive_clearance_wheel, u[row + 1]
            )
        matrix[drive] = flexibility[drive]
        new = np.linalg.solve(matrix, right)
        moved = float(np.max(abs(new - force) / table.scale, initial=0.0))
        force, u = new, free + flexibility @ new
        if moved < 1e-10:
            break
    else:
        raise EquilibriumError(
            f"equilibrium at t = 0 with a mesh at rest: still moves by {moved:.3g} of the force scale after {ROUNDS} "
            "rounds. Give the machine a load, or bearings without clearance."
        )
    for i in resting:
        log[2 * i : 2 * i + 2] = 0.0
    return force, log
