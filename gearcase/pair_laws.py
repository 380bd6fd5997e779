"""`gearcase.laws`: the mesh laws of all gear pairs of a scene, with their curves of stiffness."""

from __future__ import annotations

from gearcase.progress import ProgressFunction
from gearcase.scenes import Scene, loaded_scene
from pipelines.engine.run_graph import Work
from pipelines.runs.single_results import build_pairs
from pipelines.steps.pair_curves import PairLaws

__all__ = ["PairLaws", "laws"]


def laws(
    scene: Scene, *, processes: int | None = None, progress: ProgressFunction | None = None
) -> tuple[PairLaws, ...]:
    """Compute the mesh laws of every gear pair, in the order of the stages, at the loads of the scene.

    `PairLaws.curve` returns the mesh stiffness over the mesh cycle k(c), healthy and with the faults of the scene.

    Parameters
    ----------
    scene : the scene
    processes : long steps computed in parallel, 2 by default
    progress : function that is called with a `StepProgress` for every step

    Raises
    ------
    SceneError, WorkError : the scene cannot be used, a step failed

    >>> import gearcase
    >>> fault = {"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 0}
    >>> scene = gearcase.Scene.from_file("minimal").changed(faults=[fault], diagnosis={"gear": "pinion"})
    >>> pair = gearcase.laws(scene)[0]
    >>> k = pair.curve().secant
    >>> k.dims, k.units, [str(state) for state in k.state.values]
    (('state', 'cycle'), 'N/m', ['healthy', 'faulty'])
    """
    return build_pairs(loaded_scene(scene), Work(processes=processes, progress=progress))
