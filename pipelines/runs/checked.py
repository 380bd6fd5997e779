"""A scene checked as a run begins: what follows from it, what it costs, what is questionable in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fem.storage import shown_html

if TYPE_CHECKING:
    from pipelines.plant.facts import Facts
    from pipelines.plant.plant import Plant
    from pipelines.scene.file import LoadedScene


MOST_DIFFERENCES = 10  # of scene and control that are listed; more belong to another machine


@dataclass(frozen=True, kw_only=True)
class Checked:
    """A scene that can be run."""

    plant: Plant  # the scene in SI
    facts: Facts  # ratios, frequencies (Hz), speeds (rad/s, m/s), torques (N m), forces (N), lengths (m)
    cost: str  # of a run: steps, seconds, memory, disk
    warnings: tuple[str, ...]  # what is questionable, and how its control differs in more than the fault

    def _repr_html_(self) -> str:
        """The gear pairs in numbers, cost and warnings, for a notebook."""
        rows = [
            (
                number,
                f"{pair.pinion.teeth}/{pair.wheel.teeth}",
                stage.ratio,
                stage.mesh_frequency,
                stage.pinion_frequency,
                stage.wheel_frequency,
                stage.mesh_force,
            )
            for number, (pair, stage) in enumerate(zip(self.plant.layout.pairs, self.facts.stages, strict=True), 1)
        ]
        head = ("stage", "z1/z2", "ratio", "mesh, Hz", "pinion, Hz", "wheel, Hz", "mesh force, N")
        said = shown_html.table("Cost and warnings", (), ((line,) for line in (self.cost, *self.warnings)))
        return shown_html.table(self.plant.title, head, rows) + said


def check_scene(loaded: LoadedScene) -> Checked:
    """What a run would refuse is refused here, before anything is computed.

    Raises
    ------
    SceneError, InputError : everything that does not fit
    """
    from pipelines.plant.checks.cost import estimate
    from pipelines.plant.checks.design_warnings import design_warnings
    from pipelines.scene.file import control_differences
    from pipelines.steps.study import plan_study

    study = plan_study(loaded)
    warnings = list(design_warnings(loaded.scene, study.plant.layout))
    if study.control is not None:
        lines = control_differences(loaded, study.control)
        head = f"the control {study.control.name} differs in more than the fault"
        warnings += [f"{head}: {line}" for line in lines[:MOST_DIFFERENCES]]
        if more := len(lines) - MOST_DIFFERENCES:
            warnings += [f'{head}: {more} further values. Set control = "without-faults"'] if more > 0 else []
    return Checked(
        plant=study.plant,
        facts=study.plant.facts,
        cost=str(estimate(loaded.scene, len(study.motions))),
        warnings=tuple(warnings),
    )
