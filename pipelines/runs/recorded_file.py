"""A recorded file: its machine, its windows, its features, and its signals for figures."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.io.user_files import is_regular_file
from pipelines.runs import run_folder
from pipelines.signals.motion_warnings import stored_warnings

if TYPE_CHECKING:
    import numpy as np

    from pipelines.diagnosis.comparison.compared_recording import ComparedRecording
    from pipelines.recordings.machine_file import MeasuredMachine
    from pipelines.signals.features.feature_table import FeatureTable
    from pipelines.signals.levels import ChannelLevel
    from pipelines.signals.orders.kinematics import Kinematics
    from pipelines.signals.orders.rotation import Rotation

Windows = Mapping[str, tuple[float, float]]


@dataclass(frozen=True, eq=False, kw_only=True)
class RecordedFile:
    """A recorded file: features, levels, relative uncertainty of its speed, its rotation in words, and warnings.

    `begin` is the date and time at which its first window begins, None if the file does not state it.
    """

    name: str
    begin: datetime | None = None
    table: FeatureTable
    levels: tuple[ChannelLevel, ...]
    error: float
    turning: str
    warnings: tuple[str, ...]


def recording_path(source: str | Path) -> Path:
    """The path of a recorded file, or of the response in the folder of a run."""
    path = Path(source)
    scene_or_folder = path.suffix == ".toml" or path.is_dir()  # the newest run of a scene
    file = not scene_or_folder and (is_regular_file(path) or bool(path.suffix))
    return path if file else run_folder.find_run(source) / run_folder.RESPONSE


def recording_and_window(source: str | Path) -> tuple[Path, str]:
    """The path of a recording, and the words behind the last "@" that select a window, "" without."""
    name, at, window = str(source).rpartition("@")
    if not at or Path(source).exists():
        return recording_path(source), ""
    return recording_path(name), window


def requested_windows(source: str | Path, asked: str, windows: Windows | None) -> Windows | None:
    """The window that is requested: by its name in the scene, or start and end in s; all of the scene if none is.

    Raises
    ------
    InputError : no such window
    """
    if not asked:
        return windows
    if windows and asked in windows:
        return {asked: windows[asked]}
    start, colon, end = asked.partition(":")
    try:
        if colon:
            return {"the window": (float(start), float(end))}
    except ValueError:
        pass
    names = f", or {', '.join(shown(name) for name in windows)}" if windows else ""
    raise InputError(
        f"{shown(source)}: {shown(asked)} is not a window. Give start and end in seconds, for example @0.5:2.5{names}."
    )


def machine_of(path: Path, machine: str | Path | None) -> tuple[MeasuredMachine, Windows | None]:
    """The machine of a recording, and the windows of its scene; None if it has none.

    Raises
    ------
    InputError : the file is missing or empty, or no machine is given and its folder has no scene of a run
    """
    from pipelines.recordings.formats import format_of
    from pipelines.recordings.machine_file import read_machine
    from pipelines.scene.load_scene import load_scene

    format_of(path)  # refuses a missing or empty file
    scene = path.parent / run_folder.RESOLVED
    if machine is None and not is_regular_file(scene):
        raise InputError(
            f"{shown(path)}: the machine is not known. Give --machine FILE: a scene, or a file with numbers of teeth, "
            "speed and sensors."
        )
    given = scene if machine is None else machine
    windows = dict(load_scene(scene).scene.diagnosis.windows_s) if is_regular_file(scene) else {}
    return read_machine(given), windows or None


def read_features(
    path: Path, machine: MeasuredMachine, windows: Windows | None, noise: float | None = None
) -> RecordedFile:
    """The features of a recorded file.

    Parameters
    ----------
    path : of the recording
    machine : of the recording
    windows : to evaluate, to the end of the recording where the end is infinite; the whole recording if None
    noise : rms (m/s2) of the noise that is added, for all features; None: that which a run states, for a diagnosis

    Raises
    ------
    InputError : the file cannot be read, its rotation is not found, or there are too few revolutions
    """
    from pipelines.diagnosis.simulated_features import FeatureSettings, run_features
    from pipelines.recordings.read_recording import read_recording
    from pipelines.signals.features.recording_features import FeatureError
    from pipelines.signals.levels import levels
    from pipelines.signals.orders.rotation import RotationError
    from pipelines.signals.orders.rotation_of import rotation_of

    with read_recording(path, machine) as recording:
        warnings, time = tuple(stored_warnings(recording.attrs).values()), recording.time.values
        windows = {
            name: (start, min(end, time[-1] if end == math.inf else end))
            for name, (start, end) in (windows or {}).items()
        }
        settings = FeatureSettings(kinematics=machine.kinematics, windows=windows, complete=noise is not None)
        beyond = time[-1] + 1.5 * (time[-1] - time[-2])  # the recording ends one step after its last sample
        for start, end in windows.values():
            if not time[0] <= start < end < beyond:
                raise InputError(
                    f"{shown(path)}: the window from {start:g} to {end:g} s is not within the recording, {time[0]:.6g} "
                    f"to {time[-1]:.6g} s. Select a window within it, its start before its end: {shown(path)}@START:END"
                )
        try:
            rotation = rotation_of(recording, machine.kinematics)
            if noise is not None:  # without seed and load, so that it depends on the signals only
                recording = recording.drop_attrs(deep=False).assign_attrs(sensor_noise_m_s2=noise)
            table = run_features(recording, settings, rotation)
            spans = windows or {"whole": (float(time[0]), float(time[-1]))}
            found, begin = levels(recording, spans), recording.attrs.get("begin")
        except (FeatureError, RotationError) as error:
            raise InputError(f"{shown(path)}: {error}") from error
    turning = _turning(rotation, time, machine.kinematics, windows)
    before = timedelta(seconds=min(start for start, _ in spans.values()) - float(time[0]))
    return RecordedFile(
        name=path.name,
        begin=datetime.fromisoformat(begin) + before if begin else None,
        table=table,
        levels=found,
        error=rotation.error,
        turning=turning,
        warnings=warnings,
    )


def _turning(rotation: Rotation, time: np.ndarray, kinematics: Kinematics, windows: Windows | None) -> str:
    """Speed and mesh frequencies in the first window and the source of the speed, in words."""
    import numpy as np

    start, end = next(iter((windows or {"": (time[0], time[-1])}).values()))
    first, last = np.searchsorted(time, start), min(int(np.searchsorted(time, end)), len(time) - 1)
    turned = abs(float(rotation.angle[last] - rotation.angle[first])) / (2.0 * math.pi)
    frequency = turned / float(time[last] - time[first])
    meshes = "".join(
        f", f_m {order * frequency:.5g} Hz (stage {stage})" for stage, order in kinematics.mesh_orders().items()
    )
    return (
        f"{kinematics.shafts[0].name} turns {turned:.1f} times in {start:.4g} to {end:.4g} s: f_r {frequency:.5g} "
        f"Hz{meshes}, {60 * frequency:.5g} rpm{rotation.origin}"
    )


def recorded_parts(
    sources: Sequence[str | Path], machine: str | Path | None, window: tuple[float, float] | None
) -> list[ComparedRecording]:
    """Recordings with their rotation, for figures.

    Parameters
    ----------
    sources : files, or folders of runs; each may end in a window, as in "record.csv@0.5:2.5"
    machine : of all recordings, its description or scene; that of the last one if None
    window : start and end (s); if None, the windows of the scene of the last one, or the whole recording

    Raises
    ------
    InputError : a file or the machine cannot be used
    """
    from pipelines.diagnosis.comparison.compared_recording import compared_recording
    from pipelines.recordings.read_recording import read_recording
    from pipelines.signals.features.recording_features import FeatureError
    from pipelines.signals.orders.rotation import RotationError

    last, asked = recording_and_window(sources[-1])
    known, windows = machine_of(last, machine)
    chosen = requested_windows(sources[-1], asked, {"the window": window} if window else windows)
    parts = []
    for source in sources:
        file, asked = recording_and_window(source)
        own = requested_windows(source, asked, chosen)
        with read_recording(file, known) as recording:
            try:
                parts.append(compared_recording(shown(source), recording, known.kinematics, own))
            except (FeatureError, RotationError) as error:
                raise InputError(f"{shown(source)}: {error}") from error
    return parts
