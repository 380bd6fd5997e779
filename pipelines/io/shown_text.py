"""A user's text in our messages: on one line, bounded, without characters that a terminal obeys.

A key, a value or a file name may hold escape sequences, marks that turn the direction of writing, or a megabyte. What
cannot be printed is shown by its escape (``\\x1b``, ``\\u202e``), as Python's own `repr` does.
"""

from __future__ import annotations

import difflib
import itertools
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pipelines.io.toml_text import format_value

MOST_CHARACTERS = 200  # of one value
MOST_LINES = 20  # of one message
_LONGEST_LINE = 1000
_MOST_ITEMS = 20  # of a list or table that is shown
_MOST_NAMES = 1000  # that a word is compared with
_SHORTEST_BEGINNING = 3  # characters by which a name is recognised


def shown(text: str | Path, most: int = MOST_CHARACTERS) -> str:
    """A text on one line, what cannot be printed escaped, cut to `most` characters."""
    text = "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in str(text)[: most + 1])
    return text if len(text) <= most else text[: most - 3] + "..."


def shown_value(value: Any, most: int = MOST_CHARACTERS) -> str:
    """A value as it is written in a scene file, cut to `most` characters."""
    return shown(format_value(_brief(value, most)), most)


def message_text(text: str) -> str:
    """A whole message as it is written to the terminal: escaped, and at most 20 lines however it was made."""
    lines = text.split("\n")
    if len(lines) > MOST_LINES:
        lines = [*lines[: MOST_LINES - 1], f"  ... and {len(lines) - MOST_LINES + 1} more lines"]
    return "\n".join(shown(line, _LONGEST_LINE) for line in lines)


def nearest_name(word: str, names: Iterable[str], cutoff: float = 0.6) -> str:
    """The name that ends in `word`, the only one that begins so, the closest one, or ""; of at most 1000 names."""
    some = list(itertools.islice(names, _MOST_NAMES))
    ending = next((name for name in some if word and word in name.split("-")[1:]), "")
    begun = [name for name in some if len(word) >= _SHORTEST_BEGINNING and name.startswith(word)]
    close = difflib.get_close_matches(word[:MOST_CHARACTERS], some, n=1, cutoff=cutoff)
    return ending or (begun[0] if len(begun) == 1 else next(iter(close), ""))


def number_of(text: str | None) -> float:
    """A number from its text; nan if it is not a number."""
    try:
        return float(text or "")
    except ValueError:
        return math.nan


def duration(seconds: float) -> str:
    """A length of time in words."""
    if seconds < 120:
        return f"{1 if 0 < seconds < 1 else seconds:.0f} s"
    return f"{seconds / 60:.0f} minutes" if seconds < 7200 else f"{seconds / 3600:.1f} hours"


def _brief(value: Any, most: int) -> Any:
    """As much of a value as can be seen when it is cut, so that a long list is not written out whole."""
    if isinstance(value, str):
        return value[: most + 1]
    if isinstance(value, list | tuple):
        return [_brief(item, most) for item in value[:_MOST_ITEMS]] + (["..."] if len(value) > _MOST_ITEMS else [])
    if isinstance(value, Mapping):
        return {_brief(str(k), most): _brief(v, most) for k, v in itertools.islice(value.items(), _MOST_ITEMS)}
    return value
