"""Works of the linear parts.

Parts with mass touch only through ports: rows B with the forces f = K B q + C B q' of massless parts and
f = k0 B q + c0 B q' - lambda of nonlinear elements. The integrals of f v^T and v v^T give the work of every port on
every part and the dissipation v^T C v of every part. They are exact for an integrator with a `Flow`
(`mbd.output.exact_integrals`), sums over the instants for the others (`mbd.output.sampled_integrals`).
"""

from __future__ import annotations

import itertools

import numpy as np

from mbd.elements.linear_part import Part
from mbd.integrators.base import Block, Integrator
from mbd.output.exact_integrals import FlowWork
from mbd.output.sampled_integrals import SampledWork
from mbd.system.system import System


class LinearWork:
    """Accumulates blocks of a run of at least ``n_steps`` steps; it must be fed exactly ``steps`` of them.

    ``torque`` (state,) is the row of the motors' torque, for their work on the rolling train.
    """

    def __init__(self, system: System, integrator: Integrator, step: float, n_steps: int, torque: np.ndarray) -> None:
        self._system, self._torque = system, torque
        self.to_q, self.to_v = integrator.displacement, integrator.velocity
        self._turn = -integrator.inverse_mass @ (system.mass @ system.rolling)
        self._massless = [(part, part.rows(system.layout.size)) for part in system.parts if not part.is_massive]
        self._ports = np.vstack([system.rows, *(rows for _, rows in self._massless)])
        table = system.table
        self._to_force = np.vstack(
            [
                table.stiffness[:, None] * (system.rows @ self.to_q)
                + table.damping[:, None] * (system.rows @ self.to_v),
                *(
                    part.own("stiffness") @ (rows @ self.to_q) + part.own("damping") @ (rows @ self.to_v)
                    for part, rows in self._massless
                ),
            ]
        )
        self._integrals: FlowWork | SampledWork
        if integrator.flow is None:
            self._integrals = SampledWork(step, n_steps, self._to_force, len(system.rows), torque)
        else:
            self._integrals = FlowWork(integrator.flow, n_steps)
        self.steps = self._integrals.steps
        self.origin, self.latest = np.zeros(self.to_q.shape[1]), np.zeros(self.to_q.shape[1])
        self._peak = {part.name: 0.0 for part in system.parts if not part.damping.any()}

    def take(self, block: Block, first: int) -> None:
        """Add a block; ``first`` is its first instant, counted in steps since the start."""
        self._integrals.take(block, first)
        if first == 0:
            self.origin = block.states[0].copy()
        self.latest = block.states[-1].copy()
        for part in self._system.parts:
            if part.name in self._peak:
                self._peak[part.name] = max(self._peak[part.name], self._energy(part, self.latest))

    def entries(self, ramp_work: dict[str, float]) -> tuple[dict[str, list[float]], float]:
        """Stored, dissipated, received, parametric (0), residual, scale of every part, and the motors' work, J."""
        system, moved = self._system, self.to_q @ (self.latest - self.origin)
        if isinstance(self._integrals, SampledWork):
            port_work, velocity = self._integrals.integrals(self.latest, self.to_q, self.to_v, self._turn)
            motor_work = self._integrals.motor_work
        else:
            pushed, second = self._integrals.integrals()
            mixed = second @ self.to_v.T
            port_work, velocity = self._to_force @ mixed, self.to_v @ mixed
            motor_work = float(pushed[-1] @ self._torque)
            port_work[: len(system.rows)] -= pushed[: len(system.rows)] @ self.to_v.T
            if system.frame.free:
                ramp_work = self._free_ramp_work(moved, pushed)
        work = self._ports * port_work  # (port, coordinate) that the motion of each coordinate does against each port
        rows: dict[str, list[float]] = {}
        ends = np.cumsum([len(system.rows), *(len(own) for _, own in self._massless)])
        ports = {part.name: slice(*at) for (part, _), at in zip(self._massless, itertools.pairwise(ends), strict=True)}
        for part in system.parts:
            i = part.index
            if part.is_massive:
                received = ramp_work[part.name] + float(moved[i] @ system.constant_force[i] - work[:, i].sum())
            else:
                received = float(work[ports[part.name]].sum())
            dissipated = part.dissipated(velocity[np.ix_(i, i)])
            change = self._energy(part, self.latest) - self._energy(part, self.origin)
            scale = self._peak.get(part.name, dissipated)
            rows[part.name] = [change, dissipated, received, 0.0, received - change - dissipated, scale]
        return rows, motor_work

    def _free_ramp_work(self, moved: np.ndarray, pushed: np.ndarray) -> dict[str, float]:
        """Work (J) of the inertia forces of a free frame on every part, exact: phi'' = load + push . lambda.

        ``moved`` (coordinate,) is the change of the displacements, ``pushed`` as of `FlowWork.integrals`.
        """
        frame = self._system.frame
        motion = frame.load * moved + frame.push @ (pushed[: len(frame.push)] @ self.to_v.T)
        massive = [part for part in self._system.parts if part.is_massive]
        return {p.name: -float(p.mass @ self._system.rolling[p.index] @ motion[p.index]) for p in massive}

    def _energy(self, part: Part, state: np.ndarray) -> float:
        """Kinetic and strain energy of a linear part."""
        return part.stored(self.to_q[part.index] @ state, self.to_v[part.index] @ state)
