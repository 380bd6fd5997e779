"""Simulation of a machine: time integration from equilibrium over the speed profile; the result is a `Trajectory`."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from fem.storage.large_array_file import StoredArray
from mbd.forces.torque_source import TorqueSource
from mbd.integrators.base import ANGLE, LENGTH, Block, Integrator
from mbd.integrators.methods import make_integrator
from mbd.integrators.settings import MotionSettings
from mbd.output.balance import ENERGY_ENTRIES, EnergyBalance
from mbd.output.recorder import PASS_SHARE, Recorder
from mbd.output.repeatability import Repeatability
from mbd.output.step_error import StepCheck
from mbd.output.trajectory import Trajectory
from mbd.parts.channels import sensor_names
from mbd.parts.part_checks import StepError
from mbd.system.statics import State, equilibrium
from mbd.system.system import System

logger = logging.getLogger(__name__)

BLOCK_STATES = 400_000  # numbers per block of states: memory does not grow with the run
Progress = Callable[[float], None]


def simulate(
    system: System,
    settings: MotionSettings,
    progress: Progress | None = None,
    start: State | None = None,
    file: Path | None = None,
) -> Trajectory:
    """Simulate a machine.

    Parameters
    ----------
    system, settings : machine in its casing; time step, integrator and output
    progress : called with the completed share (0..1) after every block; may raise to interrupt
    start : state at t = 0, the equilibrium if None
    file : .npy file to which the values are written; None keeps them in memory

    Raises
    ------
    EquilibriumError, StepError : no equilibrium, or a step that does not converge
    MachineError : a motion that the machine does not allow, such as a rope that is wound up
    OSError : `file` cannot be written
    """
    with threadpool_limits(limits=1):  # small matrices: a second thread only waits
        system.machine.check_run(settings.end)
        every = max(1, math.ceil(1 / (settings.output_rate * settings.step) - 1e-9))  # steps per sample
        step = 1 / (settings.output_rate * every)
        integrator = make_integrator(settings.integrator, system, step)
        shape = (len(system.channels.names), settings.n_samples)
        values = np.zeros(shape) if file is None else StoredArray.create(file, shape)
        recorder = Recorder(system, integrator, every, settings.output_rate, values)
        balance = EnergyBalance(system, integrator, step, recorder.steps_needed)
        state = equilibrium(system, system.machine.starting_speed) if start is None else start
        step_check = StepCheck(recorder, system.machine.profile, step, every, balance.steps)
        repeatability = Repeatability(system, recorder, step, balance.steps)
        _feed(integrator.start(state), 0, recorder, balance)
        size = max(every, BLOCK_STATES // integrator.displacement.shape[1])
        done = 0
        while done < balance.steps:
            for check in (step_check, repeatability):
                check.before(integrator, done)
            n = min(size, balance.steps - done, step_check.reach(done), repeatability.reach(done))
            block = _advance(integrator, system, done, n, step)
            _feed(block, done + 1, recorder, balance)
            for check in (step_check, repeatability):
                check.after(done, n, block)
            done += n
            if progress is not None:
                progress(done / balance.steps)
        counters = integrator.counters | balance.elements.events()
        logger.info("simulated %d steps of %.3g s: %s", done, step, counters)
    rows, machine = system.channels, system.machine
    parts, table = balance.table()
    sources = [force for force in machine.forces if isinstance(force, TorqueSource)]
    return Trajectory(
        integrator=settings.integrator,
        time=np.arange(settings.n_samples) / settings.output_rate,
        channel_names=rows.names,
        channel_units=rows.units,
        values=recorder.values,
        motors=(*(coupling.name for coupling in machine.couplings), *(s.name for s in sources if s.drives)),
        sources=tuple(source.name for source in sources if not source.drives),
        shafts=tuple(shaft.name for shaft in machine.shafts),
        meshes=tuple(mesh.name for mesh in machine.meshes),
        bearings=tuple(bearing.name for bearing in machine.bearings),
        sensors=sensor_names(rows.names),
        step=step,
        step_error=step_check.error,
        diverged_at=repeatability.diverged_at,
        parting_rate=repeatability.rate,
        output_rate=settings.output_rate,
        pass_band=PASS_SHARE * settings.output_rate,
        counter_names=tuple(counters),
        counters=np.array(list(counters.values()), dtype=float),
        energy_parts=parts,
        energy_entries=ENERGY_ENTRIES,
        energies=table,
    )


def _advance(integrator: Integrator, system: System, done: int, n: int, step: float) -> Block:
    """Integrate n steps; the motor acceleration of a step is its mean, which preserves the change of speed."""
    block = integrator.advance(*system.machine.profile.motion(done, n, step))
    if not np.isfinite(block.states).all():
        bad = int(np.argmax(~np.isfinite(block.states).all(axis=1)))
        at = step * done + block.clock[: bad + 1, LENGTH].sum()
        raise StepError(f"t = {at:.6g} s: the state is not finite (h = {step:.3g} s). Use a smaller step.")
    machine = system.machine
    if machine.free and machine.load is not None:
        i = int(np.argmax(block.clock[:, ANGLE]))
        at = step * done + block.clock[: i + 1, LENGTH].sum()
        machine.load.check_turned(system.layout.ratios[machine.load.shaft] * float(block.clock[i, ANGLE]), at)
    return block


def _feed(block: Block, first: int, recorder: Recorder, balance: EnergyBalance) -> None:
    recorder.take(block)
    balance.take(block, first)
