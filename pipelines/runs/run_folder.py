"""Result folders, ./runs/<scene>/<timestamp>/: the names of their files, the newest one of a scene, the log."""

from __future__ import annotations

import contextlib
import json
import logging
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.io.errors import InputError, WorkError
from pipelines.io.shown_text import shown
from pipelines.io.user_files import folder_name, is_regular_file, read_text, write_whole

if TYPE_CHECKING:
    import xarray

_LOG = logging.getLogger(__name__)
ROOT = Path("runs")  # of the results, in the working folder
RESPONSE = "response.nc"
CONTROL = "control.nc"
RESOLVED = "scene.resolved.toml"
ASKED = "scene.asked.toml"
RUN = "run.json"
VERDICT = "verdict.txt"
REPORT = "report.html"
LATEST = "latest.txt"
_LONGEST_NAME = 1000  # bytes of latest.txt


def note_latest(folder: Path) -> None:
    """Name the newest result of its scene. WorkError if it cannot be noted."""
    latest = folder.parent / LATEST
    try:
        write_whole(latest, f"{folder.name}\n")
    except OSError as error:
        raise WorkError(
            f"{latest}: cannot be written ({error.strerror}). The results are complete; use their folder, {folder}."
        ) from error


def finished_runs(root: Path = ROOT, scene: str = "*") -> list[Path]:
    """Folders of the finished runs below `root`, of one scene or of all, newest first."""
    found = [path for path in root.glob(f"{scene}/*/{RESPONSE}") if is_regular_file(path)]
    return [path.parent for path in sorted(found, key=lambda path: (-path.stat().st_mtime_ns, str(path)))]


def find_run(name: str | Path, root: Path = ROOT) -> Path:
    """The folder of a run: by its path, by its scene (the newest one), as ``scene/folder``, or by its number in
    ``gearcase runs`` (1 is the newest).

    Raises
    ------
    InputError : there is none
    """
    folder, text = Path(name), str(name)
    scene = root / (folder_name(folder.stem) if text.endswith(".toml") else text)
    for place in (folder, scene):
        if is_regular_file(place / RESPONSE):
            return place
    for parent in (scene, folder):
        latest = parent / LATEST
        if is_regular_file(latest):
            found = parent / read_text(latest, _LONGEST_NAME).strip()
            if is_regular_file(found / RESPONSE):
                return found
            raise InputError(
                f"{shown(found)}: no {RESPONSE} here, though {shown(latest)} names it. "
                f"Repeat: gearcase run {shown(name)}"
            )
    if text.isdecimal() and len(text) < 10:
        known = finished_runs(root)
        if 1 <= int(text) <= len(known):
            return known[int(text) - 1]
        count = "1 run" if len(known) == 1 else f"{len(known)} runs"
        raise InputError(
            f"run {text}: there is no run of this number; the folder {shown(root)} has {count}. List them: gearcase "
            "runs"
        )
    raise InputError(
        f"{shown(name)}: no result here, neither {shown(folder / RESPONSE)} nor {shown(scene / LATEST)}. "
        + _remedy(text)
    )


def _remedy(name: str) -> str:
    """What to do about a name without a result: run that scene, or see what there is."""
    from pipelines.scene.load_scene import shipped_names

    if name in shipped_names() or (name.endswith(".toml") and is_regular_file(Path(name))):
        return f"First: gearcase run {shown(name)}"
    return "Correct the name: `gearcase runs` lists the finished runs. Or run a scene first: gearcase run SCENE"


@contextlib.contextmanager
def opened_run(path: Path) -> Iterator[xarray.Dataset]:
    """The signals of a run, from its response or that of its control; each is read from the file when it is used.

    Raises
    ------
    InputError : the file is damaged, or none of ours
    """
    from pipelines.signals.response_file import open_response

    with open_response(path) as data:
        if "time" not in data.dims:
            raise InputError(f"{shown(path)}: holds no signals over time. Repeat gearcase run.")
        yield data


def loaded_run(folder: Path) -> xarray.Dataset:
    """All signals of a result folder in memory; `attrs["folder"]` names it.

    Raises
    ------
    InputError : as `opened_run`
    """
    with opened_run(folder / RESPONSE) as data:
        return data.load().assign_attrs(folder=str(folder))


class JsonLines(logging.FileHandler):
    """Log records as lines of JSON: time, level, logger, message. A full disk ends the log, not the work."""

    failure: BaseException | None = None

    def format(self, record: logging.LogRecord) -> str:
        """The line of a record."""
        line = {
            "time": round(record.created, 3),
            "level": record.levelname,
            "logger": record.name,
            "message": record.getMessage(),
        }
        return json.dumps(line | getattr(record, "facts", {}), ensure_ascii=False)

    def handleError(self, record: logging.LogRecord) -> None:
        """Note what prevented a line."""
        self.failure = sys.exc_info()[1]


@contextlib.contextmanager
def logged_to(path: Path) -> Iterator[None]:
    """Everything our packages log at INFO or above goes to the file while the block runs."""
    handler = JsonLines(path, "w", encoding="utf-8", errors="replace")
    handler.setLevel(logging.INFO)
    loggers = [logging.getLogger(name) for name in ("fem", "mbd", "pipelines")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.addHandler(handler)
        logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.removeHandler(handler)
            logger.setLevel(level)
        with contextlib.suppress(OSError):  # of the lines for which the disk had no room
            handler.close()
        if handler.failure is not None:
            _LOG.warning("%s is incomplete: %s", path, handler.failure)
