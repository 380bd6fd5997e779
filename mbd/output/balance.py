"""Energy balance: stored, dissipated and received energy of every part, and the residual.

residual = received + parametric - change of stored energy - dissipated.

The balances of the parts (`mbd.output.linear_energy`, `mbd.output.element_energy`) refer to the frame that rolls
with the train, where the inertia force of a speed ramp counts as received. The total refers to the real motion
R phi_m + q: it receives the works of motors, gravity and drum torque, and the parametric works.
"""

from __future__ import annotations

import numpy as np

from mbd.integrators.base import ACCELERATION, ANGLE, SPEED, Block, Integrator
from mbd.output.element_energy import ElementWork
from mbd.output.linear_energy import LinearWork
from mbd.system.system import System

ENERGY_ENTRIES = ("stored", "dissipated", "received", "parametric", "residual", "scale")


class EnergyBalance:
    """Accumulates the energies of a run of at least ``n_steps`` steps; it needs exactly ``steps`` of them."""

    def __init__(self, system: System, integrator: Integrator, step: float, n_steps: int) -> None:
        self._system = system
        massive = [part for part in system.parts if part.is_massive]
        inertia = [part.mass @ system.rolling[part.index] @ integrator.displacement[part.index] for part in massive]
        torque = system.motor_torque[0] @ integrator.displacement + system.motor_torque[1] @ integrator.velocity
        self._linear = LinearWork(system, integrator, step, n_steps, torque)
        self.elements, self.steps = ElementWork(system), self._linear.steps
        self._watch = np.array([*inertia, torque, system.constant_force @ integrator.displacement])
        self._watched, self._angle = np.zeros(len(self._watch)), 0.0
        self._ramp_work = dict.fromkeys([part.name for part in massive], 0.0)
        self._constant_work, self._throughput = 0.0, 0.0
        self._speeds = (0.0, 0.0)  # speed of the frame at the start and at the last instant

    def take(self, block: Block, first: int) -> None:
        """Add a block; ``first`` is its first instant, counted in steps since the start."""
        angles, accelerations = block.clock[:, ANGLE], block.clock[:, ACCELERATION]
        self._linear.take(block, first)
        self.elements.take(block)
        watched = block.states @ self._watch.T
        if first == 0:
            self._watched, self._angle = watched[0], angles[0]
        watched, turned = np.vstack([self._watched, watched]), np.diff(angles, prepend=self._angle)
        change = np.diff(watched, axis=0)
        for k, name in enumerate(self._ramp_work):
            self._ramp_work[name] -= float(accelerations @ change[:, k])
        motor = 0.5 * (watched[1:, -2] + watched[:-1, -2]) * turned
        constant = change[:, -1] + self._system.constant_force @ self._system.rolling * turned
        self._constant_work += float(constant.sum())
        self._throughput += float(abs(motor).sum() + abs(constant).sum())
        self._watched, self._angle = watched[-1], angles[-1]
        self._speeds = (block.clock[0, SPEED] if first == 0 else self._speeds[0], block.clock[-1, SPEED])

    def table(self) -> tuple[tuple[str, ...], np.ndarray]:
        """Part names and ENERGY_ENTRIES (part, entry) in J.

        ``scale`` is the energy with which the residual is compared: the dissipated energy of the part (its peak stored
        energy if undamped), all work of the sources for the total.
        """
        linear, motor_work = self._linear.entries(self._ramp_work)
        rows = linear | self.elements.entries()
        parts = np.array(list(rows.values()))
        stored = float(parts[:, 0].sum()) + self._rigid_energy()
        dissipated, parametric = float(parts[:, 1].sum()), float(parts[:, 3].sum())
        received = motor_work + self._constant_work
        residual = received + parametric - stored - dissipated
        scale = self._throughput + self.elements.throughput
        rows["total"] = [stored, dissipated, received, parametric, residual, scale]
        return tuple(rows), np.array(list(rows.values()))

    def _rigid_energy(self) -> float:
        """Change of (phi' R)^T M v + phi'^2 R^T M R/2, the kinetic energy that the rolling frame does not contain."""
        rolling, linear = self._system.rolling, self._linear
        momentum = rolling @ self._system.mass
        energies = [
            speed * float(momentum @ (linear.to_v @ x) + 0.5 * speed * momentum @ rolling)
            for speed, x in zip(self._speeds, (linear.origin, linear.latest), strict=True)
        ]
        return energies[1] - energies[0]
