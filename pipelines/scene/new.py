"""``gearcase new``: one commented scene file that stands alone, made of a shipped scene and what it extends."""

from __future__ import annotations

import itertools
import logging
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipelines.border.errors import InputError
from pipelines.border.shown import shown
from pipelines.border.toml_text import Statement, TomlError, equals_place, format_document, read_toml, statements
from pipelines.border.user_files import checked_path
from pipelines.scene.file import WITHOUT_FAULTS, Source, find_source, load_scene, parse, read_tree
from pipelines.scene.merge import leaves

_LOG = logging.getLogger(__name__)


def new_scene(target: str | Path, source: str = "rig-healthy") -> Path:
    """Write a copy of a scene, comments included, that extends nothing; an existing file is never overwritten.

    Raises
    ------
    InputError : `target` does not end in .toml, exists, or its folder cannot be written
    SceneError : the source is not valid
    """
    path, name = checked_path(target), shown(target)
    if path.suffix != ".toml":
        raise InputError(f"{name}: a scene file ends in .toml. Write gearcase new {path.stem or 'my'}.toml.")
    loaded = load_scene(source)
    text = _own_control(standalone_text(loaded.source, loaded.tree))
    try:
        with open(path, "x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        raise InputError(f"{name}: exists already and is not overwritten. Choose another name.") from None
    except OSError as error:
        raise InputError(f"{name}: cannot be written ({os.strerror(error.errno or 0)}). Choose a folder.") from error
    return path


def standalone_text(source: Source, tree: Mapping[str, Any]) -> str:
    """The text of `source` without ``extends``; it reads as `tree`, the merged tree after validation.

    If the comments cannot be kept in their places (a whole array of tables is replaced by a variant), the values
    win and the text is written without comments.
    """
    text = _flattened(source, tree)
    try:
        if read_toml(text) == tree:
            return text
    except TomlError as error:
        _LOG.debug("%s: merging texts failed: %s", source.shown, error)
    return format_document(tree)


def _flattened(source: Source, tree: Mapping[str, Any]) -> str:
    base = parse(source).get("extends")
    if not isinstance(base, str):
        return source.text
    below = find_source(base, source.folder)
    return _laid_over(_flattened(below, read_tree(below).tree), source, tree)


def _laid_over(base_text: str, source: Source, tree: Mapping[str, Any]) -> str:
    """The text below with the values of a variant put in place, their comments included."""
    below, above = list(statements(base_text)), list(statements(source.text))
    changes = {(*s.table, *s.key): s for s in above if s.key and s.key != ("extends",)}
    kept = leaves(tree)
    out: list[Statement] = []
    for statement in below:
        path = (*statement.table, *statement.key)
        if statement.key and path in changes:
            text = statement.text[: equals_place(statement.text)] + _right_side(changes.pop(path))
            out.append(Statement(text, statement.table, statement.key))
        elif not statement.key or any(leaf[: len(path)] == path for leaf in kept):
            out.append(statement)
    for statement in changes.values():
        _insert(out, statement)
    present = {s.table for s in out}
    added = [s for s in above if s.table and s.table not in present]
    head = itertools.takewhile(lambda s: s.text.lstrip().startswith("#"), above)
    text = "".join(s.text for s in (*head, *out))
    if added:
        text = text.rstrip("\n") + "\n\n" + "".join(s.text for s in added).strip("\n") + "\n"
    return text


def _insert(out: list[Statement], statement: Statement) -> None:
    """After the last key of the same table; a table that `out` does not have is added later as a whole."""
    same = [n for n, s in enumerate(out) if s.table == statement.table and (s.key or s.text.lstrip().startswith("["))]
    if same:
        out.insert(same[-1] + 1, statement)
    elif not statement.table:
        out.insert(0, statement)


def _right_side(statement: Statement) -> str:
    return statement.text[equals_place(statement.text) :]


def _own_control(text: str) -> str:
    """The copy is meant to be changed, so its healthy twin must follow it."""
    parts = [
        Statement(f'control = "{WITHOUT_FAULTS}"    # healthy twin: this scene without its faults\n', (), s.key)
        if (s.table, s.key) == ((), ("control",))
        else s
        for s in statements(text)
    ]
    return "".join(part.text for part in parts)
