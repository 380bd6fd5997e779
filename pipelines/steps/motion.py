"""Step `simulate`: motion of the machine in its casing, which starts in equilibrium and follows the speed profile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from fem.processes.executor import tell_share
from fem.storage.ledger import count

if TYPE_CHECKING:
    from fem.casing.reduced.reduced_body import ReducedBody
    from fem.contact.law import MeshLaw
    from mbd.integrators.settings import MotionSettings
    from mbd.output.trajectory import Trajectory
    from mbd.system.system import System
    from pipelines.machine.machine_parts import MachineParts, Recorded


_SAMPLES_AHEAD = 10


@dataclass(frozen=True, eq=False, kw_only=True)
class MotionSpec:
    """The machine without mesh laws and casing, the recorded channels, and the settings of the motion."""

    machine: MachineParts
    recorded: Recorded
    motion: MotionSettings


def build(
    spec: MotionSpec, *, body: ReducedBody, laws: Sequence[tuple[MeshLaw, MeshLaw]], folder: Path | None = None
) -> Trajectory:
    """The trajectory of the recorded channels, with energy balance and counters.

    Parameters
    ----------
    spec : the machine, its motion and the recorded channels
    body : the reduced casing
    laws : of drive and coast flank of every mesh
    folder : for a file of the values; None keeps them in memory

    Raises
    ------
    OSError : the file cannot be written
    """
    from mbd.integrators.methods import compile_loop

    compile_loop(spec.motion.integrator)  # in parallel with `precompile`, which compiles code for the assembly
    system = assembled(spec, body, laws)
    trajectory = moved(system, spec.motion, folder / "values.npy" if folder else None)
    load = system.machine.load
    count("simulations")
    count("coordinates", system.basis.shape[1])
    count("rope_coordinates", int(bool(load is not None and load.coordinates)))
    count("time_steps", trajectory.counter("steps") if "steps" in trajectory.counter_names else 0)
    count("channels", len(trajectory.channel_names))
    return trajectory


def precompile(spec: MotionSpec, *laws: tuple[MeshLaw, MeshLaw]) -> None:
    """Compile the code of a motion, or read it from disk, by simulating a few steps without casing.

    The evaluation of the laws is first, because it takes the longest to compile. If the motion starts in another
    process meanwhile, that process compiles the time loop.
    """
    from fem.casing.models.no_casing import NoCasing
    from fem.contact.evaluation.evaluator import LawEvaluator
    from mbd.output.simulate import simulate
    from mbd.system.system import assemble
    from pipelines.machine.system_assembly import assemble_machine

    for drive, _ in laws:
        LawEvaluator(drive).evaluate(0.0, 0.0)
    machine = assemble_machine(spec.machine, laws)
    system = assemble(machine, NoCasing().reduce(bearings={one.name: (0.0, 0.0, 0.0) for one in machine.bearings}), ())
    simulate(system, replace(spec.motion, end=_SAMPLES_AHEAD / spec.motion.output_rate))


def assembled(spec: MotionSpec, body: ReducedBody, laws: Sequence[tuple[MeshLaw, MeshLaw]]) -> System:
    """The system of the machine in its casing; arguments as in `build`."""
    from pipelines.machine.system_assembly import assemble_machine, assemble_system

    return assemble_system(assemble_machine(spec.machine, laws), body, spec.recorded, spec.motion.band)


def moved(system: System, given: MotionSettings, file: Path | None = None) -> Trajectory:
    """The motion of a system; `file` as in `mbd.output.simulate.simulate`."""
    import numpy as np

    from mbd.output.repeatability import other_start
    from mbd.output.simulate import simulate
    from mbd.system.statics import equilibrium

    start = None
    if given.start:
        speed = float(system.machine.profile.speed(np.zeros(1))[0])
        start = other_start(system, equilibrium(system, speed), given.start)
    return simulate(system, given, tell_share, start=start, file=file)
