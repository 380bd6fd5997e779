"""Verdict on recorded files by comparison with recordings of healthy machines, and their trend."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.runs.recorded_file import (
    RecordedFile,
    machine_of,
    read_features,
    recording_and_window,
    requested_windows,
)

if TYPE_CHECKING:
    import xarray

    from pipelines.diagnosis.impacts import Impacts
    from pipelines.diagnosis.trend import Course
    from pipelines.diagnosis.verdict import Verdict
    from pipelines.signals.features.feature_table import FeatureTable
    from pipelines.signals.orders.kinematics import Kinematics

SAME_SPEED = 0.03  # greatest relative difference of the speeds of recordings that are compared without a warning
_NAMED = 3  # recordings of another speed that a warning names


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
