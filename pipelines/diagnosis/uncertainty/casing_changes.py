"""Acceleration at a sensor on other casings, from the forces of the bearings in a finished run.

With the forces F of the run at one frequency, the receptance Y of its casing between the seats and the dynamic
stiffness P of the machine (`mbd.system.blocked_forces`), the blocked forces are f = (I + P Y) F. On another casing with
the modes (omega', zeta') of shapes U Q, all in the near modes U of the first one, and a flexibility R of all above,

    (Q diag(omega'^2 - omega^2 + 2i zeta' omega' omega) Q^T + U^T C P U) eta = U^T C f,    C = (I + P R)^-1
    F' = C (f - P U eta),    a' = -omega^2 (S U eta + S R F')

which takes an equation of as many unknowns as there are near modes for each casing. R = R_0 + s R_1 of a casing whose
modes above are stiffer by s, and everything that follows from R, is taken to the first order in s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.casing.uncertainty.draws import CasingDraws, undrawn
from fem.casing.uncertainty.modal_form import ModalForm
from mbd.system.blocked_forces import MachineAtSeats, blocked_forces


@dataclass(frozen=True, eq=False, kw_only=True)
class CasingPath:
    """From the bearings through a casing to a sensor."""

    form: ModalForm
    near: int  # modes that draws change one by one
    machine: MachineAtSeats
    sensor: np.ndarray  # S (axis, coordinate)
    forced: np.ndarray  # (force, coordinate) rows on which the known forces of the bearings act

    def accelerations(self, frequency: float, forces: np.ndarray, draws: CasingDraws) -> tuple[np.ndarray, np.ndarray]:
        """Complex amplitudes at the sensor on the casing itself (axis,) and on drawn ones (draw, axis), m/s2.

        Parameters
        ----------
        frequency : Hz
        forces : (force,), N, complex amplitudes of the bearings on the casing itself
        draws : other casings
        """
        omega, seats, near = 2.0 * math.pi * frequency, self.machine.seats, self.near
        stiffness, flanks = self.machine.at(omega)
        known = abs(self.forced[:, seats]).max(axis=0, initial=0.0) > 0.0
        rows, read = self.form.shapes[seats], self.sensor @ self.form.shapes
        above, slope = self._above(omega)
        rest, rest_slope = ((rows[:, near:] * part) @ rows[:, near:].T for part in (above, slope))
        to_sensor, to_sensor_slope = ((read[:, near:] * part) @ rows[:, near:].T for part in (above, slope))
        shapes, seen = rows[:, :near], read[:, :near]
        own = rest + (shapes / self._near(omega, undrawn(self.form, near))[0]) @ shapes.T
        blocked = blocked_forces(stiffness, own, (self.forced.T @ forces)[seats], known, flanks)
        # the columns of `taken` are C f and C P U, those of `taken_slope` their derivatives by s
        taken = np.linalg.solve(np.eye(len(seats)) + stiffness @ rest, np.column_stack([blocked, stiffness @ shapes]))
        taken_slope = -np.linalg.solve(np.eye(len(seats)) + stiffness @ rest, stiffness @ rest_slope @ taken)
        pushed = shapes.T @ taken, shapes.T @ taken_slope
        sensed = to_sensor @ taken, to_sensor_slope @ taken + to_sensor @ taken_slope

        def found(some: CasingDraws) -> np.ndarray:
            at = some.stiffening[:, None, None]
            push, sense = (value + at * by_s for value, by_s in (pushed, sensed))
            held = (some.turns * self._near(omega, some)[:, None, :]) @ some.turns.transpose(0, 2, 1)
            eta = np.linalg.solve(held + push[..., 1:], push[..., :1])
            return -(omega**2) * (sense[..., :1] + (seen - sense[..., 1:]) @ eta)[..., 0]

        return found(undrawn(self.form, near))[0], found(draws)

    def _near(self, omega: float, draws: CasingDraws) -> np.ndarray:
        """Dynamic stiffness (draw, near) of the modes that are drawn."""
        damped = 2j * omega * np.outer(draws.damping, self.form.ratios[: self.near]) * np.sqrt(draws.squares)
        return draws.squares - omega**2 + damped

    def _above(self, omega: float) -> tuple[np.ndarray, np.ndarray]:
        """Flexibility (mode,) of the modes above, and its derivative by what they are stiffer."""
        squares, ratios = self.form.squares[self.near :], self.form.ratios[self.near :]
        flexible = 1.0 / (squares - omega**2 + 2j * omega * ratios * np.sqrt(squares))
        return flexible, -squares * flexible**2
