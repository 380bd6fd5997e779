"""A file that a scene names: what cannot be read is refused with the path of its key in the scene."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from pipelines.io.errors import InputError, Problem, SceneError
from pipelines.io.user_files import regular_file


def refused(path: str, message: str, remedy: str, value: str | None = None) -> SceneError:
    """What to raise for a key of the scene at ``path``, with the value that it has there."""
    return SceneError("scene", [Problem(path, message, remedy, None if value is None else f'"{value}"')])


@contextlib.contextmanager
def reading(file: Path, name: str, path: str, most_bytes: int) -> Iterator[None]:
    """While a file is read.

    Parameters
    ----------
    file, name : where it is, and its name in the scene
    path : of the table in the scene, for messages
    most_bytes : its greatest size

    Raises
    ------
    SceneError : no such file, no regular one, too large a one, or it cannot be read
    """
    try:
        regular_file(file, most_bytes)
        yield
    except FileNotFoundError:
        remedy = "Correct the path; it starts at the folder of the scene"
        raise refused(f"{path}.file", "there is no such file", remedy, name) from None
    except SceneError:
        raise
    except InputError as error:
        raise refused(f"{path}.file", str(error), "") from error
