"""Step `error bars`: those of the lines of a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pipelines.diagnosis.uncertainty.bar_records import LineBars
from pipelines.machine.machine_model import MachineModel

if TYPE_CHECKING:
    import xarray

    from fem.casing.reduced.casing_modes import CasingModes
    from fem.casing.reduced.checkup import CheckUp
    from fem.casing.reduced.reduced_body import ReducedBody
    from fem.casing.uncertainty.extrapolation import LowestModes
    from mbd.output.trajectory import Trajectory
    from pipelines.diagnosis.control_diagnosis import Diagnosis
    from pipelines.machine.system_assembly import Laws


def build(
    machine: MachineModel,
    healthy: MachineModel,
    *,
    motion: Trajectory,
    control: Trajectory,
    laws: Sequence[Laws],
    body: ReducedBody,
    modes: tuple[CasingModes, CheckUp] | None = None,
    coarser: Sequence[LowestModes] = (),
) -> LineBars | str:
    """The error bars, or in a sentence why there are none.

    Parameters
    ----------
    machine, healthy : machines of the diagnosed run and of its control
    motion, control : their motions
    laws, body : of the mesh of every stage, and the reduced casing
    modes, coarser : of the casing and of coarser meshes, where its stiffness is extrapolated
    """
    from pipelines.diagnosis.control_diagnosis import diagnose
    from pipelines.signals.analysis import DiagnosisError
    from pipelines.signals.response import make_response
    from pipelines.signals.spectrum import SpectrumError

    settings = machine.diagnosis
    assert settings is not None, "there was something to diagnose"
    run = make_response(motion, machine.labels)
    try:
        found = diagnose(run, make_response(control, healthy.labels), settings)
    except (DiagnosisError, SpectrumError) as error:
        return f"No error bars without a diagnosis: {error}"
    return machine_bars(machine, run, found, laws=laws, body=body, modes=modes, coarser=coarser)


def machine_bars(
    machine: MachineModel,
    run: xarray.Dataset,
    diagnosis: Diagnosis,
    *,
    laws: Sequence[Laws],
    body: ReducedBody,
    modes: tuple[CasingModes, CheckUp] | None = None,
    coarser: Sequence[LowestModes] = (),
) -> LineBars | str:
    """The error bars of a run of a machine, or why there are none.

    Parameters
    ----------
    machine, run, diagnosis : the machine, its signals and their lines
    laws, body, modes, coarser : as in `build`
    """
    from mbd.parts.part_checks import EquilibriumError, MachineError
    from pipelines.diagnosis.uncertainty.sampled_bars import BarsError, casing_errors, line_bars
    from pipelines.machine.system_assembly import assemble_machine, assemble_system

    errors = casing_errors(None if modes is None else modes[0], coarser)
    try:
        system = assemble_system(assemble_machine(machine.parts, laws), body, machine.recorded, machine.motion.band)
        return line_bars(run, diagnosis, system, errors, machine.monitored.damping_spread, machine.casing.remedy)
    except (BarsError, MachineError, EquilibriumError) as error:
        return f"No error bars. {error}"
