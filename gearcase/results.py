"""Runs with a result folder: simulation, finished runs, diagnosis, error bars and spectra."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gearcase.argument_checks import checked_file, checked_recording, checked_signal, refusal
from gearcase.progress import ProgressFunction
from gearcase.scenes import Scene, Settings, loaded_scene
from pipelines.diagnosis.control_diagnosis import Diagnosis
from pipelines.diagnosis.uncertainty.bar_records import LineBars
from pipelines.engine.run_graph import Work
from pipelines.io.errors import InputError, WorkError
from pipelines.runs.diagnosed_run import diagnose_folder, folder_bars
from pipelines.runs.run import run_scene
from pipelines.runs.run_folder import find_run, loaded_run
from pipelines.signals.labelled_spectrum import labelled_spectrum

if TYPE_CHECKING:
    import xarray

__all__ = ["Diagnosis", "LineBars", "diagnose", "error_bars", "open_run", "run", "spectrum"]


def run(
    scene: Scene,
    *,
    out: str | Path | None = None,
    control: bool = True,
    both_loads: bool = True,
    seeds: int = 0,
    processes: int | None = None,
    progress: ProgressFunction | None = None,
) -> xarray.Dataset:
    """Run a scene with its control, diagnose it, write the result folder with its report, and return the signals.

    Parameters
    ----------
    scene : the scene
    out : result folder, ./runs/<scene>/<timestamp> by default
    control : also run the healthy control, and compare with it in the diagnosis
    both_loads : with a rope, also run the equivalent constant torque
    seeds : number of further seeds of the deviations to compare, together with error-free gears
    processes : long steps computed in parallel, 2 by default
    progress : function that is called with a `StepProgress` for every step

    Returns
    -------
    the content of response.nc; `attrs["folder"]` is the result folder

    Raises
    ------
    SceneError, InputError : the scene or `out` cannot be used
    WorkError : a step failed

    >>> import gearcase
    >>> short = {"simulation.end_s": 0.1, "diagnosis.windows_s": {}}
    >>> response = gearcase.run(gearcase.Scene.from_file("minimal").changed(short), out="my-result")
    >>> response.attrs["folder"]
    'my-result'
    """
    if not isinstance(seeds, int):
        raise refusal("seeds", seeds, "a whole number", "Give 0 or more.")
    work = Work(processes=processes, progress=progress)
    done = run_scene(loaded_scene(scene), out=out, with_control=control, both_loads=both_loads, seeds=seeds, work=work)
    return loaded_run(done.folder)


def open_run(name: str | Path) -> xarray.Dataset:
    """Open the signals of a finished run.

    Parameters
    ----------
    name : result folder, or the name of a scene for its newest result under ./runs

    Raises
    ------
    InputError : there is no such run, or its file is damaged

    >>> import gearcase
    >>> gearcase.open_run("nowhere")
    Traceback (most recent call last):
    ...
    pipelines.io.errors.InputError: nowhere: no result here, neither ...
    """
    return loaded_run(find_run(checked_file("name", name, "a result folder or the name of a scene")))


def diagnose(response: xarray.Dataset, settings: Settings = ()) -> Diagnosis:
    """Compare the lines of the known fault in a finished run with its healthy control; also returns the spectra.

    Parameters
    ----------
    response : result of `run` or `open_run`
    settings : other settings of the diagnosis, such as {"diagnosis.sensor": "sensor_5"}

    Raises
    ------
    InputError : no control was run, no windows are given, or the signals come from no result folder

    >>> import gearcase
    >>> fault = {"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 0}
    >>> scene = gearcase.Scene.from_file("minimal").changed(faults=[fault], diagnosis={"gear": "pinion"})
    >>> found = gearcase.diagnose(gearcase.run(scene.changed(control="without-faults"), out="missing"))
    >>> bool(found.lines.detected.sum() > 5)
    True
    """
    return diagnose_folder(Path(_folder(response)), settings)


def error_bars(
    response: xarray.Dataset,
    settings: Settings = (),
    *,
    processes: int | None = None,
    progress: ProgressFunction | None = None,
) -> LineBars:
    """Estimate the uncertainty of the levels of the lines of a finished run, without another simulation.

    Parameters
    ----------
    response : result of `run` or `open_run`
    settings : as for `diagnose`, such as {"diagnosis.damping_spread": 0.5}
    processes : long steps computed in parallel, 2 by default; only if the casing is no longer in the cache
    progress : function that is called with a `StepProgress` for every step

    Returns
    -------
    `LineBars`: error bars of all lines at least 10 dB over their floor. Each has a `numerical` band (None if the error
    of the mesh of the casing is unknown) and one of the `inputs`, in dB relative to its `level`; `notes` describe them

    Raises
    ------
    SceneError, InputError : as for `diagnose`
    WorkError : a step failed, or error bars are impossible, with the reason

    >>> import gearcase
    >>> fault = {"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 0}
    >>> scene = gearcase.Scene.from_file("minimal").changed(faults=[fault], diagnosis={"gear": "pinion"})
    >>> found = gearcase.error_bars(gearcase.run(scene.changed(control="without-faults"), out="uncertain"))
    >>> all(bar.inputs.low < 0 < bar.inputs.high for bar in found.of("lifting") if bar.kind == "mesh")
    True
    """
    folder = Path(_folder(response))
    work = Work(processes=processes, progress=progress)
    found = folder_bars(folder, diagnose_folder(folder, settings), settings, work)
    if isinstance(found, str):
        raise WorkError(found)
    return found


def spectrum(signal: xarray.DataArray) -> xarray.DataArray:
    """Amplitude spectrum of a signal over time: one-sided peak amplitudes with a Hann window, in the signal's unit.

    Parameters
    ----------
    signal : over `time` (s), equally spaced; other dimensions are kept. Cut it with
        ``signal.sel(time=slice(0.5, 1.5))``

    Returns
    -------
    amplitudes over `frequency` (Hz) instead of time; a tone A cos(2 pi f t) at a frequency of the spectrum has A

    Raises
    ------
    InputError : no data array over time, fewer than four samples, or unequal spacing

    >>> import gearcase, numpy, xarray
    >>> time = numpy.arange(1000) / 1000
    >>> tone = xarray.DataArray(3 * numpy.cos(2 * numpy.pi * 50 * time), coords={"time": time}, dims="time")
    >>> print(f"{float(gearcase.spectrum(tone).sel(frequency=50)):.3f}")
    3.000
    """
    return labelled_spectrum(checked_signal("signal", signal))


def _folder(response: xarray.Dataset) -> str:
    attributes = checked_recording("response", response).attrs
    if "folder" not in attributes:
        raise InputError("response: the signals are of no result folder. Give what gearcase.run or open_run returned.")
    return str(attributes["folder"])
