"""Recordings of measured accelerations: open, compute features, compare with healthy ones and with one another."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import xarray

from gearcase.argument_checks import checked_by_name, checked_file, checked_recording, checked_recordings
from pipelines.datasets.feature_source import FeatureSource
from pipelines.datasets.workers import local_workers
from pipelines.diagnosis.comparison.labelled_comparison import labelled_comparison
from pipelines.diagnosis.verdict import Verdict
from pipelines.recordings.machine_file import read_machine
from pipelines.recordings.read_recording import read_recording
from pipelines.runs.judged_recording import judge_recordings

if TYPE_CHECKING:
    import pandas

MACHINE = "a machine file, a scene file, or the name of a shipped scene"
_SOURCE = "a recording, a run, a data set or a folder of recordings"
__all__ = ["Verdict", "compare", "features", "judge", "open_recording"]


def open_recording(path: str | Path, machine: str | Path) -> xarray.Dataset:
    """Open the signals of a measured file, in the same form as those of a run; samples are read when they are used.

    Parameters
    ----------
    path : CSV, MATLAB, HDF5, netCDF, UFF, NumPy, WAV or TDMS file
    machine : file with the teeth, the speed and the sensors, a scene file, or the name of a shipped scene

    Returns
    -------
    `acceleration` (time, sensor, axis) in m/s2, and `tachometer` (time) if there is one. The file stays open until the
    dataset is closed, for example by a `with` block

    Raises
    ------
    InputError, SceneError : the file cannot be read, or contradicts the machine file

    >>> import gearcase, numpy, pathlib
    >>> _ = pathlib.Path("bench.toml").write_text("teeth = [[20, 31]]\\nspeed_rpm = 1500\\nrate_Hz = 5000\\n")
    >>> numpy.save("record.npy", numpy.random.default_rng(1).normal(size=20000))
    >>> with gearcase.open_recording("record.npy", "bench.toml") as recording:
    ...     print(f"{float(recording.acceleration.std()):.1f} {recording.acceleration.units}")
    1.0 m/s2
    """
    return read_recording(
        checked_file("path", path, "a recording"), read_machine(checked_file("machine", machine, MACHINE))
    )


def features(
    sources: str | Path | Sequence[str | Path],
    machine: str | Path | None = None,
    *,
    start: float = 0.0,
    end: float = math.inf,
    noise_m_s2: float = 0.0,
    processes: int | None = None,
) -> pandas.DataFrame:
    """Compute the features of recordings, finished runs or a data set; docs/features.md defines them.

    Parameters
    ----------
    sources : recordings, runs, folders of recordings, or the folder of one data set
    machine : machine file, scene file, or the name of a shipped scene; runs and data sets have their own
    start, end : part to evaluate, s; by default the whole signal
    noise_m_s2 : RMS of added white noise, which depends only on the signals
    processes : signals processed in parallel, all cores by default

    Returns
    -------
    a row for each signal, channel, component and feature: `recording` (or `run`, the number in a data set), `sensor`,
    `axis`, `component`, `feature`, `unit`, `value` in this unit, and `level_dB` over the reference of the feature. The
    attribute `failures` gives the reason for each signal without features

    Raises
    ------
    InputError, SceneError : a source or the machine cannot be used, or no signal has features

    >>> import gearcase, numpy, pathlib
    >>> _ = pathlib.Path("bench.toml").write_text("teeth = [[20, 31]]\\nspeed_rpm = 1500\\nrate_Hz = 5000\\n")
    >>> angle = 2 * numpy.pi * 25 * numpy.arange(40000) / 5000
    >>> mesh = (1 + 0.5 * numpy.cos(angle) + 0.5 * numpy.cos(20 / 31 * angle)) * numpy.cos(20 * angle)
    >>> numpy.save("record.npy", mesh + 0.01 * numpy.random.default_rng(1).normal(size=angle.size))
    >>> table = gearcase.features("record.npy", "bench.toml").set_index(["component", "feature"])
    >>> print(f"{table.value['stage 1 pinion', 'mesh_1_upper']:.2f} m/s2")
    0.25 m/s2
    """
    import pandas as pd

    several = [sources] if isinstance(sources, str | Path) else list(sources)
    named = [checked_file(f"sources[{number}]", one, _SOURCE) for number, one in enumerate(several)]
    found = FeatureSource(named, machine, start, end, noise_m_s2)
    with local_workers(processes) as workers:
        table = pd.concat(list(found.frames(workers.executor, lambda done, total: None)), ignore_index=True)
    table.attrs["failures"] = found.failures
    return table


def judge(recording: xarray.Dataset, healthy: Sequence[xarray.Dataset], machine: str | Path) -> Verdict:
    """Diagnose a recording: whether it differs from healthy ones, and which gear, bearing or shaft is damaged.

    Parameters
    ----------
    recording : result of `open_recording`, `simulate`, `run` or `open_run`, or a part of it:
        ``recording.sel(time=slice(0.5, 2.5))``
    healthy : recordings of healthy machines, at about the same speed and load; limits need 5 or more
    machine : as for `open_recording`

    Raises
    ------
    InputError, SceneError : an argument is of another type, a recording has no features, they cannot be compared, or
        the machine cannot be read

    >>> import gearcase, numpy, pathlib, xarray
    >>> _ = pathlib.Path("bench.toml").write_text("teeth = [[20, 31]]\\nspeed_rpm = 1500\\n")
    >>> time = numpy.arange(20000) / 5000
    >>> angle = 2 * numpy.pi * 25 * time
    >>> def record(seed, depth=0.0):  # a mesh, modulated once per turn of the first shaft
    ...     mesh = (1 + depth * numpy.cos(angle)) * numpy.cos(20 * angle)
    ...     signal = mesh + 0.1 * numpy.random.default_rng(seed).normal(size=time.size)
    ...     return xarray.Dataset(
    ...         {"acceleration": (("time", "sensor", "axis"), signal[:, None, None]),
    ...          "shaft_angle": (("time", "shaft"), angle[:, None])},
    ...         {"time": time, "sensor": ["gearbox"], "axis": ["z"], "shaft": ["shaft_1"]})
    >>> found = gearcase.judge(record(1, depth=0.4), [record(seed) for seed in range(2, 8)], "bench.toml")
    >>> found.damaged, found.first.component
    (True, 'stage 1 pinion')
    """
    one, others = checked_recording("recording", recording), checked_recordings("healthy", healthy)
    return judge_recordings(one, others, read_machine(checked_file("machine", machine, MACHINE)).kinematics)


def compare(recordings: Mapping[str, xarray.Dataset], machine: str | Path) -> xarray.Dataset:
    """Compare the features of recordings, at their common channels and their lowest sampling rate.

    Parameters
    ----------
    recordings : by name, each as for `judge`
    machine : as for `open_recording`

    Returns
    -------
    `value` (recording, component, feature) in the unit of the feature, `difference` from the first recording in dB, and
    `speed` (recording,) of the first shaft in rad/s; NaN where a component does not have a feature

    Raises
    ------
    InputError, SceneError : a recording has no features, there is no common channel, or the machine cannot be read

    >>> import gearcase, numpy, pathlib, xarray
    >>> _ = pathlib.Path("bench.toml").write_text("teeth = [[20, 31]]\\nspeed_rpm = 1500\\n")
    >>> time = numpy.arange(20000) / 5000
    >>> angle = 2 * numpy.pi * 25 * time
    >>> signal = numpy.cos(20 * angle) + 0.1 * numpy.random.default_rng(1).normal(size=time.size)
    >>> recording = xarray.Dataset(
    ...     {"acceleration": (("time", "sensor", "axis"), signal[:, None, None]),
    ...      "shaft_angle": (("time", "shaft"), angle[:, None])},
    ...     {"time": time, "sensor": ["gearbox"], "axis": ["z"], "shaft": ["shaft_1"]})
    >>> twice = recording.assign(acceleration=2 * recording.acceleration)
    >>> found = gearcase.compare({"A": recording, "B": twice}, "bench.toml")
    >>> print(f"{float(found.difference.sel(recording='B', component='whole machine', feature='rms')):.2f} dB")
    6.02 dB
    """
    named = checked_by_name("recordings", recordings)
    return labelled_comparison(named, read_machine(checked_file("machine", machine, MACHINE)).kinematics)
