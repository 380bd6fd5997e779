"""Machine of a scene: natural modes about its loaded state of rest, and its simulated signals."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from gearcase.progress import ProgressFunction
from gearcase.scenes import Scene, loaded_scene
from mbd.system.linearised import LinearModes
from pipelines.engine.run_graph import Work
from pipelines.runs.single_results import build_machine_modes, build_signals

if TYPE_CHECKING:
    import xarray

__all__ = ["LinearModes", "modes", "simulate"]


def modes(
    scene: Scene,
    *,
    up_to: float = 10e3,
    cycle: float | None = None,
    speed: float = 0.0,
    processes: int | None = None,
    progress: ProgressFunction | None = None,
) -> LinearModes:
    """Compute natural frequencies, damping and energy shares of small vibrations about the loaded state of rest.

    Parameters
    ----------
    scene : the scene
    up_to : highest frequency, Hz
    cycle : position of stage 1 in the mesh cycle; by default that at the start
    speed : speed of the motors, rpm; losses and gyroscopic moments depend on it
    processes : long steps computed in parallel, 2 by default
    progress : function that is called with a `StepProgress` for every step

    Raises
    ------
    SceneError, WorkError : the scene cannot be used, a step failed
    MachineError (a ValueError) : a mesh without load has no tangent stiffness

    >>> import gearcase
    >>> found = gearcase.modes(gearcase.Scene.from_file("minimal"), up_to=300)
    >>> for frequency, part in zip(found.frequencies, found.dominant):
    ...     print(f"{frequency:.1f} Hz, {part}")
    112.8 Hz, motor coupling
    271.6 Hz, bearings of shaft 2
    297.1 Hz, bearings of shaft 2
    """
    work = Work(processes=processes, progress=progress)
    return build_machine_modes(loaded_scene(scene), work, up_to=up_to, cycle=cycle, speed=speed / 60 * 2 * math.pi)[0]


def simulate(scene: Scene, *, processes: int | None = None, progress: ProgressFunction | None = None) -> xarray.Dataset:
    """Simulate a scene and return its signals: accelerations, forces, speeds, each with its unit; writes no file.

    Parameters
    ----------
    scene : the scene
    processes : long steps computed in parallel, 2 by default
    progress : function that is called with a `StepProgress` for every step

    Raises
    ------
    SceneError, WorkError : the scene cannot be used, a step failed

    >>> import gearcase
    >>> short = {"simulation.end_s": 0.1, "diagnosis.windows_s": {}}
    >>> response = gearcase.simulate(gearcase.Scene.from_file("minimal").changed(short))
    >>> signal = response.acceleration.sel(sensor="sensor_3", axis="z")
    >>> signal.sizes["time"], signal.units
    (1000, 'm/s2')
    """
    return build_signals(loaded_scene(scene), Work(processes=processes, progress=progress))
