"""Scene: the input of everything, in engineers' units; `check` says what follows from it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fem.storage import shown_html
from gearcase.given import checked_file, refusal
from pipelines.io.toml_text import format_value
from pipelines.runs.checked import Checked, check_scene
from pipelines.scene.file import LoadedScene, changed, load_scene, scene_of_tree
from pipelines.scene.merge import leaves
from pipelines.scene.presets import preset_on

__all__ = ["Checked", "Scene", "check"]

Settings = Mapping[str, Any] | Iterable[str]


@dataclass(frozen=True, eq=False, repr=False)
class Scene:
    """A valid scene. All keys with their units are in docs/scene-keys.md.

    Make one by `from_file` or `from_dict`, and another one by `changed`; a scene itself never changes.

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
        """A scene from a file ending in .toml, or a shipped one by its name.

        Raises
        ------
        SceneError, InputError : everything that is wrong with it

        >>> import gearcase
        >>> gearcase.Scene.from_file("rig-missing-tooth").name
        'rig-missing-tooth'
        """
        return cls(load_scene(checked_file("source", source, "a scene file, or the name of a shipped scene")))

    @classmethod
    def from_dict(cls, tables: Mapping[str, Any], *, name: str = "scene") -> Scene:
        """A scene from its tables, as they would stand in a file; ``extends`` names a scene to start from.

        Raises
        ------
        SceneError, InputError : everything that is wrong with it

        >>> import gearcase
        >>> gearcase.Scene.from_dict({"extends": "minimal", "load": {"container_kg": 80}}, name="light").name
        'light'
        """
        if not isinstance(tables, Mapping):
            raise refusal("tables", tables, "the tables of a scene", 'Give a dict such as {"extends": "minimal"}.')
        return cls(scene_of_tree(tables, name))

    def changed(self, settings: Settings = (), *, preset: str | None = None, **tables: Any) -> Scene:
        """This scene with other values.

        Parameters
        ----------
        settings : by path, {"stages.1.face_width_mm": 32}, or as on the command line, ["stages.1.face_width_mm=32"]
        preset : "draft", "standard" or "reference": how finely it is computed; values that are given count more
        tables : by table, load={"container_kg": 80}; the keys that are not given stay

        Raises
        ------
        SceneError : everything that is wrong with the values

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
        """Of the folder of its results."""
        return self.loaded.name

    @property
    def title(self) -> str:
        """The line that names it in every result."""
        return self.loaded.scene.title

    def to_dict(self) -> dict[str, Any]:
        """The tables that were given, without defaults."""
        return dict(self.loaded.tree)

    def to_toml(self) -> str:
        """The text of a scene file with every default written out."""
        return self.loaded.resolved()

    def __repr__(self) -> str:
        return f"<Scene {self.name}: {self.title}>"

    def _repr_html_(self) -> str:
        """The keys that were given with their values, for a notebook."""
        given = ((".".join(map(str, path)), format_value(value)) for path, value in leaves(self.loaded.tree).items())
        return shown_html.table(f"{self.name}: {self.title}", ("key", "value"), given)


def loaded_scene(scene: Scene) -> LoadedScene:
    """What a scene holds; InputError for anything else than a `Scene`."""
    if not isinstance(scene, Scene):
        raise refusal("scene", scene, "a gearcase.Scene", "Give what gearcase.Scene.from_file or from_dict returns.")
    return scene.loaded


def check(scene: Scene) -> Checked:
    """What follows from a scene before anything is computed: ratios, frequencies, forces; cost of a run; warnings.

    Raises
    ------
    SceneError, InputError : what a run would refuse

    >>> import gearcase
    >>> found = gearcase.check(gearcase.Scene.from_file("minimal"))
    >>> print(f"{found.facts.stages[0].mesh_frequency:.1f} Hz, {found.facts.stages[0].mesh_force:.0f} N")
    300.0 Hz, 1061 N
    """
    return check_scene(loaded_scene(scene))
