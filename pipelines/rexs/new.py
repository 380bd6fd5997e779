"""``gearcase new my.toml --from box.rexs``: a gear unit in the exchange format REXS as a commented scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pipelines.io.errors import SceneError
from pipelines.io.toml_text import read_toml
from pipelines.machine.layout import lay_out
from pipelines.rexs.document import RexsError
from pipelines.rexs.files import read_document
from pipelines.rexs.gear_unit import Note
from pipelines.rexs.reading import read_gear_unit
from pipelines.rexs.scene_text import SceneText, scene_text
from pipelines.scene.file import scene_of_tree
from pipelines.scene.new import write_scene


@dataclass(frozen=True)
class ImportedScene:
    """Where the scene was written, what it does not take from the file as it is, and keys that are still to give."""

    path: Path
    notes: tuple[Note, ...]
    missing: Mapping[str, str]


def new_scene_from_rexs(target: str | Path, source: str | Path) -> ImportedScene:
    """Write the scene of a REXS file; an existing file is never overwritten.

    Raises
    ------
    InputError : `target` does not end in .toml, exists, or cannot be written; the source cannot be read
    RexsError : what of the source no scene can hold
    """
    made = scene_text(read_gear_unit(read_document(source)), f"Gear unit of {Path(source).name}")
    if not made.missing:
        _checked(made, str(source))
    return ImportedScene(write_scene(target, made.text), made.notes, made.missing)


def _checked(made: SceneText, source: str) -> None:
    """Raise RexsError with what the validation of scenes refuses."""
    try:
        lay_out(scene_of_tree(read_toml(made.text), "rexs").scene, source)
    except SceneError as error:
        reasons = "; ".join(map(str, error.problems))
        raise RexsError(f"{source}: a scene cannot hold it: {reasons}") from error
