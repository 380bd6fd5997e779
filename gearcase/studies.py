"""Studies of accuracy and cost."""

from __future__ import annotations

from gearcase.argument_checks import refusal
from gearcase.progress import ProgressFunction
from gearcase.scenes import Scene, loaded_scene
from pipelines.engine.run_graph import Work
from pipelines.studies.trade.axes import AXES
from pipelines.studies.trade.refinement import RefinementStudy, refine
from pipelines.studies.trade.tradeoff import Tradeoff, trade

__all__ = ["RefinementStudy", "Tradeoff", "converge", "tradeoff"]


def converge(
    scene: Scene,
    over: str,
    *,
    levels: int = 3,
    processes: int | None = None,
    progress: ProgressFunction | None = None,
) -> RefinementStudy:
    """Estimate the discretisation error of one mesh, number of modes or time step, by Richardson extrapolation.

    Parameters
    ----------
    scene : the scene
    over : "gear-mesh", "slices", "positions", "casing-mesh", "modes", "shaft-elements" or "step"
    levels : number of sizes: one finer than in the scene, that of the scene, the rest coarser
    processes : long steps computed in parallel, 2 by default
    progress : function that is called with a `StepProgress` for every step

    Returns
    -------
    values of every quantity at every level (`units` by quantity), observed order, limit and uncertainty band

    Raises
    ------
    SceneError, InputError, WorkError : `over` does not apply to the scene, a level is out of range, a step failed

    >>> import gearcase
    >>> found = gearcase.converge(gearcase.Scene.from_file("minimal"), "slices")
    >>> found.units["stage 1 stiffness"], found.fineness
    ('N/um', (2.0, 1.0, 0.5))
    """
    if over not in AXES:
        raise refusal("over", over, f"one of {', '.join(AXES)}", "Correct the name.")
    return refine(loaded_scene(scene), over, levels, Work(processes=processes, progress=progress))


def tradeoff(scene: Scene, *, processes: int | None = None, progress: ProgressFunction | None = None) -> Tradeoff:
    """Measure the time and accuracy of every model and main setting, compared with a reference. Takes minutes.

    Parameters
    ----------
    scene : the scene
    processes : long steps computed in parallel, 2 by default
    progress : function that is called with a `StepProgress` for every step

    Returns
    -------
    every choice with its seconds, peak memory in bytes and largest errors (relative; of levels in dB)

    Raises
    ------
    SceneError, WorkError : the scene cannot be used, a step failed

    >>> import gearcase
    >>> found = gearcase.tradeoff(gearcase.Scene.from_file("minimal"))  # doctest: +SKIP
    >>> found.most_accurate(seconds=10.0).choice.name  # doctest: +SKIP
    """
    return trade(loaded_scene(scene), Work(processes=processes, progress=progress))
