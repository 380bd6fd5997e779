"""Verdict on a recorded file by comparison with recordings of healthy machines."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.io.text_table import Grid, grid
from pipelines.io.user_files import is_regular_file
from pipelines.runs import run_folder
from pipelines.signals.motion_warnings import stored_warnings

if TYPE_CHECKING:
    import numpy as np
    import xarray

    from pipelines.diagnosis.comparison.compared_recording import ComparedRecording
    from pipelines.diagnosis.impacts import Impacts
    from pipelines.diagnosis.trend import Course
    from pipelines.diagnosis.verdict import Verdict
    from pipelines.recordings.machine_file import MeasuredMachine
    from pipelines.signals.features.feature_table import FeatureTable
    from pipelines.signals.levels import ChannelLevel
    from pipelines.signals.orders.kinematics import Kinematics
    from pipelines.signals.orders.rotation import Rotation

SAME_SPEED = 0.03  # greatest relative difference of the speeds of recordings that are compared without a warning
_NAMED = 3  # recordings of another speed that a warning names
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


@dataclass(frozen=True, eq=False, kw_only=True)
class JudgedFile:
    """A file with its features; the verdict and the accepted healthy recordings, if such were given."""

    recorded: RecordedFile
    kinematics: Kinematics
    verdict: Verdict | None
    healthy: tuple[RecordedFile, ...] = ()

    @property
    def impacts(self) -> tuple[Impacts, ...]:
        """Impacts of rolling bearings that the file shows without comparison."""
        from pipelines.diagnosis.impacts import impacts

        return impacts(self.recorded.table)


def judge_files(
    sources: Sequence[str | Path],
    healthy: Sequence[str | Path] = (),
    machine: str | Path | None = None,
    window: tuple[float, float] | None = None,
    refused: dict[str, str] | None = None,
) -> Iterator[JudgedFile]:
    """The verdict on each of several recorded files or responses of runs.

    Parameters
    ----------
    sources : files, or folders of runs; each may end in a window, as in "record.csv@0.5:2.5"
    healthy : files or folders of healthy machines; without a window, that of the source is evaluated
    machine : its description or scene; that of the run if None
    window : start and end (s) of the part to evaluate; if None, the windows of the scene, or the whole recording
    refused : out: the reason for each file that cannot be judged, by its name; None: the first one is an error

    Raises
    ------
    InputError : a file or the machine cannot be used, or the recordings cannot be compared
    """
    read: dict[str, list[RecordedFile]] = {}  # healthy recordings, by machine and windows
    for source in sources:
        try:
            yield _judged_file(source, healthy, machine, window, read)
        except InputError as error:
            if refused is None:
                raise
            refused[shown(source)] = str(error)


def _judged_file(
    source: str | Path,
    healthy: Sequence[str | Path],
    machine: str | Path | None,
    window: tuple[float, float] | None,
    read: dict[str, list[RecordedFile]],
) -> JudgedFile:
    """One file of `judge_files`; `read` keeps the healthy recordings for the next one."""
    from pipelines.signals.features.feature_table import confirmed

    names = [shown(one) for one in healthy]
    path, asked = recording_and_window(source)
    known, windows = machine_of(path, machine)
    chosen = requested_windows(source, asked, {"the window": window} if window else windows)
    own = read_features(path, known, chosen)
    same = f"{machine or path.parent} {chosen}"
    if same not in read:
        split = [(one, *recording_and_window(one)) for one in healthy]
        read[same] = [read_features(file, known, requested_windows(one, part, chosen)) for one, file, part in split]
    others = read[same]
    tables = confirmed([one.table for one in (own, *others)])
    other = " Another recording confirms the tooth numbers." if any(tables[0].conditional) else ""
    own = replace(own, table=tables[0], turning=own.turning + other)
    verdict = _judged(tables, known.kinematics, names, f"{shown(path)}: ") if others else None
    own = replace(own, warnings=(*own.warnings, *other_speeds(own, dict(zip(names, others, strict=True)))))
    kept = tuple(one for name, one in zip(names, others, strict=True) if verdict and name not in verdict.outlying)
    return JudgedFile(recorded=own, kinematics=known.kinematics, verdict=verdict, healthy=kept)


def recorded_parts(
    sources: Sequence[str | Path], machine: str | Path | None, window: tuple[float, float] | None
) -> list[ComparedRecording]:
    """Recordings with their rotation, for figures; `machine` and `window` as in `judge_files`, for the last recording.

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


def other_speeds(own: RecordedFile, healthy: Mapping[str, RecordedFile]) -> list[str]:
    """A warning if healthy recordings (by name) have other speeds, since levels depend on speed."""
    speeds = {name: 60.0 * float(one.table.speed[0]) for name, one in healthy.items()}
    rpm = 60.0 * float(own.table.speed[0])
    other = [f"{name} {speed:.5g} rpm" for name, speed in speeds.items() if abs(speed / rpm - 1.0) > SAME_SPEED]
    if not other:
        return []
    return [
        f"{len(other)} of {len(healthy)} healthy recordings differ from {rpm:.5g} rpm by more than "
        f"{100 * SAME_SPEED:g} %: {', '.join(other[:_NAMED])}{' and others' * (len(other) > _NAMED)}. Levels "
        "depend on speed and load, and the verdict may be wrong. Give healthy recordings of the same speed and load."
    ]


def judge_recordings(recording: xarray.Dataset, healthy: Sequence[xarray.Dataset], kinematics: Kinematics) -> Verdict:
    """The verdict on a recording in memory, which is evaluated completely.

    Raises
    ------
    InputError : a recording has no rotation or no features, or the recordings cannot be compared
    """
    from pipelines.diagnosis.simulated_features import FeatureSettings, run_features
    from pipelines.signals.features.recording_features import FeatureError
    from pipelines.signals.orders.rotation import RotationError

    settings = FeatureSettings(kinematics=kinematics, windows={})
    tables = []
    for number, one in enumerate([recording, *healthy]):
        name = f"healthy recording {number}" if number else "the recording"
        try:
            tables.append(run_features(one, settings))
        except (FeatureError, RotationError) as error:
            raise InputError(f"{name}: {error}") from error
    return _judged(tables, kinematics)


def _judged(
    tables: Sequence[FeatureTable], kinematics: Kinematics, names: Sequence[str] = (), where: str = ""
) -> Verdict:
    """The verdict on the first table against the others, with their names; InputError that begins with a place."""
    from pipelines.diagnosis.baseline_checks import BaselineError
    from pipelines.diagnosis.judge import judge
    from pipelines.signals.features.feature_table import with_common_components

    own, *healthy = with_common_components(tables)
    try:
        return judge(own, healthy, kinematics, names)
    except BaselineError as error:
        raise InputError(f"{where}{error}") from error


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


def file_words(found: JudgedFile) -> str:
    """Verdict and speed as text; without healthy recordings the features."""
    from pipelines.diagnosis.impacts import impact_words
    from pipelines.diagnosis.verdict_words import text
    from pipelines.signals.levels import level_grid

    parts = [found.recorded.turning, *(f"Warning: {warning}" for warning in found.recorded.warnings)]
    levels = [f"{level_grid(found.recorded.levels).to_text()}\n"] if found.recorded.levels else []
    if found.verdict is not None:
        answer, _, tables = text(found.verdict).partition("\n\n")
        return "\n\n".join([answer, *parts, tables.rstrip(), *levels])
    parts = [impact_words(found.recorded.table), *parts]
    parts += [features_grid(found.recorded.table).to_text(), *levels]
    return "\n\n".join(parts) + "\n"


def files_grid(names: Sequence[str], found: Sequence[JudgedFile], refused: Iterable[str] = ()) -> Grid:
    """Table of recordings that were judged in the same way: name, speed, level, answer and strongest evidence.

    Parameters
    ----------
    names, found : the recordings
    refused : names of recordings that cannot be judged
    """
    from pipelines.diagnosis.impacts import CLEAR
    from pipelines.diagnosis.verdict_words import STRENGTH, answer, strength
    from pipelines.signals.features.feature_table import WHOLE
    from pipelines.signals.orders.rotation import percent

    rows: list[dict[str, str]] = []
    for name, one in zip(names, found, strict=True):
        table = one.recorded.table
        rms = mean_features(table)[table.lines.index((WHOLE, "rms"))]
        result = ("-", "-", "-")
        if one.verdict is not None:
            first = one.verdict.first
            components = " or ".join([first.component, *one.verdict.candidates])
            result = answer(one.verdict), components, strength(first.evidence)
        elif one.impacts:
            best = one.impacts[0]
            result = "damaged" if best.clear else "-", best.component, f"{best.level:.1f}"
        evidence = f"impacts dB (limit {CLEAR:g})" if one.verdict is None else STRENGTH
        known = {
            "rpm": f"{60 * table.speed[0]:.5g}",
            "known to %": percent(one.recorded.error),
            "rms m/s2": f"{rms:.3g}",
        }
        named = zip(("answer", "strongest evidence", evidence), result, strict=True)
        moment = {} if one.recorded.begin is None else {"begins": f"{one.recorded.begin:%Y-%m-%d %H:%M:%S}"}
        rows.append({"": str(len(rows) + 1), "recording": name, **dict(named), **moment, **known})
    rows += [dict.fromkeys(rows[0], "-") | {"recording": name, "answer": "refused"} for name in refused]
    return grid(f"{len(rows)} recordings", rows)


def notes_of(found: Sequence[JudgedFile]) -> list[str]:
    """Warnings and components that are not examined, each once with the numbers of its recordings, from 1."""
    from pipelines.signals.features.feature_table import left_out_words

    notes: dict[str, list[str]] = {}
    for number, one in enumerate(found, 1):
        left = one.recorded.table.left_out if one.verdict is None else one.verdict.left_out
        warnings = [f"Warning: {warning}" for warning in one.recorded.warnings]
        for note in filter(None, (*warnings, left_out_words(left))):
            notes.setdefault(note, []).append(str(number))
    return [note if len(own) == len(found) else f"{note} (recordings {', '.join(own)})" for note, own in notes.items()]


def order_of(found: Sequence[JudgedFile]) -> tuple[list[int], str, bool]:
    """Numbers of recordings, from 0, in the order of a trend, this order in words, and whether it is that of time.

    It is that of time if all files state different times, else that in which they were given.
    """
    begins = [one.recorded.begin for one in found]
    known = [one for one in begins if one is not None]
    if len(set(known)) == len(begins):
        return sorted(range(len(begins)), key=known.__getitem__), "In the order of the times in the files.", True
    lack = len(begins) - len(known)
    reason = f"{lack} of {len(begins)} do not state when they begin" if lack else "some begin at the same time"
    return list(range(len(begins))), f"In the order in which they were given, because {reason}.", False


def courses_of(found: Sequence[JudgedFile]) -> list[Course]:
    """The trend of recordings in their order: evidence of every component, and levels of every channel."""
    from pipelines.diagnosis.trend import evidence_courses, impact_courses, level_courses

    verdicts = [one.verdict for one in found if one.verdict is not None]
    first = evidence_courses(verdicts) if verdicts else impact_courses([one.impacts for one in found])
    healthy = [one.levels for one in found[0].healthy]
    return [*first, *level_courses([one.recorded.levels for one in found], healthy)]


def file_facts(found: JudgedFile) -> dict[str, Any]:
    """The verdict (None without healthy recordings), and every feature as the mean over the channels."""
    from pipelines.signals.features.definitions import BY_NAME

    table = found.recorded.table
    features = [
        {"component": component, "feature": feature, "unit": BY_NAME[feature].unit, "value": float(value)}
        for (component, feature), value in zip(table.lines, mean_features(table), strict=True)
    ]
    return {
        "recording": found.recorded.name,
        "begin": None if found.recorded.begin is None else found.recorded.begin.isoformat(),
        "turning": found.recorded.turning,
        "speed_rpm": 60 * float(table.speed[0]),
        "speed_uncertainty_percent": 100 * found.recorded.error,
        "warnings": found.recorded.warnings,
        "verdict": found.verdict,
        "impacts": found.impacts,
        "levels": found.recorded.levels,
        "features": features,
        "left_out": table.left_out,
    }


def mean_features(table: FeatureTable) -> np.ndarray:
    """Features (line,) as the geometric mean over the channels."""
    import numpy as np

    return np.exp(np.mean(np.log(np.maximum(table.value, np.finfo(float).tiny)), axis=0))


def features_grid(table: FeatureTable) -> Grid:
    """Table with a row for each component and feature, as the mean over the channels."""
    from pipelines.signals.features.definitions import BY_NAME

    rows = [
        {
            "component": component,
            "feature": BY_NAME[feature].words,
            "value": f"{mean:.3g}",
            "dB": f"{20 * math.log10(mean):.1f}",
        }
        for (component, feature), mean in zip(table.lines, mean_features(table), strict=True)
    ]
    return grid("Features, mean over all channels", rows)
