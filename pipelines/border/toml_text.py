"""Write TOML, and edit TOML text so that its comments stay (the standard library only reads it)."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

DEEPEST = 32  # keys in one path, and tables within tables
_KEY_PART = r"""(?:[A-Za-z0-9_-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"""(?<![\w"'-])(?:{_KEY_PART}[ \t]*+\.[ \t]*+){{{DEEPEST}}}""")
_BARE_KEY = re.compile(r"^[A-Za-z0-9_-]+$")
_HEADER = re.compile(r"^\s*(\[\[?)\s*([^\[\]]+?)\s*\]\]?\s*(#.*)?$")
_TEXT_OR_COMMENT = re.compile(r'"(?:[^"\\\n]|\\.)*+"|' + r"'[^'\n]*+'|#[^\n]*+")


class TomlError(ValueError):
    """A text is not valid TOML."""


class TomlLimitError(TomlError):
    """A text may be TOML, but with more than we read: keys of many parts, deep nesting, long numbers."""


def read_toml(text: str) -> dict[str, Any]:
    """The tree of a TOML text. The time is bounded: a key of many parts would take that of their number squared.

    Raises
    ------
    TomlError : where and why it cannot be read
    TomlLimitError : what is beyond a limit
    """
    if found := _LONG_KEY.search(text):
        line = text.count("\n", 0, found.start()) + 1
        raise TomlLimitError(f"a key of more than {DEEPEST} parts (line {line})")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise TomlError(str(error)) from error
    except RecursionError:
        raise TomlLimitError("lists or tables are nested too deep") from None
    except ValueError as error:  # a whole number of thousands of digits
        raise TomlLimitError("a whole number has too many digits; 64 bits are read") from error


def format_value(value: Any) -> str:
    """One TOML value. Floats are written so that reading gives the same bits."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value) if value.bit_length() < 1000 else hex(value)  # Python writes no number of 4300 digits
    if isinstance(value, float):
        if not math.isfinite(value):
            return {math.inf: "inf", -math.inf: "-inf"}.get(value, "nan")
        text = repr(value)
        return text if any(c in text for c in ".en") else text + ".0"
    if isinstance(value, str):
        return '"' + "".join(_escaped(c) for c in value) + '"'
    if isinstance(value, list | tuple):
        return "[" + ", ".join(format_value(item) for item in value) + "]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{format_key(k)} = {format_value(v)}" for k, v in value.items()) + "}"
    return format_value(str(value))


def format_key(key: str) -> str:
    """A key, quoted where TOML asks for it."""
    return key if _BARE_KEY.match(key) else format_value(key)


def format_document(tree: Mapping[str, Any], prefix: str = "") -> str:
    """A whole document: plain values first, then tables, then arrays of tables. None is left out."""
    plain, tables, arrays = [], [], []
    for key, value in tree.items():
        if value is None:
            continue
        if isinstance(value, Mapping):
            tables.append((key, value))
        elif isinstance(value, list | tuple) and value and all(isinstance(item, Mapping) for item in value):
            arrays.append((key, value))
        else:
            plain.append(f"{format_key(key)} = {format_value(_without_none(value))}\n")
    parts = ["".join(plain)]
    for key, table in tables:
        path = prefix + format_key(key)
        body = format_document(table, path + ".")
        needs_header = not table or not body.startswith("[")
        parts.append(f"[{path}]\n{body}" if needs_header else body)
    for key, items in arrays:
        path = prefix + format_key(key)
        parts.extend(f"[[{path}]]\n{format_document(item, path + '.')}" for item in items)
    return "\n".join(part for part in parts if part)


def _without_none(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return [_without_none(item) for item in value]
    if isinstance(value, Mapping):
        return {k: _without_none(v) for k, v in value.items() if v is not None}
    return value


def _escaped(char: str) -> str:
    named = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r"}
    if char in named:
        return named[char]
    return f"\\u{ord(char):04x}" if ord(char) < 0x20 or ord(char) == 0x7F else char


@dataclass
class Statement:
    """A piece of TOML text that is kept together: a header, ``key = value`` (one or more lines), or other text."""

    text: str  # with the line end
    table: tuple[str, ...]  # the table it stands in; items of arrays of tables are counted from 1
    key: tuple[str, ...] = ()  # the dotted key of ``key = value``, else empty


def statements(text: str) -> Iterator[Statement]:
    """Cut valid TOML text into statements, in order; joining their texts gives the text back."""
    table: tuple[str, ...] = ()
    counts: dict[tuple[str, ...], int] = {}
    pending, open_brackets, long_text = "", 0, False
    for line in text.splitlines(keepends=True):
        if not pending and (not line.strip() or line.lstrip().startswith("#")):
            yield Statement(line, table)
            continue
        header = None if pending else _HEADER.match(line)
        if header:
            table = _item_path(_key_path(header[2]), counts, is_array=header[1] == "[[")
            yield Statement(line, table)
            continue
        pending += line
        long_text = long_text or '"""' in line or "'''" in line
        open_brackets += _opened(line)
        if open_brackets > 0 and not long_text:
            continue  # a list or table goes on; trying each of its lines would take the square of their number
        try:
            parsed = read_toml(pending)
        except TomlError:
            continue  # the value goes on in the next line
        yield Statement(pending, table, _first_path(parsed, pending))
        pending, open_brackets, long_text = "", 0, False
    if pending:
        yield Statement(pending, table)


def _opened(line: str) -> int:
    """Brackets that a line opens, less those it closes; not those in texts and comments."""
    plain = _TEXT_OR_COMMENT.sub("", line)
    return sum(map(plain.count, "[{")) - sum(map(plain.count, "]}"))


def _item_path(path: tuple[str, ...], counts: dict[tuple[str, ...], int], *, is_array: bool) -> tuple[str, ...]:
    if is_array:
        counts[path] = counts.get(path, 0) + 1
        for deeper in [p for p in counts if len(p) > len(path) and p[: len(path)] == path]:
            del counts[deeper]  # arrays inside a new item start again
    out: tuple[str, ...] = ()
    for end in range(1, len(path) + 1):
        out += (path[end - 1],)
        if path[:end] in counts:
            out += (str(counts[path[:end]]),)
    return out


def _key_path(text: str) -> tuple[str, ...]:
    tree: Any = read_toml(f"{text} = 0")
    path: tuple[str, ...] = ()
    while isinstance(tree, dict):
        key, tree = next(iter(tree.items()))
        path += (key,)
    return path


def _first_path(parsed: dict[str, Any], text: str) -> tuple[str, ...]:
    place = equals_place(text)
    return _key_path(text[:place]) if place < len(text) else tuple(parsed)


def equals_place(text: str) -> int:
    """Index of the first "=" that is not in quotes; the length of the text if there is none."""
    quote = ""
    for place, char in enumerate(text):
        if quote:
            quote = "" if char == quote else quote
        elif char in "\"'":
            quote = char
        elif char == "=":
            return place
    return len(text)
