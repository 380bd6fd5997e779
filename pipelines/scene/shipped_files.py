"""Files that a scene names: in the folder of the scene, or shipped in the package `meshes`."""

from __future__ import annotations

import os
from importlib import resources
from pathlib import Path
from typing import Any

from pipelines.io.errors import InputError
from pipelines.io.shown_text import nearest_name, shown
from pipelines.io.user_files import checked_path, is_regular_file, regular_file, sibling_names

_MOST_BYTES = 1_000_000_000  # of a STEP file or a mesh


def anchored(tree: dict[str, Any], folder: Path | None) -> dict[str, Any]:
    """The tree of a scene file with the full path for every `file` that is in the folder of the scene."""

    def walked(value: Any) -> Any:
        if isinstance(value, list):
            return [walked(item) for item in value]
        if not isinstance(value, dict):
            return value
        return {key: full(item) if key == "file" else walked(item) for key, item in value.items()}

    def full(name: Any) -> Any:
        in_folder = folder is not None and isinstance(name, str) and is_regular_file(folder / name)
        return os.path.realpath(folder / name) if in_folder and folder is not None else name

    return walked(tree)


def find_file(name: str) -> Path:
    """The file of a name: a path (from the current folder), or a shipped mesh.

    Raises
    ------
    InputError : there is no such file (the message names the shipped ones), or it cannot be read
    """
    path, meshes = checked_path(name), Path(str(resources.files("meshes")))
    shipped = {p.name: p for p in sorted(meshes.iterdir()) if p.suffix in (".step", ".msh")}
    if name in shipped and not is_regular_file(path):
        return shipped[name]
    try:
        return Path(os.path.realpath(regular_file(path, _MOST_BYTES)))
    except FileNotFoundError:
        near = nearest_name(path.name, [*shipped, *sibling_names(path)])
    hint = f"Did you mean {shown(near)}? " if near else ""
    raise InputError(
        f"{shown(name)}: there is no such file. {hint}Set a path (in a scene: relative to its folder), or a shipped "
        f"file: {', '.join(shipped)}."
    )
