"""Files that a scene names: beside the scene, or shipped in the package `meshes`."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from pipelines.errors import InputError


def anchored(tree: dict[str, Any], folder: Path | None) -> dict[str, Any]:
    """The tree of a scene file with `casing.housing.file` made a full path, where that file lies beside the scene."""
    try:
        name = tree["casing"]["housing"]["file"]
    except (KeyError, TypeError):
        return tree
    if folder is None or not isinstance(name, str) or not (folder / name).is_file():
        return tree
    housing = {**tree["casing"]["housing"], "file": str((folder / name).resolve())}
    return {**tree, "casing": {**tree["casing"], "housing": housing}}


def find_file(name: str) -> Path:
    """The file called `name`: a path (from the current folder), or a shipped mesh.

    Raises
    ------
    InputError : no such file; names the shipped ones
    """
    if (path := Path(name)).is_file():
        return path.resolve()
    shipped = _shipped()
    if name in shipped:
        return shipped[name]
    beside = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
    near = difflib.get_close_matches(path.name, [*shipped, *beside], n=1)
    hint = f"Did you mean {near[0]}? " if near else ""
    raise InputError(
        f"{name}: no such file. {hint}Give a path from the folder of the scene, or a shipped file: "
        f"{', '.join(shipped)}."
    )


def _shipped() -> Mapping[str, Path]:
    folder = Path(str(resources.files("meshes")))
    return {p.name: p for p in sorted(folder.iterdir()) if p.suffix in (".step", ".msh")}
