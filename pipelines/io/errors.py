"""Errors of the input (exit code 2) and of the computation (1), and `Problems`, which collects all of a scene."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from fem.storage.cache_folder import CacheWarning as CacheWarning
from pipelines.io.shown_text import MOST_LINES, shown


class InputError(ValueError):
    """A file, folder or option that the user gave cannot be used (exit code 2)."""


class WorkError(RuntimeError):
    """The computation failed although the input is valid (exit code 1)."""


class SceneWarning(UserWarning):
    """A scene is not computed as its files state, because of settings that override them."""


@dataclass(frozen=True)
class Problem:
    """One error of a scene: its key, what is wrong, and what to do."""

    path: str  # "stages.1.face_width_mm"; "" for the scene as a whole
    message: str  # "must be greater than 0"
    remedy: str = ""  # "Give a number above 0."
    shown: str | None = None  # the value as written; None if there is none

    def __str__(self) -> str:
        """``path = value: message. Remedy.``"""
        path = shown(self.path)
        head = path if self.shown is None else f"{path} = {shown(self.shown)}"
        text = f"{head}: {self.message}" if head else self.message
        if self.remedy:
            text = f"{text.rstrip('.')}. {self.remedy}"
        return text if text.endswith("?") else f"{text.rstrip('.')}."


def problem_of(path: str, line: str) -> Problem:
    """The error of a part in one line as a problem of its table; "key = value: ..." is a problem of that key."""
    found = re.match(r'([a-z]\w*) = (".*?"|\S+): (.+)', line)
    if found is None:
        return Problem(path, line)
    key, value, message = found.groups()
    return Problem(f"{path}.{key}" if path else key, message, shown=value)


class SceneError(InputError):
    """A scene is not valid. `problems` are all that were found; `unlisted` is the number of further ones."""

    def __init__(self, source: str, problems: Sequence[Problem], unlisted: int = 0) -> None:
        self.source = source
        self.problems = tuple(dict.fromkeys(problems))
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


class Problems(list[Problem]):
    """Problems of a scene, collected while its parts are made.

    Parameters
    ----------
    *refusals : classes of the errors that parts raise for a value that is not allowed
    """

    def __init__(self, *refusals: type[Exception]) -> None:
        super().__init__()
        self._refusals = refusals

    def made(self, path: str, make: Callable[..., Any], *arguments: Any) -> Any:
        """Result of a function; None if it raises one of the errors, which becomes a problem of the table at a path."""
        try:
            return make(*arguments)
        except SceneError as error:
            self += error.problems
        except self._refusals as error:
            self += [problem_of(path, line) for line in str(error).splitlines()]
        return None

    def each(self, path: str, makes: Iterable[Callable[[], Any]]) -> tuple[Any, ...]:
        """Results of functions, one for each table of a list at a path, without those that raise an error."""
        found = [self.made(f"{path}.{number}", make) for number, make in enumerate(makes, 1)]
        return tuple(one for one in found if one is not None)

    def error(self, source: str) -> SceneError:
        """An error with all problems of the scene of name `source`."""
        return SceneError(source, list(dict.fromkeys(self)))
