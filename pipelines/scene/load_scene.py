"""Loading of a scene: a TOML file, the scenes that it extends, and ``--set``; all errors are reported together."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipelines.io.errors import InputError, Problem, SceneError, SceneWarning
from pipelines.io.not_a_scene import refuse_other_file
from pipelines.io.shown_text import nearest_name, shown, shown_value
from pipelines.io.toml_text import TomlError, format_document, read_toml
from pipelines.io.user_files import checked_path, folder_name, read_text, sibling_names
from pipelines.scene.merge import Merged, Whole, differences, merge, settings_tree, without
from pipelines.scene.shipped_files import anchored
from pipelines.scene.tree_limits import LONGEST_CHAIN, MOST_BYTES, over_limits

if TYPE_CHECKING:
    from pydantic import BaseModel

    from pipelines.scene.scene import Scene

WITHOUT_FAULTS = "without-faults"  # control: the scene itself without its faults
_OWN_KEYS = ("title", "control", "faults")  # a scene and its control may differ in these, and in faults of shafts

Settings = Iterable[str] | Mapping[str, Any]


@dataclass(frozen=True)
class Source:
    """Source of the text of a scene: a file of the user, or a shipped scene."""

    name: str  # stem of the file or the shipped name
    text: str
    folder: Path | None  # of relative paths in `extends`; None for a shipped scene
    shown: str  # name in messages


@dataclass(frozen=True)
class LoadedScene:
    """A valid scene with its source and settings. `tree` is merged from both, without defaults."""

    name: str  # also that of the folder of its results
    source: Source
    settings: Mapping[str, Any]  # as a tree
    tree: Mapping[str, Any]
    scene: Scene

    def resolved(self, *, own_control: bool = False) -> str:
        """TOML text of the scene with all defaults, which loads as an equal scene.

        With `own_control` its control is the scene itself without faults. Use it if the named control differs in
        nothing else, since its settings are not part of the text.
        """
        values = self.scene.model_dump(mode="json", exclude_none=True)
        return format_document(values | ({"control": WITHOUT_FAULTS} if own_control else {}))

    def asked(self) -> str:
        """TOML text that the user gave: the source (a shipped one by its name), then the settings."""
        text = self.source.text if self.source.folder is not None else f'extends = "{self.source.name}"\n'
        if not self.settings:
            return text
        if self.source.folder is None:
            return text + "\n" + format_document(self.settings)
        lines = (line.replace(": (none) -> ", "=") for line in differences({}, self.settings))
        shown = "".join(f"# --set {line}\n" for line in lines)
        return f"{shown}{text}"


def load_scene(source: str | Path, settings: Settings = ()) -> LoadedScene:
    """Load and validate a scene.

    Parameters
    ----------
    source : a path ending in ``.toml``, or the name of a shipped scene
    settings : ``["stages.1.face_width_mm=32", ...]`` or ``{"stages.1.face_width_mm": 32}``

    Raises
    ------
    SceneError : with all problems of the file and of the settings
    InputError : the file is missing, not UTF-8, not TOML or of another kind, ``extends`` is circular, or the name of
        the scene cannot be that of a folder
    """
    return _loaded(find_source(source), *settings_tree(settings))


def scene_of_tree(tree: Mapping[str, Any], name: str = "scene") -> LoadedScene:
    """The scene of tables that are given in Python; relative paths are those of the working folder.

    Raises
    ------
    SceneError, InputError : as in `load_scene`
    """
    return _loaded(Source(name, format_document(plain(tree)), Path.cwd(), f"scene {shown(name)}"), {}, [])


def _loaded(source: Source, change: Mapping[str, Any], problems: list[Problem]) -> LoadedScene:
    merged = _shortened(read_tree(source), change, source.shown)
    return scene_of_merged(folder_name(source.name), source, change, merged, problems)


def scene_of_merged(
    name: str, source: Source, settings: Mapping[str, Any], merged: Merged, problems: Iterable[Problem] = ()
) -> LoadedScene:
    """The scene of a tree; errors as `validate`.

    Parameters
    ----------
    name, source : of the scene
    settings : that the tree holds
    merged : the tree
    problems : found before
    """
    from pipelines.scene.scene import Scene

    scene, tree = validate(merged, Scene, source.shown, problems)
    return LoadedScene(name, source, settings, tree, scene)


def changed(loaded: LoadedScene, settings: Settings, tables: Mapping[str, Any] | None = None) -> LoadedScene:
    """The scene with further settings, as paths with values, or as `tables` that are merged key by key.

    Raises
    ------
    SceneError : with all problems of the settings
    """
    change, problems = settings_tree(settings)
    if tables:
        problems += over_limits(plain(tables))
        change = merge(Merged(change), plain(tables)).tree
    merged = _shortened(Merged(dict(loaded.tree)), change, loaded.source.shown)
    both = merge(Merged(dict(loaded.settings)), change).tree
    return scene_of_merged(loaded.name, loaded.source, both, merged, problems)


def plain(value: Any) -> Any:
    """A value of Python or NumPy in types of TOML: dicts with text keys, lists, numbers."""
    if isinstance(value, Mapping):
        kind = Whole if isinstance(value, Whole) else dict
        return kind((str(key), plain(item)) for key, item in value.items())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return value.tolist() if hasattr(value, "tolist") else value


def control_of(loaded: LoadedScene) -> LoadedScene | None:
    """The healthy control that the scene names, with the same settings; None if it names none.

    The control ``"without-faults"`` is the scene itself without its faults, also those of its shafts. Any other control
    is a separate scene, to which all settings except those of title, control and faults are applied.
    """
    from pipelines.scene.scene import Scene
    from pipelines.scene.shaft_faults import without_shaft_faults

    control = loaded.scene.control
    if control is None:
        return None
    if control == WITHOUT_FAULTS:
        tree = without_shaft_faults(loaded.tree, loaded.scene)
        tree = {key: value for key, value in tree.items() if key not in ("faults", "control")}
        tree["title"] = f"{loaded.scene.title} (without its faults)"
        return scene_of_merged(f"{loaded.name}-without-faults", loaded.source, loaded.settings, Merged(tree))
    try:
        source = find_source(control, loaded.source.folder)
    except InputError as error:
        reason = str(error).removeprefix(f"{shown(control)}: ").rstrip(".")
        raise InputError(
            f'{loaded.source.shown}: control = "{shown(control)}": {reason}. Or set control = "{WITHOUT_FAULTS}".'
        ) from error
    settings = without_shaft_faults(loaded.settings, loaded.scene)
    settings = {key: value for key, value in settings.items() if key not in _OWN_KEYS}
    name = f"{source.shown} (control of {loaded.name})"
    scene, tree = validate(_shortened(read_tree(source), settings, None), Scene, name)
    return LoadedScene(source.name, source, settings, tree, scene)


def control_differences(loaded: LoadedScene, control: LoadedScene) -> list[str]:
    """Differences between a scene and its control except faults, one line for each value."""
    from pipelines.scene.shaft_faults import without_shaft_faults

    sides = [
        without_shaft_faults(side.scene.model_dump(mode="json", exclude=set(_OWN_KEYS)), side.scene)
        for side in (loaded, control)
    ]
    return differences(*sides)


def validate(
    merged: Merged, model: type[BaseModel], source: str, problems: Iterable[Problem] = ()
) -> tuple[Any, dict[str, Any]]:
    """The object of a model, and the tree from which it was made.

    Parameters
    ----------
    merged : the tree
    model : class that validates the tree
    source : of the scene, for messages
    problems : found before

    Raises
    ------
    SceneError : with all problems
    """
    from pydantic import ValidationError

    from pipelines.scene.validation_messages import problems_of, user_path

    found = [*problems, *merged.problems]
    tree, unlisted = merged.tree, 0
    try:
        try:
            made = model.model_validate(tree)
        except ValidationError as error:
            if not merged.offers:
                raise
            unknown = [e["loc"] for e in error.errors() if e["type"] == "extra_forbidden"]
            paths = {user_path(location, model, tree) for location in unknown}
            dropped = {p for p in paths if any(p[:length] in merged.offers for length in range(1, len(p) + 1))}
            if not dropped:
                raise
            tree = without(tree, dropped)
            made = model.model_validate(tree)
    except ValidationError as error:
        worded, unlisted = problems_of(error, model, tree)
        found += worded
    if found:
        raise SceneError(source, found, unlisted)
    return made, tree


def read_tree(source: Source, seen: tuple[str, ...] = ()) -> Merged:
    """The tree of a source, merged with the scenes that it extends."""
    tree = anchored(parse(source), source.folder)
    refuse_other_file(tree, source.shown)
    base = tree.pop("extends", None)
    if base is None:
        return Merged(tree)
    if not isinstance(base, str):
        raise SceneError(
            source.shown,
            [Problem("extends", "must be the name of one scene", 'Write it in quotes, as in extends = "bench"')],
        )
    chain = (*seen, identity(source))
    try:
        below = find_source(base, source.folder)
    except InputError as error:
        message = str(error).removeprefix(f"{shown(base)}: ")
        raise SceneError(source.shown, [Problem("extends", message, "Or delete extends.", shown_value(base))]) from None
    if identity(below) in chain:
        circle = " -> ".join(Path(one).name for one in (*chain, identity(below)))
        raise InputError(f"{source.shown}: extends forms a circle ({shown(circle)}). Delete one of these extends.")
    if len(chain) > LONGEST_CHAIN:
        raise InputError(f"{source.shown}: more than {LONGEST_CHAIN} scenes extend one another. Join some of them.")
    if "faults" in tree:  # the title of the extended scene may name its fault
        tree.setdefault("title", f"{source.name}, which extends {below.name}")
    return _shortened(read_tree(below, chain), tree, source.shown)


def user_states(source: Source, key: str) -> bool:
    """True if a file of the user, or one that it extends, sets a key such as "casing.band_Hz"."""
    while source.folder is not None:
        tree = parse(source)
        if _at(tree, tuple(key.split("."))) is not None:
            return True
        if "extends" not in tree:
            return False
        source = find_source(tree["extends"], source.folder)
    return False


def identity(source: Source) -> str:
    """Identity of a source: the shipped name, or the full path."""
    return source.name if source.folder is None else str(source.folder / f"{source.name}.toml")


def parse(source: Source) -> dict[str, Any]:
    """The tree of one TOML text with its ``extends``, checked against the limits of a scene."""
    try:
        tree = read_toml(source.text)
    except TomlError as error:
        raise InputError(f"{source.shown}: not valid TOML: {shown(str(error))}. Correct that line.") from error
    if problems := over_limits(tree):
        raise SceneError(source.shown, problems)
    return tree


def find_source(name: str | Path, folder: Path | None = None) -> Source:
    """The source of a name: a file if it ends in ``.toml`` (relative to `folder`), otherwise a shipped scene."""
    text = str(name)
    if not text.endswith(".toml"):
        return _shipped_source(text)
    path = (folder or Path()) / checked_path(text)
    try:
        content = read_text(path, MOST_BYTES)
    except FileNotFoundError:
        near = nearest_name(path.name, sibling_names(path, ".toml"))
        hint = (
            f"Did you mean {shown(near)}?"
            if near
            else "Correct the path, or write a new scene with: gearcase new FILE.toml"
        )
        raise InputError(f"{shown(text)}: no such file. {hint}") from None
    path = Path(os.path.realpath(path))
    return Source(path.stem, content, path.parent, shown(text))


def shipped_names() -> list[str]:
    """Names of the shipped scenes."""
    folder = resources.files("pipelines.scene") / "shipped"
    return sorted(p.name.removesuffix(".toml") for p in folder.iterdir() if p.name.endswith(".toml"))


def _shipped_source(name: str) -> Source:
    names = shipped_names()
    if name in names:
        text = (resources.files("pipelines.scene") / "shipped" / f"{name}.toml").read_text(encoding="utf-8")
        return Source(name, text, None, f"scene {name}")
    near = nearest_name(name, names)
    hint = f"Did you mean {near}? " if near else ""
    what = "a scene file must end in .toml" if Path(name).suffix else "there is no shipped scene of this name"
    raise InputError(
        f"{shown(name)}: {what}. {hint}Give the path of a file that ends in .toml, or one of {', '.join(names)}."
    )


_WINDOWS = ("diagnosis", "windows_s")


def _shortened(base: Merged, change: Mapping[str, Any], source: str | None) -> Merged:
    """Merge `change` into `base`, without the windows of `base` that end after the ``end_s`` of `change`.

    Windows are inherited, from an extended scene or from the file with ``--set simulation.end_s=0.5``. If a change
    shortens the simulation, inherited windows beyond its end are omitted with a warning. A window of the change itself
    that ends after ``end_s`` is an error.

    Parameters
    ----------
    base : the tree to change
    change : the tree that overrides it
    source : of the scene, for the warning; None for a control, for whose scene the warning was given

    Warns
    -----
    SceneWarning : a window is omitted
    """
    merged = merge(base, change)
    end = _at(change, ("simulation", "end_s"))
    windows, own = _at(base.tree, _WINDOWS), _at(change, _WINDOWS)
    if not _is_number(end) or not isinstance(windows, Mapping) or isinstance(own, Whole):
        return merged
    inherited = {name: span for name, span in windows.items() if name not in (own or {})}
    gone = [name for name, span in inherited.items() if _ends(span) > end]
    if not gone:
        return merged
    if source is not None:
        left = [name for name in _at(merged.tree, _WINDOWS) or {} if name not in gone]
        spans = ", ".join(f"{shown(name)} (to {_ends(inherited[name]):g} s)" for name in gone)
        kept = f"kept: {', '.join(map(shown, left))}" if left else "no window remains, so there is no diagnosis"
        text = (
            f"{source}: the diagnosis.windows_s that end after simulation.end_s = {end:g} are left out: {spans}; "
            f"{kept}."
        )
        warnings.warn(text, SceneWarning, stacklevel=2)
    return Merged(without(merged.tree, ((*_WINDOWS, name) for name in gone)), merged.offers, merged.problems)


def _at(tree: Any, path: tuple[str, ...]) -> Any:
    """The value at a path; None if there is none."""
    for key in path:
        tree = tree.get(key) if isinstance(tree, Mapping) else None
    return tree


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _ends(span: Any) -> float:
    """End of a window (s); -inf if it is not a window, which raises an error later."""
    whole = isinstance(span, list | tuple) and len(span) == 2 and _is_number(span[1])
    return float(span[1]) if whole else float("-inf")
