"""Limits of a scene that is parsed: nesting, keys, texts, numbers. `pipelines.io.toml_text` limits the parsing itself.

The walk uses no recursion. Limits: nesting, length of keys and texts, characters that a terminal obeys, whole numbers
of 64 bits, which is what TOML has.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

from pipelines.io.errors import Problem
from pipelines.io.shown_text import shown_value
from pipelines.io.toml_text import DEEPEST

MOST_BYTES = 1_000_000  # of a scene file
LONGEST_CHAIN = 20  # scenes that extend one another
_LONGEST_KEY = 100  # characters
_LONGEST_TEXT = 1000
_MOST_TABLES = 1000  # in one list
_TURNING = frozenset("\u200e\u200f\u2028\u2029\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")

Path = tuple[str, ...]


def over_limits(tree: Any, path: Path = ()) -> list[Problem]:
    """Everything in the tree that is beyond a limit; `path` is where the tree stands in the scene."""
    found: list[Problem] = []
    waiting: deque[tuple[Path, Any]] = deque([(path, tree)])
    while waiting:
        place, value = waiting.popleft()
        if len(place) > DEEPEST:
            found.append(Problem(".".join(place), f"is nested deeper than {DEEPEST} keys", "Delete the outer tables."))
        elif isinstance(value, Mapping):
            for key, below in value.items():
                if wrong := _wrong_key(str(key)):
                    found.append(Problem(".".join((*place, str(key))), wrong, "Rename the key."))
                else:
                    waiting.append(((*place, str(key)), below))
        elif isinstance(value, list | tuple) and len(value) > _MOST_TABLES and isinstance(value[0], Mapping):
            message = f"has {len(value)} tables, more than {_MOST_TABLES}"
            found.append(Problem(".".join(place), message, "Delete some."))
        elif isinstance(value, list | tuple):
            waiting.extend(((*place, str(number)), item) for number, item in enumerate(value, 1))
        elif wrong_value := _wrong_value(value):
            found.append(Problem(".".join(place), *wrong_value))
    return found


def _wrong_key(key: str) -> str:
    if len(key) > _LONGEST_KEY:
        return f"a key has at most {_LONGEST_KEY} characters"
    return "a key must not have control characters" if _has_control(key) else ""


def _wrong_value(value: Any) -> tuple[str, ...]:
    """Message, remedy and value of a text or number beyond a limit; empty for another value."""
    if isinstance(value, str) and len(value) > _LONGEST_TEXT:
        return f"has {len(value)} characters, more than {_LONGEST_TEXT}", "Shorten it.", shown_value(value, 60)
    if isinstance(value, str) and _has_control(value):
        return "must be one line without control characters", "Write plain text.", shown_value(value, 60)
    if isinstance(value, int) and not -(2**63) <= value < 2**63:
        return "has more than 64 bits", "Reduce the number."
    return ()


def _has_control(text: str) -> bool:
    """Characters that a terminal obeys, that end a line, or that turn the direction of what follows."""
    if text.isascii() and text.isprintable():
        return False
    return any(ord(c) < 0x20 or 0x7F <= ord(c) < 0xA0 or 0xD800 <= ord(c) < 0xE000 or c in _TURNING for c in text)
