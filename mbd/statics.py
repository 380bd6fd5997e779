"""Equilibrium at t = 0: the load hangs, the motors hold.

0 = f + B^T lambda(B q) - K q has the rows u = B K^-1 f + (B K^-1 B^T) lambda(u): the Newton iteration of the time step
with static flexibilities. With no load at all the gears could rest anywhere in the backlash; the drive flanks are then
set to just touch, K q = f + B^T mu with delta = delta_0(c, psi).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbd.checks import EquilibriumError
from mbd.forces import LOG_COLUMNS
from mbd.load import StaticTorque
from mbd.mesh_reference import LARGEST_APPROACH, nominal_forces, touching_approach
from mbd.rows_solver import solve_rows
from mbd.system import System

TOLERANCE = 1e-12


@dataclass(frozen=True, eq=False, kw_only=True)
class State:
    """Where the machine is at one instant: displacements q (n,), rates (n,), residual forces lambda (m,)."""

    displacement: np.ndarray
    velocity: np.ndarray
    forces: np.ndarray
    motor_angle: float
    motor_torque: float  # N m, all motors, lifting positive
    mesh_force: np.ndarray  # (mesh,) N, drive flank


def equilibrium(system: System) -> State:
    """State of rest under the constant loads.

    Raises
    ------
    EquilibriumError : the load cannot be carried (e.g. too many teeth missing), or the iteration fails
    """
    response = system.basis / system.frequencies**2 @ system.basis.T  # K^-1 on everything that can act
    rows = system.all_rows
    m = len(system.rows)
    free = rows @ (response @ system.constant_force)
    flexibility = rows @ response @ system.rows.T
    if isinstance(system.machine.load, StaticTorque) and system.machine.load.torque == 0.0:
        forces, log = _touching(system, free, flexibility)
    else:
        forces, log = _loaded(system, free, flexibility)
    q = response @ (system.constant_force + system.rows.T @ forces)
    torque = sum(-c.stiffness * float(system.layout.angle_row(c.shaft, c.y) @ q) for c in system.machine.couplings)
    return State(
        displacement=q,
        velocity=np.zeros_like(q),
        forces=forces[:m],
        motor_angle=0.0,
        motor_torque=torque,
        mesh_force=log[: 2 * len(system.machine.meshes) : 2, 0].copy(),
    )


def _loaded(system: System, free: np.ndarray, flexibility: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    m, n_elements = len(system.rows), len(system.table.tau) + len(system.table.rope_ea)
    force, log = np.zeros(m), np.zeros((n_elements, len(LOG_COLUMNS)))
    u, v, still = np.zeros(len(free)), np.zeros(len(free)), np.zeros(len(free))
    drive = np.arange(len(system.machine.meshes)) * 4
    force[drive] = np.linalg.solve(flexibility[np.ix_(drive, drive)], _pressed(system, free) - free[drive])
    used = solve_rows(
        system.table, 0.0, 0.0, free, still, flexibility, np.zeros_like(flexibility), force, u, v, log, TOLERANCE
    )
    opened = float(abs(u[: 4 * len(system.machine.meshes) : 4]).max(initial=0.0))
    if used < 0 or not opened < LARGEST_APPROACH:
        loads = ", ".join(f"{name} {value:.4g} N" for name, value in nominal_forces(system.machine).items())
        raise EquilibriumError(
            f"equilibrium at t = 0: not found within {LARGEST_APPROACH * 1e3:g} mm (nominal mesh forces: {loads}). "
            "Lower the load, or start where teeth are in mesh (mesh phase at the start)."
        )
    return force, log


def _pressed(system: System, free: np.ndarray) -> np.ndarray:
    """Approaches (mesh,) with every drive flank well in contact: an open flank leaves the train without a hold, and a
    convex force law is found safely from the side of too much contact."""
    table, loads = system.table, nominal_forces(system.machine)
    found = []
    for i, mesh in enumerate(system.machine.meshes):
        cycle = table.cycle_start[i] + table.cycle_rate[i] * free[len(system.rows) + i]
        touch = touching_approach(mesh.drive, cycle, mesh.drive_clearance_pinion, mesh.drive_clearance_wheel, 0.0)
        found.append(touch + 4 * abs(loads[mesh.name]) / table.stiffness[2 * i, 0])
    return np.array(found)


def _touching(system: System, free: np.ndarray, flexibility: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forces that the linear reference needs to hold every drive flank at delta_0: with them the real force is zero."""
    machine, table, m = system.machine, system.table, len(system.rows)
    drive = np.arange(len(machine.meshes)) * 4
    force, u = np.zeros(m), free.copy()
    for _ in range(20):
        target = np.zeros(len(drive))
        for i, mesh in enumerate(machine.meshes):
            cycle = table.cycle_start[i] + table.cycle_rate[i] * u[m + i]
            target[i] = touching_approach(
                mesh.drive, cycle, mesh.drive_clearance_pinion, mesh.drive_clearance_wheel, u[drive[i] + 1]
            )
        # without contact lambda_psi = k_psi psi cancels the tilt reference, lambda_delta holds the approach
        active = np.concatenate([drive, drive + 1])
        reference = np.concatenate([np.zeros(len(drive)), table.stiffness[::2, 1]])
        goal = np.concatenate([target, np.zeros(len(drive))])
        matrix = flexibility[np.ix_(active, active)].copy()
        matrix[len(drive) :] = reference[len(drive) :, None] * matrix[len(drive) :] - np.eye(len(active))[len(drive) :]
        right = np.where(reference > 0, -reference * free[active], goal - free[active])
        new = np.zeros(m)
        new[active] = np.linalg.solve(matrix, right)
        moved = float(np.max(abs(new - force) / table.scale, initial=0.0))
        force, u = new, free + flexibility @ new
        if moved < 1e-10:
            break
    log = np.zeros((len(table.tau), len(LOG_COLUMNS)))
    return force, log
