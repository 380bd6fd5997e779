"""Steps `mesh-response` and `mesh-level`: sensor levels that one gear mesh excites, linearised and by the time loop.

At a constant force, and at the tilt of the gears in the loaded machine, the approach e(c) and the moment M_e(c) of the
tooth forces vary with the mesh cycle c. With the means K of the slopes of force and moment over approach and tilt,
F = F_0 + K_11 (delta - e) + K_12 psi and M = M_e + K_21 (delta - e) + K_22 psi. This excites the rows (delta, psi) of
the mesh with

    g = (K_11 e, K_21 e - M_e)

A machine linearised with the slopes K_0 has the receptance R (rows over g). With the slopes K it responds as to
(I + (K - K_0) R)^-1 g. So one linearisation is enough for all modifications and loads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fem.contact.evaluation.mesh_cycle import MeshCycle
from fem.contact.faults.changed_law import modified_law
from fem.contact.law import MeshLaw
from fem.gears.modifications import PairModifications
from mbd.forces.flank import flank_name
from mbd.output.recorder import PASS_SHARE
from mbd.parts.channels import DIRECTIONS, acceleration, sensor_names
from mbd.parts.gear_mesh import mesh_channels
from mbd.parts.speed_drive import SpeedProfile
from pipelines.engine.step import Step
from pipelines.steps.motion import MotionSpec, assembled, moved

if TYPE_CHECKING:
    from fem.casing.reduced.reduced_body import ReducedBody
    from pipelines.machine.machine_model import MachineModel

MOST_ORDERS = 15  # of the mesh frequency, those that 32 positions in the mesh cycle resolve
SETTLING, END = 0.3, 0.6  # s: start and end of the signal of the time loop that is analysed


@dataclass(frozen=True, kw_only=True)
class SteadyMesh:
    """A machine at constant speed and the mesh number `mesh`, from 0, that excites it with `frequencies` (Hz)."""

    motion: MotionSpec
    mesh: int
    frequencies: tuple[float, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class SensorResponse:
    """Response of the linearised machine to the force (N) and the moment (N m) of a mesh, complex.

    tilt : rad per N along the line of action, of the gears by the deflection of the machine under load
    stiffness : (row, row) slopes of the mesh in the linearised machine; the rows are delta (m) and psi (rad)
    receptance : (order, row, row)
    accelerations : (sensor, order, axis, row)
    """

    sensors: tuple[str, ...]
    tilt: float
    stiffness: np.ndarray
    receptance: np.ndarray
    accelerations: np.ndarray

    def levels(self, cycle: MeshCycle, force: float) -> np.ndarray:
        """Root mean square of the acceleration (sensor,), m/s2, of a pair at a force, N."""
        tilt = cycle.tilt + self.tilt * force
        error = cycle.evaluator.approach_at(force, cycle.cycle, tilt, *cycle.teeth)
        found = cycle.evaluator.evaluate(cycle.cycle, error, tilt, *cycle.teeth)
        slopes = [[found.stiffness, found.cross_stiffness], [found.cross_stiffness, found.tilt_stiffness]]
        stiffness = np.mean(slopes, axis=2)
        force = np.outer(stiffness[0], error) - [np.zeros(error.size), found.moment]
        lines = 2 * np.fft.rfft(force)[:, 1 : 1 + len(self.receptance)] / error.size
        change = np.eye(2) + (stiffness - self.stiffness) @ self.receptance
        return _level(self.accelerations @ np.linalg.solve(change, lines.T[..., None]))


def _level(amplitudes: np.ndarray) -> np.ndarray:
    """Root mean square (sensor,) of the sum of all amplitudes (sensor, ...)."""
    return np.sqrt((np.abs(amplitudes) ** 2).reshape(len(amplitudes), -1).sum(axis=1) / 2)


def _axes(names: Sequence[str]) -> list[int]:
    """Numbers of the accelerations along x, y, z of all sensors among channels."""
    return [names.index(acceleration(one, axis)) for one in sensor_names(tuple(names)) for axis in DIRECTIONS]


def build(spec: SteadyMesh, *, body: ReducedBody, laws: Sequence[tuple[MeshLaw, MeshLaw]]) -> SensorResponse:
    """The response of the machine about its loaded equilibrium; arguments as in `pipelines.steps.motion.build`."""
    from mbd.system.frequency_response import frequency_response
    from mbd.system.linearised import tangent
    from mbd.system.statics import equilibrium

    system = assembled(spec.motion, body, laws)
    state = equilibrium(system, system.machine.starting_speed)
    name, names = spec.motion.machine.meshes[spec.mesh].name, system.channels.names
    flank, frequencies = flank_name(name, 0), np.array(spec.frequencies)
    small, rows = tangent(system, state), system.at(flank)
    columns = [frequency_response(system, flank, frequencies, state, row=row) for row in (0, 1)]
    found = np.stack(columns, axis=2)  # (channel, order, row)
    motions = [names.index(one) for one in mesh_channels(name)[:2]]
    axes = found[_axes(names)].reshape(-1, len(DIRECTIONS), *found.shape[1:])
    return SensorResponse(
        sensors=sensor_names(names),
        tilt=float(system.rows[rows][1] @ state.displacement / small.mesh_forces[spec.mesh]),
        stiffness=small.row_stiffness[rows, rows],
        receptance=found[motions].swapaxes(0, 1),
        accelerations=axes.swapaxes(1, 2),
    )


def build_level(
    spec: SteadyMesh,
    modifications: PairModifications,
    *,
    body: ReducedBody,
    laws: Sequence[tuple[MeshLaw, MeshLaw]],
) -> np.ndarray:
    """Root mean square of the acceleration (sensor,), m/s2, at the frequencies of the mesh, by the time loop.

    Parameters
    ----------
    spec, modifications : the machine, and the modifications of the pair of the mesh
    body, laws : as in `pipelines.steps.motion.build`, for the mesh those without modifications
    """
    pair, found = spec.motion.machine.meshes[spec.mesh].pair, list(laws)
    drive, coast = (modified_law(law, pair, modifications) for law in laws[spec.mesh])
    found[spec.mesh] = drive, coast
    motion = moved(assembled(spec.motion, body, found), spec.motion.motion)
    settled = motion.time >= SETTLING
    window = np.hanning(settled.sum())
    waves = np.exp(-2j * np.pi * np.outer(motion.time[settled], spec.frequencies)) * window[:, None]
    lines = 2 * motion.values[_axes(motion.channel_names)][:, settled] @ waves / window.sum()
    return _level(lines.reshape(len(motion.sensors), -1))


def response_step(machine: MachineModel, simulate: Step, stage: int, law: str) -> Step:
    """The step of the response to a mesh.

    Parameters
    ----------
    machine, simulate : the machine, and the step of its motion
    stage, law : number of the stage, from 1, and name of the step of its laws without modifications
    """
    spec, number = simulate.spec, stage - 1
    constant = SpeedProfile(times=np.zeros(1), speeds=np.full(1, machine.facts.motor_speed))
    steady = replace(spec, machine=replace(spec.machine, profile=constant), motion=replace(spec.motion, end=END))
    frequencies = machine.facts.stages[number].mesh_frequency * np.arange(1, MOST_ORDERS + 1)
    passed = frequencies[frequencies <= PASS_SHARE * spec.motion.output_rate]
    laws = [*machine.law_names[:number], law, *machine.law_names[stage:]]
    return Step(
        name="mesh response",
        kind="mesh-response",
        build=build,
        spec=SteadyMesh(motion=steady, mesh=number, frequencies=tuple(passed.tolist())),
        takes={**simulate.takes, "laws": tuple(laws)},
        libraries=simulate.libraries,
        seconds=1.0,
    )


def level_step(response: Step, simulate: Step, name: str, modifications: PairModifications) -> Step:
    """The step of the level of modifications by the time loop.

    Parameters
    ----------
    response, simulate : the step of `response_step`, and that of the motion of the scene
    name, modifications : of the new step
    """
    return replace(
        response,
        name=name,
        kind="mesh-level",
        build=build_level,
        spec={"spec": response.spec, "modifications": modifications},
        modules=simulate.modules,
        seconds=simulate.seconds * END / simulate.spec.motion.end,
    )
