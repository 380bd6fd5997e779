"""``gearcase new my.toml --from box.rexs``: a gear unit in the exchange format REXS as a commented scene."""

from __future__ import annotations

from pathlib import Path

from pipelines.io.errors import SceneError
from pipelines.io.toml_text import read_toml
from pipelines.machine.layout import lay_out
from pipelines.rexs.document import RexsError
from pipelines.rexs.files import read_document
from pipelines.rexs.gear_unit_reading import read_gear_unit
from pipelines.rexs.scene_text import SceneText, scene_text
from pipelines.scene.load_scene import scene_of_tree
from pipelines.scene.new import write_scene


def new_scene_from_rexs(target: str | Path, source: str | Path) -> tuple[Path, SceneText]:
    """Write the scene of a REXS file; an existing file is never overwritten. Its path and its text with notes.

    Raises
    ------
    InputError : `target` does not end in .toml, exists, or cannot be written; the source cannot be read
    RexsError : what of the source no scene can hold
    """
    made = scene_text(read_gear_unit(read_document(source)), f"Gear unit of {Path(source).name}")
    try:
        if not made.missing:
            lay_out(scene_of_tree(read_toml(made.text), "rexs").scene, str(source))
    except SceneError as error:
        reasons = "; ".join(map(str, error.problems))
        raise RexsError(f"{source}: a scene cannot hold it: {reasons}") from error
    return write_scene(target, made.text), made
