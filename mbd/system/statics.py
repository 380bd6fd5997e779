"""Equilibrium at t = 0: the load hangs, the motors hold.

0 = f + B^T lambda(B q) - K q has the rows u = B K^-1 f + (B K^-1 B^T) lambda(u): the Newton iteration of the time step
with static flexibilities. With no load at all the gears could rest anywhere in the backlash; the drive flanks are then
set to just touch, K q = f + B^T mu with delta = delta_0(c, psi). A swinging container is held at its angle by a force
square to its ropes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbd.forces.element import WIDTH
from mbd.forces.flank import flank_name, no_load_approach
from mbd.forces.newton import forces_at, solve_rows
from mbd.forces.table import Instant, instant, slope_matrix
from mbd.parts.checks import EquilibriumError
from mbd.parts.mesh_reference import LARGEST_APPROACH, nominal_forces
from mbd.system.system import System

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
    constant = system.constant_force + system.machine.load.holding_force(system.layout)
    rows = system.all_rows
    m = len(system.rows)
    free = rows @ (response @ constant)
    flexibility = rows @ response @ system.rows.T
    carried = list(nominal_forces(system.machine).values())
    if system.machine.load.idle:
        forces, now = _touching(system, free, flexibility, speed, np.arange(len(carried)), np.zeros(m))
    elif 0.0 in carried:  # branches that carry nothing
        start, (at, goal) = np.zeros(m), _pressed(system, free)
        start[at] = np.linalg.solve(flexibility[np.ix_(at, at)], goal - free[at])
        resting = np.flatnonzero(np.array(carried) == 0.0)
        forces, now = _touching(system, free, flexibility, speed, resting, start)
    else:
        forces, now = _loaded(system, free, flexibility, speed)
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
        mesh_force=now.elastic[[row for row, _ in _approaches(system)]].copy(),
    )


def _approaches(system: System) -> list[tuple[int, int]]:
    """Rows of the approach on drive and coast flank of every mesh."""
    return [
        (system.at(flank_name(mesh.name, 0)).start, system.at(flank_name(mesh.name, 1)).start)
        for mesh in system.machine.meshes
    ]


def _loaded(
    system: System, free: np.ndarray, flexibility: np.ndarray, speed: float
) -> tuple[np.ndarray, Instant]:  # fmt: skip
    force = np.concatenate([np.zeros(0), *(element.reference("guess") for element in system.elements)])
    now, m = instant(system.table), len(system.rows)
    u, v, still = np.zeros(len(free)), np.zeros(m), np.zeros(m)
    at, goal = _pressed(system, free)
    force[at] = np.linalg.solve(flexibility[np.ix_(at, at)], goal - free[at])
    used = solve_rows(
        system.table, (0.0, speed, 0.0), free, still, flexibility, np.zeros((m, m)), force, u, v, now, TOLERANCE
    )
    opened = float(abs(u[[drive for drive, _ in _approaches(system)]]).max(initial=0.0))
    if used < 0 or not opened < LARGEST_APPROACH:
        loads = ", ".join(f"{name} {value:.4g} N" for name, value in nominal_forces(system.machine).items())
        raise EquilibriumError(
            f"equilibrium at t = 0: not found within {LARGEST_APPROACH * 1e3:g} mm (nominal mesh forces: {loads}). "
            "Lower the load, or start where teeth are in mesh (mesh phase at the start)."
        )
    return force, now


def _pressed(system: System, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows (mesh,) of the loaded flanks and approaches with all of them well in contact: an open flank leaves the train
    without a hold, and a convex force law is found safely from the side of too much contact."""
    loads = nominal_forces(system.machine)
    rows, found = [], []
    for mesh, approaches in zip(system.machine.meshes, _approaches(system), strict=True):
        load = loads[mesh.name]
        side = int(load < 0.0)  # on the coast flank the driven gear pushes the driving one
        rotation = float(system.observed_by(flank_name(mesh.name, 0), free)[0])
        stiffness = system.table.stiffness[approaches[0]]
        rows.append(approaches[side])
        found.append(no_load_approach(mesh, side, rotation) + 4 * abs(load) / stiffness)
    return np.array(rows, dtype=int), np.array(found)


def _touching(
    system: System, free: np.ndarray, flexibility: np.ndarray, speed: float, resting: np.ndarray, start: np.ndarray
) -> tuple[np.ndarray, Instant]:
    """Forces that the linear reference needs to hold the drive flanks of the ``resting`` meshes at delta_0: with them
    the real force is zero.

    Without contact lambda_psi = k_psi psi cancels the tilt reference and lambda_delta holds the approach; all other
    rows carry their own forces (Newton from ``start``).
    """
    machine, table, m = system.machine, system.table, len(system.rows)
    drive = np.array([row for row, _ in _approaches(system)], dtype=int)[resting]
    force, still = start.copy(), np.zeros(m)
    u = free + flexibility @ force
    now = instant(table)
    for _ in range(ROUNDS):
        right, slope_u, slope_v = np.zeros(m), np.zeros((m, WIDTH)), np.zeros((m, WIDTH))
        forces_at(table, (0.0, speed, 0.0), u, still, u[:0], slope_u[:0], right, slope_u, slope_v, now)
        slope = slope_matrix(slope_u, table)
        slope[drive], slope[drive + 1] = 0.0, 0.0
        slope[drive + 1, drive + 1] = table.stiffness[drive + 1]
        right[drive + 1] = table.stiffness[drive + 1] * u[drive + 1]
        right += slope @ (free[:m] - u[:m])
        matrix = np.eye(m) - slope @ flexibility[:m]
        for i, row in zip(resting, drive, strict=True):
            mesh = machine.meshes[i]
            rotation = float(system.observed_by(flank_name(mesh.name, 0), u)[0])
            right[row] = -free[row] + no_load_approach(mesh, 0, rotation, u[row + 1])
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
        for side in (0, 1):
            at = system.at(flank_name(machine.meshes[i].name, side))
            now.elastic[at] = 0.0
    return force, now
