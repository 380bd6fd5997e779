"""Scenes: the input of all functions, in engineers' units, and its check."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fem.storage import shown_html
from gearcase.argument_checks import checked_file, refusal
from pipelines.io.toml_text import format_value
from pipelines.runs.checked_scene import Checked, check_scene
from pipelines.scene.load_scene import LoadedScene, changed, load_scene, scene_of_tree
from pipelines.scene.merge import leaves
from pipelines.scene.presets import preset_on

__all__ = ["Checked", "Scene", "check"]

Settings = Mapping[str, Any] | Iterable[str]


@dataclass(frozen=True, eq=False, repr=False)
class Scene:
    """A valid scene: the input of a computation. All keys with their units are in docs/scene-keys.md.

    Make one by `from_file` or `from_dict`, and a modified copy by `changed`; a scene itself never changes.

    >>> import gearcase
    >>> scene = gearcase.Scene.from_file("minimal")
    >>> scene
    <Scene minimal: One stage, rigid casing, constant torque>
    >>> scene.changed(load={"container_kg": 80}).to_dict()["load"]["container_kg"]
    80
    """

    loaded: LoadedScene  # internal

    @classmethod
    def from_file(cls, source: str | Path) -> Scene:
        """Read a scene from a file ending in .toml, or a shipped scene by its name.

        Raises
        ------
        SceneError, InputError : all errors of the scene

        >>> import gearcase
        >>> gearcase.Scene.from_file("rig-missing-tooth").name
        'rig-missing-tooth'
        """
        return cls(load_scene(checked_file("source", source, "a scene file, or the name of a shipped scene")))

    @classmethod
    def from_dict(cls, tables: Mapping[str, Any], *, name: str = "scene") -> Scene:
        """Make a scene from its tables, as in a scene file; the key ``extends`` names a scene to start from.

        Raises
        ------
        SceneError, InputError : all errors of the scene

        >>> import gearcase
        >>> gearcase.Scene.from_dict({"extends": "minimal", "load": {"container_kg": 80}}, name="light").name
        'light'
        """
        if not isinstance(tables, Mapping):
            raise refusal("tables", tables, "the tables of a scene", 'Give a dict such as {"extends": "minimal"}.')
        return cls(scene_of_tree(tables, name))

    def changed(self, settings: Settings = (), *, preset: str | None = None, **tables: Any) -> Scene:
        """Return a copy of this scene with changed values.

        Parameters
        ----------
        settings : by path, {"stages.1.face_width_mm": 32}, or as on the command line, ["stages.1.face_width_mm=32"]
        preset : accuracy "draft", "standard" or "reference"; values of the scene override it
        tables : by table, load={"container_kg": 80}; other keys are unchanged

        Raises
        ------
        SceneError : all errors of the values

        >>> import gearcase
        >>> gearcase.Scene.from_file("minimal").changed({"stages.1.face_width_mm": -1})
        Traceback (most recent call last):
        ...
        pipelines.io.errors.SceneError: scene minimal: 1 problem
          stages.1.face_width_mm = -1: must be greater than 0 mm. Correct the value.
        """
        if isinstance(settings, str) or not isinstance(settings, Iterable):
            raise refusal("settings", settings, "a dict or a list", 'Give {"stages.1.face_width_mm": 32}.')
        base = self.loaded if preset is None else preset_on(self.loaded, preset)
        return Scene(changed(base, settings, tables))

    @property
    def name(self) -> str:
        """Name of the scene, and of the folder of its results."""
        return self.loaded.name

    @property
    def title(self) -> str:
        """Title of the scene in every result."""
        return self.loaded.scene.title

    def to_dict(self) -> dict[str, Any]:
        """The given tables, without defaults."""
        return dict(self.loaded.tree)

    def to_toml(self) -> str:
        """The text of a scene file with all defaults."""
        return self.loaded.resolved()

    def __repr__(self) -> str:
        return f"<Scene {self.name}: {self.title}>"

    def _repr_html_(self) -> str:
        """The given keys with their values, for a notebook."""
        given = ((".".join(map(str, path)), format_value(value)) for path, value in leaves(self.loaded.tree).items())
        return shown_html.table(f"{self.name}: {self.title}", ("key", "value"), given)


def loaded_scene(scene: Scene) -> LoadedScene:
    """The scene in its internal form; InputError for anything else than a `Scene`."""
    if not isinstance(scene, Scene):
        raise refusal("scene", scene, "a gearcase.Scene", "Give what gearcase.Scene.from_file or from_dict returns.")
    return scene.loaded


def check(scene: Scene) -> Checked:
    """Check a scene before a run: ratios, frequencies, forces; time and memory of the run; warnings.

    Raises
    ------
    SceneError, InputError : the scene cannot be run

    >>> import gearcase
    >>> found = gearcase.check(gearcase.Scene.from_file("minimal"))
    >>> print(f"{found.facts.stages[0].mesh_frequency:.1f} Hz, {found.facts.stages[0].mesh_force:.0f} N")
    300.0 Hz, 1061 N
    """
    return check_scene(loaded_scene(scene))
