"""TOML read within limits, and written; values as messages show them."""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Mapping
from typing import Any

DEEPEST = 32  # keys in one path, and tables within tables
_KEY_PART = r"""(?:[A-Za-z0-9_-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"""(?<![\w"'-])(?:{_KEY_PART}[ \t]*+\.[ \t]*+){{{DEEPEST}}}""")
_BARE_KEY = re.compile(r"^[A-Za-z0-9_-]+$")


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
        raise TomlLimitError("a whole number has too many digits for 64 bits") from error


def format_value(value: Any) -> str:
    """One value on one line, whatever it is, as in TOML. Floats are written so that reading gives the same bits."""
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
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")  # which JSON does not escape
    if isinstance(value, list | tuple):
        return "[" + ", ".join(format_value(item) for item in value) + "]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_format_key(k)} = {format_value(v)}" for k, v in value.items()) + "}"
    return format_value(str(value))


def _format_key(key: str) -> str:
    """A key, quoted where TOML asks for it."""
    return key if _BARE_KEY.match(key) else format_value(key)


def format_document(tree: Mapping[str, Any], prefix: str = "") -> str:
    """A whole document: plain values first, then tables, then arrays of tables. None is left out.

    Not by tomlkit, which takes a minute for a list of 20,000 numbers: its time grows with their number squared.
    """
    plain, tables, arrays = [], [], []
    for key, value in tree.items():
        if value is None:
            continue
        if isinstance(value, Mapping):
            tables.append((key, value))
        elif isinstance(value, list | tuple) and value and all(isinstance(item, Mapping) for item in value):
            arrays.append((key, value))
        else:
            plain.append(f"{_format_key(key)} = {format_value(_without_none(value))}\n")
    parts = ["".join(plain)]
    for key, table in tables:
        path = prefix + _format_key(key)
        body = format_document(table, path + ".")
        needs_header = not table or not body.startswith("[")
        parts.append(f"[{path}]\n{body}" if needs_header else body)
    for key, items in arrays:
        path = prefix + _format_key(key)
        parts.extend(f"[[{path}]]\n{format_document(item, path + '.')}" for item in items)
    return "\n".join(part for part in parts if part)


def _without_none(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return [_without_none(item) for item in value]
    if isinstance(value, Mapping):
        return {k: _without_none(v) for k, v in value.items() if v is not None}
    return value
