"""Variants of a scene, computed by the cached steps of a run, with the cost of each step when it was computed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from pipelines.engine.run_graph import Outcome, Work
from pipelines.engine.step import Graph, Step
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.machine_model import MachineModel
from pipelines.scene.load_scene import LoadedScene, changed
from pipelines.signals.motion_warnings import log_warnings
from pipelines.steps.machine_steps import machine_steps
from pipelines.steps.run_plan import add_steps
from pipelines.studies.trade.probes import PROBES, Value

SHORT_SECONDS = (0.01, 0.02, 0.06)  # of motion: to compile a time loop, and to see what a step costs


@dataclass(frozen=True, kw_only=True)
class Measured:
    """The values of a variant and its cost; for a step from the cache, the cost of its computation."""

    by_probe: Mapping[str, tuple[Value, ...]]
    seconds: dict[str, float]  # by step
    peak_bytes: int

    @property
    def values(self) -> tuple[Value, ...]:
        """Values of all probes."""
        return tuple(value for values in self.by_probe.values() for value in values)

    @property
    def total_seconds(self) -> float:
        """Sum over the steps."""
        return sum(self.seconds.values())


def build_variants(
    scenes: Mapping[str, LoadedScene],
    needed: Callable[[MachineModel], Sequence[str]],
    work: Work,
    kinds: Sequence[str],
) -> dict[str, tuple[MachineModel, Outcome]]:
    """Build the needed steps of every scene, each distinct step once; machine model in SI and results by variant.

    Parameters
    ----------
    scenes : by variant
    needed : names of the steps that are needed, of a machine model in SI
    work : how steps are built
    kinds : of warnings on the motions that are logged, see `pipelines.signals.motion_warnings`
    """
    steps: list[Step] = []
    names, machines = {}, {}
    for variant, loaded in scenes.items():
        machines[variant] = machine = checked_machine(loaded.scene, loaded.source.shown)
        new = machine_steps(machine)
        added = add_steps(steps, new, f"{variant}: ")
        names[variant] = {step: added[step] for step in Graph(new).needed(needed(machine)).steps}
    graph = Graph(steps)
    every = dict.fromkeys(name for own in names.values() for name in own.values())
    outcome = work.build(graph, every)
    log_warnings((outcome.value(step.name) for step in graph if step.name in every and step.kind == "simulate"), kinds)
    return {
        variant: (machine, Outcome({step: outcome.results[name] for step, name in names[variant].items()}))
        for variant, machine in machines.items()
    }


def measure(
    scenes: Mapping[str, LoadedScene],
    probes: Sequence[str],
    work: Work,
) -> dict[str, Measured]:
    """Compute the steps that probes need for every scene, each distinct step once; the values and cost by variant."""

    def needed(machine: MachineModel) -> list[str]:
        return [name for probe in probes for name in PROBES[probe].steps(machine)]

    built = build_variants(scenes, needed, work, ("repeat",))  # other warnings are errors that the comparison shows
    return {variant: _measured(machine, probes, own) for variant, (machine, own) in built.items()}


def step_costs(scenes: Iterable[LoadedScene], work: Work) -> dict[str, float]:
    """Seconds per time step of every integrator of the scenes, from two short runs; compiles what is not yet compiled.

    Raises
    ------
    as `measure`
    """
    costs: dict[str, float] = {}
    for integrator, loaded in {loaded.scene.simulation.integrator: loaded for loaded in scenes}.items():
        seconds = []
        for end in SHORT_SECONDS:
            short = changed(loaded, {"simulation.end_s": end, "diagnosis.windows_s": {}})
            name = f"first {end:g} s, {integrator}"
            found = measure({name: short}, ["signals"], work)
            seconds.append(found[name].seconds["simulate"])
        steps = (SHORT_SECONDS[-1] - SHORT_SECONDS[-2]) / loaded.scene.simulation.made().step
        costs[integrator] = max(seconds[-1] - seconds[-2], 0.0) / steps
    return costs


def _measured(machine: MachineModel, probes: Sequence[str], own: Outcome) -> Measured:
    distinct = {record.key: (step, record) for step, record in zip(own.results, own.records, strict=True)}
    return Measured(
        by_probe={probe: tuple(PROBES[probe].read(machine, own)) for probe in probes},
        seconds={step: record.seconds for step, record in distinct.values()},
        peak_bytes=max(record.peak_bytes for _, record in distinct.values()),
    )
