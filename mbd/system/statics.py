"""Equilibrium at t = 0 under the constant loads, with the motors held.

0 = f + B^T lambda(B q) - K q has the rows u = u_0 + G lambda(u) with u_0 = B K^-1 f and G = B K^-1 B^T. The potential
energy is convex, and along a Newton step d of the forces its slope is d^T G (lambda - lambda(u)). A line search ends
each step where this slope is nearly 0, which finds the equilibrium from any start, through any contact that opens or
closes. A shaft whose bearings are all open has no stiffness: K times the residual is added to it (Yamashita & Fukushima
2001, Computing Suppl. 15), so that the last steps are still Newton steps.

Without a load the gears could rest anywhere in the backlash. Contacts without a load are set to just touch,
K q = f + B^T mu with delta = delta_0(c, psi) of a flank. A swinging container is held at its angle by a force
perpendicular to its ropes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbd.elements.element import LARGEST_APPROACH, WIDTH, Contact, Element
from mbd.elements.element_table import Instant, instant, slope_matrix
from mbd.elements.newton import forces_at
from mbd.parts.part_checks import EquilibriumError
from mbd.system.system import System

TOLERANCE = 1e-12
ROUNDS = 100
LONGEST = 1e3  # longest line search, in Newton steps: a body that moves further has no hold
ENOUGH = 0.5  # largest share of the slope of the energy at the end of a line search


@dataclass(frozen=True, eq=False, kw_only=True)
class State:
    """State of the machine at one instant: displacements q (n,), rates (n,), residual forces lambda (m,)."""

    displacement: np.ndarray
    velocity: np.ndarray
    forces: np.ndarray
    motor_angle: float
    motor_speed: float  # rad/s; at rest in the rolling frame
    motor_torque: float  # N m, of all motors referred to the speed of the first, lifting positive
    mesh_force: np.ndarray  # (mesh,) N, drive flank


def equilibrium(system: System, speed: float = 0.0) -> State:
    """State of rest under the constant loads.

    With a motor ``speed`` (rad/s) it is the rest in the frame that rolls, so that the losses oppose the rotation, at
    the mesh cycle and rope length of t = 0.

    Raises
    ------
    EquilibriumError : the load cannot be carried (e.g. too many teeth missing), nothing presses shafts into bearings
        with clearance, or the iteration fails
    """
    response = system.basis / system.frequencies**2 @ system.basis.T  # K^-1 in the space of all forces
    constant = system.constant_force + system.holding_force
    rows = system.all_rows
    m = len(system.rows)
    free = rows @ (response @ constant)
    flexibility = rows @ response @ system.rows.T
    contacts = [_PressedContact(system, sides) for sides in system.contacts.values()]
    resting = [contact for contact in contacts if contact.nominal == 0.0]
    if resting:
        start = np.zeros(m)
        if len(resting) < len(contacts):  # some branches have no load
            _press(contacts, free, flexibility, start)
        forces, now = _touching(system, free, flexibility, speed, resting, start)
    else:
        forces, now = _loaded(system, free, flexibility, speed, contacts)
    q = response @ (constant + system.rows.T @ forces)
    return State(
        displacement=q,
        velocity=np.zeros_like(q),
        forces=forces[:m],
        motor_angle=0.0,
        motor_speed=speed,
        motor_torque=float(system.motor_torque[0] @ q),
        mesh_force=now.elastic[[contact.approaches[0] for contact in contacts]].copy(),
    )


def foot_forces(system: System, state: State) -> np.ndarray:
    """Force (foot, 3) of the ground on the feet of the casing at a state of rest, N; the feet are those of
    `fem.casing.reduced.reduced_body.ReducedBody.feet`."""
    body = system.layout.casing
    return body.foot_forces(state.displacement[system.layout.index("casing")], system.machine.gravity)


class _PressedContact:
    """A contact that holds the train (see `mbd.elements.element.Contact`): rows of the approach on both sides, and the
    approach at which each just touches."""

    def __init__(self, system: System, sides: tuple[Element, ...]) -> None:
        self._system = system
        touching = [(side.contact.side, side) for side in sides if side.contact is not None]
        self.sides = [side for _, side in sorted(touching, key=lambda one: one[0])]
        self.rows = [system.at(side.name) for side in self.sides]
        self.approaches = [rows.start for rows in self.rows]

    @property
    def contacts(self) -> list[Contact]:
        """Contact of each side."""
        return [side.contact for side in self.sides if side.contact is not None]

    @property
    def nominal(self) -> float:
        """Nominal force, N."""
        return self.contacts[0].nominal

    def touching(self, side: int, motion: np.ndarray, rows: np.ndarray) -> float:
        """Displacement of the first row of a side at which it just touches, from the displacements (row + observed,) of
        all rows, and those (n,) of the side."""
        observed = self._system.observed_by(self.sides[side].name, motion)
        return self.contacts[side].touching(observed, rows)


def _press(contacts: list[_PressedContact], free: np.ndarray, flexibility: np.ndarray, force: np.ndarray) -> None:
    """Set the forces on the loaded sides so that all of them are well in contact: an open contact leaves the train
    without a hold, and Newton's method for a convex force converges from the side of too much contact."""
    rows, goal = [], []
    for contact in contacts:
        side = int(contact.nominal < 0.0)  # side 1: the driven gear pushes the driving one
        own = contact.rows[side]
        stiffness = contact.sides[0].stiffness[0]
        rows.append(own.start)
        straight = np.zeros(own.stop - own.start)
        goal.append(contact.touching(side, free, straight) + 4 * abs(contact.nominal) / stiffness)
    at = np.array(rows, dtype=int)
    force[at] = np.linalg.solve(flexibility[np.ix_(at, at)], np.array(goal) - free[at])


def _loaded(
    system: System, free: np.ndarray, flexibility: np.ndarray, speed: float, contacts: list[_PressedContact]
) -> tuple[np.ndarray, Instant]:  # fmt: skip
    force = np.concatenate([np.zeros(0), *(element.reference("guess") for element in system.elements)])
    now = instant(system.table)
    _press(contacts, free, flexibility, force)
    found, u, left = _settled(system, speed, free, flexibility, force, now)
    opened = float(abs(u[[contact.approaches[0] for contact in contacts]]).max(initial=0.0))
    if not (left <= TOLERANCE and opened < LARGEST_APPROACH):
        loads = ", ".join(f"{contact.contacts[0].name} {contact.nominal:.4g} N" for contact in contacts)
        raise EquilibriumError(
            f"equilibrium at t = 0: not found within {LARGEST_APPROACH * 1e3:g} mm (nominal mesh forces: {loads}). "
            "Lower the load, or start where teeth are in mesh (stages.cycle_at_start)."
        )
    return found, now


def _settled(
    system: System, speed: float, free: np.ndarray, flexibility: np.ndarray, force: np.ndarray, now: Instant
) -> tuple[np.ndarray, np.ndarray, float]:
    """Forces (m,) of the equilibrium, all displacements (row + observed,), and the residual in units of the scales.

    Parameters
    ----------
    system, speed, free, flexibility : the machine, its rolling, u_0 and G, with the observed rows below
    force : (m,) start
    now : out: answers of the elements
    """
    table, m, nothing = system.table, len(system.rows), np.empty((0, WIDTH))
    target, still, along = np.empty(m), np.zeros(m), flexibility[:m]
    slope_u, slope_v = np.empty((m, WIDTH)), np.empty((m, WIDTH))

    def residual(forces: np.ndarray) -> np.ndarray:
        forces_at(table, (0.0, speed, 0.0), free + flexibility @ forces, still, still[:0], nothing, target, slope_u,
                  slope_v, now)  # fmt: skip
        return forces - target

    rest = residual(force)
    left = np.abs(rest / table.scale).max(initial=0.0)
    for _ in range(ROUNDS):
        if left <= TOLERANCE:
            break
        step = np.linalg.solve((1.0 + left) * np.eye(m) - slope_matrix(slope_u, table) @ along, -rest)
        push, low, high, part = along @ step, 0.0, np.inf, 1.0
        falls = push @ rest
        for _ in range(ROUNDS):
            rest = residual(force + part * step)
            left = np.abs(rest / table.scale).max()
            if abs(push @ rest) <= ENOUGH * abs(falls) or left <= TOLERANCE or part > LONGEST:
                break
            low, high = (part, high) if (push @ rest) * falls > 0.0 else (low, part)
            part = 0.5 * (low + high) if high < np.inf else 2.0 * part
        force = force + part * step
    return force, free + flexibility @ force, float(left)


def _touching(
    system: System, free: np.ndarray, flexibility: np.ndarray, speed: float, resting: list[_PressedContact],
    start: np.ndarray,
) -> tuple[np.ndarray, Instant]:  # fmt: skip
    """Forces with which the linear reference holds the first sides of the ``resting`` contacts where they just touch:
    with them the real force is zero.

    Without contact lambda = k0 u cancels the reference on all rows but the first, whose lambda fixes the approach; the
    forces of all other rows follow from Newton's method (from ``start``).
    """
    table, m = system.table, len(system.rows)
    first = [contact.approaches[0] for contact in resting]
    others = np.array([row for contact in resting for row in range(contact.rows[0].start + 1, contact.rows[0].stop)])
    force, still = start.copy(), np.zeros(m)
    u = free + flexibility @ force
    now = instant(table)
    for _ in range(ROUNDS):
        right, slope_u, slope_v = np.zeros(m), np.zeros((m, WIDTH)), np.zeros((m, WIDTH))
        forces_at(table, (0.0, speed, 0.0), u, still, u[:0], slope_u[:0], right, slope_u, slope_v, now)
        slope = slope_matrix(slope_u, table)
        slope[first], slope[others] = 0.0, 0.0
        slope[others, others] = table.stiffness[others]
        right[others] = table.stiffness[others] * u[others]
        right += slope @ (free[:m] - u[:m])
        matrix = np.eye(m) - slope @ flexibility[:m]
        for contact in resting:
            row = contact.approaches[0]
            try:
                right[row] = -free[row] + contact.touching(0, u, u[contact.rows[0]])
            except EquilibriumError as error:
                raise _unheld(system, contact, str(error)) from error
        matrix[first] = flexibility[first]
        new = np.linalg.solve(matrix, right)
        moved = float(np.max(abs(new - force) / table.scale, initial=0.0))
        force, u = new, free + flexibility @ new
        if moved < 1e-10:
            break
    else:
        reason = f"still moves by {moved:.3g} of the force scale after {ROUNDS} rounds"
        raise _unheld(system, resting[0], f"{reason}. Give the machine a load.")
    for contact in resting:
        for rows in contact.rows:
            now.elastic[rows] = 0.0
    return force, now


def _unheld(system: System, contact: _PressedContact, reason: str) -> EquilibriumError:
    """Error that gives the reason why a contact without load has no position, e.g. bearings within their clearance."""
    name = f"equilibrium at t = 0: {contact.contacts[0].name} carries {contact.nominal:g} N"
    loose = [bearing.name for bearing in system.machine.bearings if bearing.inside is not None]
    if not loose:
        return EquilibriumError(f"{name}: {reason}")
    return EquilibriumError(
        f"{name}, so nothing presses the shafts against the rolling elements of {', '.join(loose)}, and within their "
        "clearance the gears may rest anywhere. Give the machine a load, or these bearings no radial clearance or a "
        "preload."
    )
