"""Result folders: ./runs/<scene>/<timestamp>/, written aside and moved into place when everything is there."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipelines.errors import InputError
from pipelines.shown import shown
from pipelines.user_files import is_regular_file, names_beside, read_text, regular_file, writable_folder

if TYPE_CHECKING:
    import xarray

RESPONSE = "response.nc"
CONTROL = "control.nc"
RESOLVED = "scene.resolved.toml"
ASKED = "scene.asked.toml"
RUN = "run.json"
LATEST = "latest.txt"
_PARTIAL = ".partial-"
_LONGEST_NAME = 1000  # bytes of latest.txt


@contextlib.contextmanager
def result_folder(final: Path) -> Iterator[Path]:
    """A folder to fill. It becomes `final` only when the block ends without an error; else it is removed."""
    try:
        final.parent.mkdir(parents=True, exist_ok=True)
        _sweep(final.parent)
        partial = final.parent / f"{_PARTIAL}{final.name}-{os.getpid()}"
        partial.mkdir()
    except OSError as error:
        raise InputError(f"{final}: results cannot be written ({error.strerror}). Choose another --out.") from error
    try:
        yield partial
        if final.is_dir():
            final.rmdir()  # an empty folder given by --out
        os.replace(partial, final)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def note_latest(folder: Path) -> None:
    """Name the newest result of its scene."""
    _write_whole(folder.parent / LATEST, f"{folder.name}\n")


def final_folder(name: str, out: str | Path | None = None, root: Path | None = None) -> Path:
    """Where the results of a run go. InputError if `out` holds something already."""
    if out is not None:
        if is_regular_file(Path(out)) or names_beside(Path(out) / "any"):
            raise InputError(
                f"{shown(out)}: exists and is not an empty folder. Choose another --out; nothing is overwritten."
            )
        final = writable_folder(out)
        if final.exists() and final.samefile("."):
            raise InputError(f"{shown(out)}: is the working folder. Choose another --out.")
        return final
    parent = (root or Path("runs")) / name
    stamp = time.strftime("%Y-%m-%d_%H-%M-%S")
    final, count = parent / stamp, 1
    while final.exists():
        count += 1
        final = parent / f"{stamp}_{count}"
    return final


def find_run(name: str | Path, root: Path | None = None) -> Path:
    """The folder of a run: the folder itself, or the newest one of a scene.

    Raises
    ------
    InputError : there is none
    """
    folder = Path(name)
    if is_regular_file(folder / RESPONSE):
        return folder
    scene = (root or Path("runs")) / str(name).removesuffix(".toml")
    for parent in (scene, folder):
        latest = parent / LATEST
        if is_regular_file(latest):
            found = parent / read_text(latest, _LONGEST_NAME).strip()
            if is_regular_file(found / RESPONSE):
                return found
            raise InputError(
                f"{shown(found)}: no {RESPONSE} here, though {shown(latest)} names it. "
                f"Again: gearcase run {shown(name)}"
            )
    raise InputError(
        f"{shown(name)}: no result here, neither {shown(folder / RESPONSE)} nor {shown(scene / LATEST)}. "
        f"First: gearcase run {shown(name)}"
    )


def read_run(path: Path) -> xarray.Dataset:
    """The signals of a run, from its response or that of its control.

    Raises
    ------
    InputError : the file is damaged, or none of ours
    """
    import xarray

    try:
        with xarray.open_dataset(regular_file(path), engine="h5netcdf") as data:
            found = data.load()
    except (OSError, ValueError, KeyError, TypeError, RuntimeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{shown(path)}: cannot be read as signals ({error}). Run the scene again.") from error
    if "time" not in found.dims:
        raise InputError(f"{shown(path)}: holds no signals over time. Run the scene again.")
    return found


def write_json(path: Path, content: Any) -> None:
    """Write readable JSON, UTF-8."""
    path.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


class JsonLines(logging.Handler):
    """Log records as lines of JSON: time, level, logger, message."""

    def __init__(self, path: Path) -> None:
        super().__init__(logging.INFO)
        self._file = open(path, "w", encoding="utf-8")  # noqa: SIM115 - closed with the handler

    def emit(self, record: logging.LogRecord) -> None:
        """Write one line."""
        line = {
            "time": round(record.created, 3),
            "level": record.levelname,
            "logger": record.name,
            "message": record.getMessage(),
        }
        self._file.write(json.dumps(line | getattr(record, "facts", {}), ensure_ascii=False) + "\n")
        self._file.flush()

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


def _write_whole(path: Path, text: str) -> None:
    partial = path.with_name(f"{path.name}.{os.getpid()}")
    partial.write_text(text, encoding="utf-8")
    os.replace(partial, path)


def _sweep(parent: Path) -> None:
    """Remove what killed runs left here."""
    import psutil

    for left in parent.glob(f"{_PARTIAL}*"):
        number = left.name.rpartition("-")[2]
        if not (number.isdecimal() and psutil.pid_exists(int(number))):
            shutil.rmtree(left, ignore_errors=True)
