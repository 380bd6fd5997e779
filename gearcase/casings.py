"""The casing and its natural modes."""

from __future__ import annotations

from gearcase.scenes import Scene, loaded_scene
from gearcase.working import ProgressFunction
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
    """The casing of a scene as the machine sees it, with its natural modes in the ground.

    Parameters
    ----------
    scene : the scene
    error_check : compare frequencies and responses with the full model; costs about as much as the reduction
    processes : long steps built side by side, 2 by default
    progress : is told of every step

    Raises
    ------
    SceneError, InputError, WorkError : the scene cannot be used, it has no full model to compare with, a step failed

    >>> import gearcase
    >>> found = gearcase.casing(gearcase.Scene.from_file("minimal"))
    >>> print(f"{len(found.frequencies)} modes, the lowest at {found.frequencies[0]:.0f} Hz")
    6 modes, the lowest at 647 Hz
    """
    return build_casing(loaded_scene(scene), Work(processes=processes, progress=progress), error_check=error_check)
