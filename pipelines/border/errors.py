"""Errors that a command turns into one readable message and an exit code (2: the input, 1: the work)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fem.storage.cache_folder import CacheWarning as CacheWarning
from pipelines.border.shown import MOST_LINES, shown


class InputError(ValueError):
    """Something the user gave cannot be used: a file, a folder, an option (exit code 2)."""


class WorkError(RuntimeError):
    """The input was fine, the work on it failed (exit code 1)."""


class SceneWarning(UserWarning):
    """A scene is computed otherwise than its files say, by what was set on top of them."""


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong in a scene: where, what, and what to do."""

    path: str  # "stages.1.face_width_mm"; "" for the scene as a whole
    message: str  # "must be greater than 0"
    remedy: str = ""  # "Give a number above 0."
    shown: str | None = None  # the value as written, None where there is none

    def __str__(self) -> str:
        """``path = value: message. Remedy.``"""
        path = shown(self.path)
        head = path if self.shown is None else f"{path} = {shown(self.shown)}"
        text = f"{head}: {self.message}" if head else self.message
        if self.remedy:
            text = f"{text.rstrip('.')}. {self.remedy}"
        return text


class SceneError(InputError):
    """A scene is not valid. `problems` lists what was found, not only the first; `unlisted` counts the others."""

    def __init__(self, source: str, problems: Sequence[Problem], unlisted: int = 0) -> None:
        self.source = source
        self.problems = tuple(problems)
        self.unlisted = unlisted
        number = len(self.problems) + unlisted
        lines = [f"  {problem}" for problem in self.problems[: MOST_LINES - 1]]
        if number > len(lines):
            lines = lines[: MOST_LINES - 2]
            lines.append(f"  and {number - len(lines)} more")
        count = "1 problem" if number == 1 else f"{number} problems"
        super().__init__("\n".join([f"{shown(source)}: {count}", *lines]))

    def __reduce__(self) -> tuple:
        return type(self), (self.source, self.problems, self.unlisted)
