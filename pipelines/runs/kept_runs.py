"""The finished runs under a folder: scene, verdict, size and age of each, and in what their scenes differ.

Nothing but small text files is read, so that hundreds of runs are listed at once.
"""

from __future__ import annotations

import contextlib
import json
import re
import time
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown, shown_value
from pipelines.io.text_table import Grid, grid
from pipelines.io.toml_text import TomlError, read_toml
from pipelines.io.user_files import is_regular_file, read_text
from pipelines.runs.run_folder import RESOLVED, RESPONSE, RUN, VERDICT, finished_runs
from pipelines.scene.merge import leaves
from pipelines.scene.tree_limits import MOST_BYTES

_MOST_SHOWN = 3  # settings in a row of the table
_LONGEST = 40  # characters of a setting there
_SPANS = ((86400.0, "d"), (3600.0, "h"), (60.0, "min"))


@dataclass(frozen=True, kw_only=True)
class KeptRun:
    """A finished run. `number` counts from the newest, 1; 0 is one outside ./runs. `settings` are the values of its
    scene by dotted key."""

    number: int
    folder: Path
    scene: str
    verdict: str  # in one sentence, "" if nothing was diagnosed
    settings: Mapping[str, Any]
    bytes: int
    age: float  # s, since its signals were written


def kept_runs(root: Path, now: float | None = None) -> tuple[KeptRun, ...]:
    """All runs below a folder as ``runs/<scene>/<time>``, newest first; `now` (s since 1970) is that of the clock."""
    clock = time.time() if now is None else now
    return tuple(kept_run(number, folder, clock) for number, folder in enumerate(finished_runs(root), 1))


def kept_run(number: int, folder: Path, now: float) -> KeptRun:
    """The run in a folder; `now` in s since 1970."""
    sizes = [path.stat(follow_symlinks=False).st_size for path in folder.rglob("*")]
    return KeptRun(
        number=number,
        folder=folder,
        scene=folder.parent.name,
        verdict=_verdict(folder),
        settings=run_settings(folder),
        bytes=sum(sizes),
        age=max(0.0, now - (folder / RESPONSE).stat().st_mtime),
    )


def run_settings(folder: Path) -> dict[str, Any]:
    """The values of the scene of a run by dotted key, and its --baseline; none where a file is gone or was spoiled."""
    settings: dict[str, Any] = {}
    with contextlib.suppress(OSError, InputError, TomlError):
        tree = read_toml(read_text(folder / RESOLVED, MOST_BYTES))
        settings = {".".join(path): value for path, value in leaves(tree).items()}
    with contextlib.suppress(OSError, InputError, ValueError, KeyError):
        settings["--baseline"] = json.loads(read_text(folder / RUN, MOST_BYTES))["baseline"]
    return settings


def _verdict(folder: Path) -> str:
    """The first sentence of the verdict, "" without one."""
    if not is_regular_file(folder / VERDICT):
        return ""
    with open(folder / VERDICT, encoding="utf-8", errors="replace") as file:
        return shown(re.split(r"(?<=\.) ", file.readline(1000).strip(), maxsplit=1)[0], 1000)


def differing(runs: Iterable[KeptRun]) -> dict[int, dict[str, Any]]:
    """Values of every run, by its number, that are not the same in all runs of its scene; None where it has none.

    Values that the fewest of these runs have are first.
    """
    by_scene: dict[str, list[KeptRun]] = defaultdict(list)
    for run in runs:
        by_scene[run.scene].append(run)
    found: dict[int, dict[str, Any]] = {}
    for same in by_scene.values():
        keys = sorted({key for run in same for key in run.settings})
        unlike = [key for key in keys if any(run.settings.get(key) != same[0].settings.get(key) for run in same)]
        for run in same:
            alike = {key: sum(one.settings.get(key) == run.settings.get(key) for one in same) for key in unlike}
            found[run.number] = {key: run.settings.get(key) for key in sorted(unlike, key=lambda key: alike[key])}
    return found


def run_grid(runs: Iterable[KeptRun]) -> Grid:
    """A row per run."""
    runs = tuple(runs)
    unlike = differing(runs)
    rows = [
        {
            "run": run.number,
            "scene": run.scene,
            "folder": run.folder.name,
            "age": age_text(run.age),
            "MB": f"{run.bytes / 1e6:.1f}",
            "differs in": settings_text(unlike[run.number]),
            "verdict": run.verdict or "not diagnosed",
        }
        for run in runs
    ]
    return grid("Runs, newest first", rows)


def settings_text(settings: Mapping[str, Any]) -> str:
    """Settings as on a command line, the first of many; "-" for none."""
    parts = [
        f"{key}={shown_value(value, _LONGEST) if value is not None else '(none)'}" for key, value in settings.items()
    ]
    more = [f"and {len(parts) - _MOST_SHOWN} more"] if len(parts) > _MOST_SHOWN else []
    return ", ".join([*parts[:_MOST_SHOWN], *more]) or "-"


def age_text(seconds: float) -> str:
    """An age in its largest unit.

    >>> age_text(30.0), age_text(7200.0), age_text(200000.0)
    ('30 s', '2 h', '2 d')
    """
    for length, unit in _SPANS:
        if seconds >= length:
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds:.0f} s"
