"""Removal of finished runs: the choice of those that meet given conditions, and the removal of their folders."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from pipelines.io.errors import WorkError
from pipelines.io.shown_text import shown
from pipelines.runs.kept_runs import KeptRun
from pipelines.runs.run_folder import LATEST, finished_runs, note_latest


def runs_to_remove(
    runs: Sequence[KeptRun], folders: Iterable[Path] = (), older_than: float | None = None, keep: int | None = None
) -> tuple[KeptRun, ...]:
    """The runs that meet all conditions.

    Parameters
    ----------
    runs : all runs, newest first
    folders : of the named runs; all runs if empty
    older_than : only runs of a greater age, s
    keep : only runs that are not among this number of newest runs of their scene
    """
    named = {folder.resolve() for folder in folders}
    seen: Counter[str] = Counter()
    found = []
    for run in runs:
        seen[run.scene] += 1
        selected = not named or run.folder.resolve() in named
        old = older_than is None or run.age > older_than
        if selected and old and (keep is None or seen[run.scene] > keep):
            found.append(run)
    return tuple(found)


def remove_runs(runs: Iterable[KeptRun]) -> int:
    """Remove the folders of runs, and note which run of each scene is now the newest; the number of bytes freed.

    Raises
    ------
    WorkError : a folder cannot be removed
    """
    freed = 0
    for run in runs:
        try:
            shutil.rmtree(run.folder)
        except OSError as error:
            raise WorkError(f"{shown(run.folder)}: cannot be removed ({error.strerror}). Remove it by hand.") from error
        freed += run.bytes
        scene = run.folder.parent
        left = finished_runs(scene.parent, scene.name)
        if left:
            note_latest(left[0])
        else:
            (scene / LATEST).unlink(missing_ok=True)
    return freed
