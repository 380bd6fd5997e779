"""Acceleration at a sensor on sampled casings, from the bearing forces of a finished run.

At one frequency, F are the bearing forces of the run, Y is the receptance of its casing between the bearing seats, and
P is the dynamic stiffness of the machine. The blocked forces (`mbd.system.blocked_forces`) are then f = (I + P Y) F.

A sampled casing has the modes (omega', zeta') of shapes U Q, where U holds the near modes of the nominal casing. All
higher modes contribute only their flexibility R. The response eta of the near modes, the bearing forces F' and the
acceleration a' at the sensor S follow from

    (Q diag(omega'^2 - omega^2 + 2i zeta' omega' omega) Q^T + U^T C P U) eta = U^T C f,    C = (I + P R)^-1
    F' = C (f - P U eta),    a' = -omega^2 (S U eta + S R F')

Each casing thus needs one linear system with as many unknowns as there are near modes. If the higher modes are stiffer
by the relative amount s, then R = R_0 + s R_1; R and all that depends on it are linearised in s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.casing.uncertainty.casing_samples import CasingSamples, nominal_samples
from fem.casing.uncertainty.modal_form import ModalForm
from mbd.system.blocked_forces import MachineAtSeats, blocked_forces


@dataclass(frozen=True, eq=False, kw_only=True)
class CasingPath:
    """Transfer path from the bearings through a casing to a sensor."""

    form: ModalForm
    near: int  # number of individually sampled modes, the lowest ones
    machine: MachineAtSeats
    sensor: np.ndarray  # S (axis, coordinate)
    forced: np.ndarray  # (force, coordinate) rows on which the known forces of the bearings act

    def accelerations(
        self, frequency: float, forces: np.ndarray, casings: CasingSamples
    ) -> tuple[np.ndarray, np.ndarray]:
        """Complex amplitudes (m/s2) at the sensor on the nominal casing (axis,) and on sampled ones (sample, axis).

        Parameters
        ----------
        frequency : Hz
        forces : (force,), N, complex amplitudes of the bearing forces on the nominal casing
        casings : sampled casings
        """
        omega, seats, near = 2.0 * math.pi * frequency, self.machine.seats, self.near
        stiffness, flanks = self.machine.at(omega)
        known = abs(self.forced[:, seats]).max(axis=0, initial=0.0) > 0.0
        rows, read = self.form.shapes[seats], self.sensor @ self.form.shapes
        above, slope = self._above(omega)
        rest, rest_slope = ((rows[:, near:] * part) @ rows[:, near:].T for part in (above, slope))
        to_sensor, to_sensor_slope = ((read[:, near:] * part) @ rows[:, near:].T for part in (above, slope))
        shapes, seen = rows[:, :near], read[:, :near]
        own = rest + (shapes / self._near(omega, nominal_samples(self.form, near))[0]) @ shapes.T
        blocked = blocked_forces(stiffness, own, (self.forced.T @ forces)[seats], known, flanks)
        # the columns of `taken` are C f and C P U, those of `taken_slope` their derivatives with respect to s
        taken = np.linalg.solve(np.eye(len(seats)) + stiffness @ rest, np.column_stack([blocked, stiffness @ shapes]))
        taken_slope = -np.linalg.solve(np.eye(len(seats)) + stiffness @ rest, stiffness @ rest_slope @ taken)
        pushed = shapes.T @ taken, shapes.T @ taken_slope
        sensed = to_sensor @ taken, to_sensor_slope @ taken + to_sensor @ taken_slope

        def found(some: CasingSamples) -> np.ndarray:
            at = some.stiffening[:, None, None]
            push, sense = (value + at * by_s for value, by_s in (pushed, sensed))
            held = (some.turns * self._near(omega, some)[:, None, :]) @ some.turns.transpose(0, 2, 1)
            eta = np.linalg.solve(held + push[..., 1:], push[..., :1])
            return -(omega**2) * (sense[..., :1] + (seen - sense[..., 1:]) @ eta)[..., 0]

        return found(nominal_samples(self.form, near))[0], found(casings)

    def _near(self, omega: float, casings: CasingSamples) -> np.ndarray:
        """Dynamic stiffness (sample, near) of the sampled modes."""
        damped = 2j * omega * np.outer(casings.damping, self.form.ratios[: self.near]) * np.sqrt(casings.squares)
        return casings.squares - omega**2 + damped

    def _above(self, omega: float) -> tuple[np.ndarray, np.ndarray]:
        """Flexibility (mode,) of the higher modes, and its derivative with respect to s."""
        squares, ratios = self.form.squares[self.near :], self.form.ratios[self.near :]
        flexible = 1.0 / (squares - omega**2 + 2j * omega * ratios * np.sqrt(squares))
        return flexible, -squares * flexible**2
