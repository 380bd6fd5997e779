"""Result folders, ./runs/<scene>/<timestamp>/: the names of their files, the newest one of a scene, the log."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import re
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pipelines.errors import InputError, WorkError

_LOG = logging.getLogger(__name__)
RESPONSE = "response.nc"
CONTROL = "control.nc"
RESOLVED = "scene.resolved.toml"
ASKED = "scene.asked.toml"
RUN = "run.json"
LATEST = "latest.txt"
_UNSAFE = re.compile(r'[<>:"/\\|?*\x00-\x1f\x7f-\x9f\ud800-\udfff]')
_RESERVED = {"CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"}  # of Windows, whatever follows the first dot
_RESERVED |= {f"{port}{number}" for port in ("COM", "LPT") for number in "0123456789\u00b9\u00b2\u00b3"}


def folder_name(name: str) -> str:
    """The name of a scene as that of one visible folder on every system; InputError if nothing is left of it."""
    safe = _UNSAFE.sub("_", name).strip(". ")
    if not safe or safe.partition(".")[0].rstrip().upper() in _RESERVED:
        raise InputError(
            f"{name!r}: no name for a folder of results, which a scene file gives it. Rename it, as in my-scene.toml."
        )
    return safe


def note_latest(folder: Path) -> None:
    """Name the newest result of its scene. WorkError if it cannot be noted."""
    latest = folder.parent / LATEST
    try:
        _write_whole(latest, f"{folder.name}\n")
    except OSError as error:
        raise WorkError(
            f"{latest}: cannot be written ({error.strerror}). The results are whole: name their folder, {folder}."
        ) from error


def find_run(name: str | Path, root: Path | None = None) -> Path:
    """The folder of a run: the folder itself, or the newest one of a scene.

    Raises
    ------
    InputError : there is none
    """
    folder = Path(name)
    if (folder / RESPONSE).is_file():
        return folder
    text = str(name)
    scene = (root or Path("runs")) / (folder_name(folder.stem) if text.endswith(".toml") else text)
    for parent in (scene, folder):
        latest = parent / LATEST
        if latest.is_file():
            found = parent / latest.read_text(encoding="utf-8").strip()
            if (found / RESPONSE).is_file():
                return found
            raise InputError(f"{found}: no {RESPONSE} here, though {latest} names it. Again: gearcase run {name}")
    raise InputError(
        f"{name}: no result here, neither {folder / RESPONSE} nor {scene / LATEST}. First: gearcase run {name}"
    )


def write_json(path: Path, content: Any) -> None:
    """Write readable JSON, UTF-8: all of it, or the file stays as it was."""
    _write_whole(path, json.dumps(content, indent=1, ensure_ascii=False) + "\n")


def _write_whole(path: Path, text: str) -> None:
    partial = path.with_name(f".{path.name}-{uuid.uuid4().hex}")
    try:
        partial.write_text(text, encoding="utf-8")
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


class JsonLines(logging.Handler):
    """Log records as lines of JSON: time, level, logger, message. A full disk ends the log, not the work."""

    def __init__(self, path: Path) -> None:
        super().__init__(logging.INFO)
        self._file = open(path, "wb", buffering=0)  # noqa: SIM115 - closed with the handler
        self.failure: OSError | None = None

    def emit(self, record: logging.LogRecord) -> None:
        """Write one line."""
        line = {
            "time": round(record.created, 3),
            "level": record.levelname,
            "logger": record.name,
            "message": record.getMessage(),
        }
        text = json.dumps(line | getattr(record, "facts", {}), ensure_ascii=False) + "\n"
        try:
            if self.failure is None:
                self._file.write(text.encode("utf-8", errors="replace"))
        except OSError as error:
            self.failure = error

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()


@contextlib.contextmanager
def logged_to(path: Path) -> Iterator[None]:
    """Everything our packages log at INFO or above goes to the file while the block runs."""
    handler = JsonLines(path)
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
        handler.close()
        if handler.failure is not None:
            _LOG.warning("%s is cut short: %s", path, handler.failure)
