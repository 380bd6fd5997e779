"""The gear pair of a stage in its machine, with the steps that candidates of a search take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from fem.gears.geometry import GearPair
from fem.gears.modifications import PairModifications
from pipelines.engine.step import Graph
from pipelines.machine.machine_model import MachineModel
from pipelines.runs.root_stress import root_step
from pipelines.runs.single_results import scene_graph
from pipelines.scene.load_scene import LoadedScene
from pipelines.steps.mesh_response import response_step


@dataclass(frozen=True, eq=False, kw_only=True)
class StagePair:
    """The gear pair of a stage, from 1, of a machine without faults.

    graph : steps of the machine, and those in `takes`
    takes : names of the steps of the inputs of candidates: "laws", "roots", "response"
    """

    machine: MachineModel
    stage: int
    graph: Graph
    takes: Mapping[str, str]

    @property
    def pair(self) -> GearPair:
        """The gears, without backlash."""
        return self.machine.flanks[self.stage - 1].pair

    @property
    def force(self) -> float:
        """Force along the line of action at the load of the scene, N."""
        return self.machine.facts.stages[self.stage - 1].shown_force

    @property
    def given(self) -> PairModifications:
        """The modifications of the scene."""
        return self.machine.layout.modifications[self.stage - 1]

    @property
    def involute(self) -> PairModifications:
        """No modifications, but the misalignment of the scene."""
        return PairModifications(misalignment=self.given.misalignment)


def stage_pair(loaded: LoadedScene, stage: int) -> StagePair:
    """The pair of a stage of a scene without faults and deviations.

    Raises
    ------
    SceneError : the scene cannot be used
    """
    graph, machine = scene_graph(loaded)
    law, root = machine.healthy_law_names[stage - 1], root_step(machine, stage)
    response = response_step(machine, graph.steps["simulate"], stage, law)
    takes = {"laws": law, "roots": root.name, "response": response.name}
    return StagePair(machine=machine, stage=stage, graph=Graph([*graph, root, response]), takes=takes)
