"""Error bars of the lines of a run: as a step of it, and of a finished one from its files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipelines.bars.line_bars import LineBars
from pipelines.engine.step import Step
from pipelines.plant.plant import Plant
from pipelines.runs import run_folder
from pipelines.steps.graph import extrapolated_from

if TYPE_CHECKING:
    import xarray

    from pipelines.engine.step import Graph
    from pipelines.engine.working import Work
    from pipelines.scene.file import Settings
    from pipelines.signals.diagnosis import Diagnosis
    from pipelines.steps.study import Study


@dataclass(frozen=True, eq=False, kw_only=True)
class BarsSpec:
    """The plants of the diagnosed run and of its control, and whether results of the casing's meshes are taken."""

    plant: Plant
    control: Plant
    extrapolated: bool


def bars_step(study: Study) -> Step:
    """The bars of the first case of a study that has a control."""
    case = study.cases[0]
    assert case.control is not None, "a diagnosis has one"
    assert case.healthy is not None, "a diagnosis has one"
    casing = casing_steps(study.graph)
    return Step(
        name="error bars",
        kind="error-bars",
        build=build,
        spec=BarsSpec(plant=case.plant, control=case.control, extrapolated=len(casing) > 1),
        takes=(case.faulty, case.healthy, *case.plant.law_names, *casing),
        libraries=("numpy", "scipy"),
        seconds=3.0,
    )


def casing_steps(graph: Graph) -> tuple[str, ...]:
    """Names of the steps of the casing that bars take."""
    coarser = extrapolated_from(graph.steps)
    return ("casing", *(("casing modes", *coarser) if coarser else ()))


def build(spec: BarsSpec, *taken: Any) -> LineBars | str:
    """The bars, or in a sentence why there are none."""
    from pipelines.signals.analysis import DiagnosisError
    from pipelines.signals.diagnosis import diagnose
    from pipelines.signals.response import make_response
    from pipelines.signals.spectrum import SpectrumError

    plant, settings = spec.plant, spec.plant.diagnosis
    assert settings is not None, "there was something to diagnose"
    run, control = make_response(taken[0], plant.labels), make_response(taken[1], spec.control.labels)
    try:
        found = diagnose(run, control, settings)
    except (DiagnosisError, SpectrumError) as error:
        return f"No error bars without a diagnosis: {error}"
    return plant_bars(plant, run, found, taken[2:])


def folder_bars(folder: Path, diagnosis: Diagnosis, settings: Settings, work: Work) -> LineBars | str:
    """The bars of a diagnosis of a finished run, or why there are none; steps of its casing come from the cache.

    Parameters
    ----------
    folder : of the results
    diagnosis : by `pipelines.runs.diagnosed.diagnose_folder` with the same settings
    settings : those of the diagnosis; what they change of the machine is left aside
    work : what builds the casing again if it is no longer in the cache

    Raises
    ------
    SceneError, WorkError : the scene cannot be used any more, or a step failed
    """
    from pipelines.runs.single_results import scene_graph
    from pipelines.scene.file import load_scene

    graph, plant = scene_graph(load_scene(folder / run_folder.RESOLVED))  # the casing is that of the run
    asked = load_scene(folder / run_folder.RESOLVED, settings).scene.diagnosis
    plant = replace(plant, looked_for=replace(plant.looked_for, damping_spread=asked.damping_spread))
    names = (*plant.law_names, *casing_steps(graph))
    outcome = work.build(graph, names)
    with run_folder.opened_run(folder / run_folder.RESPONSE) as run:
        return plant_bars(plant, run, diagnosis, [outcome.value(name) for name in names])


def plant_bars(plant: Plant, run: xarray.Dataset, diagnosis: Diagnosis, taken: Any) -> LineBars | str:
    """The bars of a run of a plant, or why there are none.

    Parameters
    ----------
    plant, run, diagnosis : the plant, its signals and their lines
    taken : results of the steps of its laws and of `casing_steps`
    """
    from mbd.parts.checks import EquilibriumError, MachineError
    from pipelines.bars.made import BarsError, line_bars
    from pipelines.bars.uncertain import uncertain
    from pipelines.plant.assembly import assemble_machine, assemble_system

    count = len(plant.law_names)
    body, modes, *coarser = (*taken[count:], None) if len(taken) == count + 1 else taken[count:]
    unknown = uncertain(plant.casing, None if modes is None else modes[0], coarser, plant.looked_for.damping_spread)
    try:
        system = assemble_system(
            assemble_machine(plant.machine, taken[:count]), body, plant.recorded, plant.motion.band
        )
        return line_bars(run, diagnosis, system, unknown)
    except (BarsError, MachineError, EquilibriumError) as error:
        return f"No error bars. {error}"
