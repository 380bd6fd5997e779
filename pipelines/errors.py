"""Errors that a command turns into one readable message and an exit code (2: the input, 1: the work)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fem.cache_folder import CacheWarning as CacheWarning


class InputError(ValueError):
    """Something the user gave cannot be used: a file, a folder, an option (exit code 2)."""


class WorkError(RuntimeError):
    """The input was fine, the work on it failed (exit code 1)."""


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong in a scene: where, what, and what to do."""

    path: str  # "stages.1.face_width_mm"; "" for the scene as a whole
    message: str  # "must be greater than 0"
    remedy: str = ""  # "Give a number above 0."
    shown: str | None = None  # the value as written, None where there is none

    def __str__(self) -> str:
        """``path = value: message. Remedy.``"""
        head = self.path if self.shown is None else f"{self.path} = {self.shown}"
        text = f"{head}: {self.message}" if head else self.message
        if self.remedy:
            text = f"{text.rstrip('.')}. {self.remedy}"
        return text


class SceneError(InputError):
    """A scene is not valid. `problems` lists everything that was found, not only the first."""

    def __init__(self, source: str, problems: Sequence[Problem]) -> None:
        self.source = source
        self.problems = tuple(problems)
        count = "1 problem" if len(self.problems) == 1 else f"{len(self.problems)} problems"
        super().__init__("\n".join([f"{source}: {count}", *(f"  {problem}" for problem in self.problems)]))

    def __reduce__(self) -> tuple:
        return type(self), (self.source, self.problems)
