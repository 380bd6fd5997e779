"""``gearcase new``: one commented scene file that stands alone, made of a shipped scene and what it extends."""

from __future__ import annotations

import itertools
import logging
import os
from collections.abc import Mapping, MutableMapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.io.toml_text import TomlError, format_document, read_toml
from pipelines.io.user_files import checked_path
from pipelines.scene.load_scene import WITHOUT_FAULTS, Source, find_source, load_scene

if TYPE_CHECKING:
    from tomlkit import TOMLDocument

_LOG = logging.getLogger(__name__)
_MOST_COMMENTED = 100_000  # characters of a text whose comments are kept: it takes some 10 us for each


def new_scene(target: str | Path, source: str = "bench") -> Path:
    """Write a copy of a scene, comments included, that extends nothing; an existing file is never overwritten.

    Raises
    ------
    InputError : `target` does not end in .toml, exists, or its folder cannot be written
    SceneError : the source is not valid
    """
    path = _target(target)
    loaded = load_scene(source)
    return write_scene(path, standalone_text(loaded.source, loaded.tree))


def write_scene(target: str | Path, text: str) -> Path:
    """Write the text of a scene; an existing file is never overwritten.

    Raises
    ------
    InputError : `target` does not end in .toml, exists, or its folder cannot be written
    """
    path, name = _target(target), shown(target)
    try:
        with open(path, "x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        raise InputError(
            f"{name}: exists already and is not overwritten. Set another name, or delete the file."
        ) from None
    except OSError as error:
        raise InputError(
            f"{name}: cannot be written ({os.strerror(error.errno or 0)}). Set a path in a folder that you may write "
            "to."
        ) from error
    return path


def _target(target: str | Path) -> Path:
    path = checked_path(target)
    if path.suffix != ".toml":
        raise InputError(
            f"{shown(target)}: the name of a scene file must end in .toml. Write: gearcase new {path.stem or 'my'}.toml"
        )
    return path


def standalone_text(source: Source, tree: Mapping[str, Any]) -> str:
    """The text of `source` without ``extends``; it reads as `tree`, the merged tree after validation, but its control
    is the scene itself without faults: the copy is meant to be changed, and its healthy control must follow it.

    If the comments cannot be kept in their places (a whole array of tables is replaced by a variant), the values
    win and the text is written without comments.
    """
    wanted = {**tree, "control": WITHOUT_FAULTS} if "control" in tree else dict(tree)
    if len(source.text) <= _MOST_COMMENTED:
        try:
            text = _commented(source, wanted)
            if read_toml(text) == wanted:
                return text
        except (TomlError, ValueError, TypeError, KeyError, IndexError) as error:
            _LOG.debug("%s: its comments cannot be kept: %r", source.shown, error)
    return format_document(wanted)


def _commented(source: Source, wanted: Mapping[str, Any]) -> str:
    """What `source` extends, with its own values and comments laid over it."""
    import tomlkit

    document, heads = _flattened(source)
    _prune(document, wanted)
    if "control" in wanted:
        document["control"] = tomlkit.item(WITHOUT_FAULTS).comment("healthy control: this scene without its faults")
    return "".join(heads) + tomlkit.dumps(document).lstrip("\n")


def _flattened(source: Source) -> tuple[TOMLDocument, list[str]]:
    """The document, and the comments at the head of each text that was laid over another."""
    import tomlkit

    document = tomlkit.parse(source.text)
    base = document.pop("extends", None)
    if base is None:
        return document, []
    below, heads = _flattened(find_source(str(base), source.folder))
    _lay_over(below, document)
    lines = source.text.splitlines(keepends=True)
    head = itertools.takewhile(lambda line: line.startswith("#") or not line.strip(), lines)
    return below, ["".join(head).rstrip("\n") + f"\n#\n# From the scene that it extends, {base}:\n", *heads]


def _lay_over(below: Any, above: Any) -> None:
    """Put the values of `above` in the places of those below, with their comments; see `pipelines.scene.merge`."""
    for key, value in above.items():
        old = below.get(key)
        if isinstance(value, Mapping) and isinstance(old, list) and all(str(number).isdecimal() for number in value):
            for number, item in value.items():
                _lay_over(old[int(number) - 1], item)
        elif isinstance(value, Mapping) and isinstance(old, Mapping):
            _lay_over(old, value)
            _take_comment(old, value)
        else:
            below[key] = value


def _take_comment(old: Any, new: Any) -> None:
    if new.trivia.comment:
        old.trivia.comment_ws, old.trivia.comment = new.trivia.comment_ws, new.trivia.comment


def _prune(document: MutableMapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """Take out what a model that was switched to does not know."""
    for key in list(document):
        if key not in wanted:
            del document[key]
        elif isinstance(document[key], Mapping):
            _prune(document[key], wanted[key])
        elif isinstance(document[key], list):
            for item, other in zip(document[key], wanted[key], strict=True):
                if isinstance(item, MutableMapping):
                    _prune(item, other)
