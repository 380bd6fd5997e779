"""Remove finished runs: named ones, old ones, or all but the newest of every scene."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from pipelines.io.errors import WorkError
from pipelines.io.shown import shown
from pipelines.runs.kept_runs import KeptRun
from pipelines.runs.run_folder import LATEST, finished_runs, note_latest


def chosen(
    runs: Sequence[KeptRun], folders: Iterable[Path] = (), older_than: float | None = None, keep: int | None = None
) -> tuple[KeptRun, ...]:
    """The runs that are asked for.

    Parameters
    ----------
    runs : all that there are, newest first
    folders : of those that were named; all, if none was
    older_than : s, only those of a greater age
    keep : only those that are not among so many newest ones of their scene
    """
    named = {folder.resolve() for folder in folders}
    seen: Counter[str] = Counter()
    found = []
    for run in runs:
        seen[run.scene] += 1
        wanted = not named or run.folder.resolve() in named
        old = older_than is None or run.age > older_than
        if wanted and old and (keep is None or seen[run.scene] > keep):
            found.append(run)
    return tuple(found)


def remove_runs(runs: Iterable[KeptRun]) -> int:
    """Remove the folders, and note which run of each scene is the newest now; bytes that were freed.

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
