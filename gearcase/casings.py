"""The casing and its natural modes."""

from __future__ import annotations

from gearcase.progress import ProgressFunction
from gearcase.scenes import Scene, loaded_scene
from pipelines.engine.run_graph import Work
from pipelines.runs.single_results import Casing, build_casing

__all__ = ["Casing", "casing"]


def casing(
    scene: Scene,
    *,
    error_check: bool = False,
    processes: int | None = None,
    progress: ProgressFunction | None = None,
) -> Casing:
    """Compute the casing of a scene: reduced matrices, and natural modes on its mounts.

    Parameters
    ----------
    scene : the scene
    error_check : compare frequencies and responses with the full model; takes about as long as the reduction
    processes : long steps computed in parallel, 2 by default
    progress : function that is called with a `StepProgress` for every step

    Raises
    ------
    SceneError, InputError, WorkError : the scene cannot be used, it has no full model for the comparison, a step failed

    >>> import gearcase
    >>> found = gearcase.casing(gearcase.Scene.from_file("minimal"))
    >>> print(f"{len(found.frequencies)} modes, the lowest at {found.frequencies[0]:.0f} Hz")
    6 modes, the lowest at 647 Hz
    """
    return build_casing(loaded_scene(scene), Work(processes=processes, progress=progress), error_check=error_check)
