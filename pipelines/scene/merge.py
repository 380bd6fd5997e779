"""Deep merge of scene trees: how ``extends`` and ``--set`` change one value and leave the rest.

Tables merge key by key, everything else is replaced. A table whose keys are all whole numbers changes single
items of an array, counted from 1: ``[stages.1]`` in a variant, or ``--set stages.1.face_width_mm=32``.
A table that is switched to another model (its key `model` changes) keeps what it inherits, but those inherited keys
are only offers: `Merged.offers` names them, and the ones that the new model does not know are dropped.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from pipelines.io.errors import Problem
from pipelines.io.shown_text import shown, shown_value
from pipelines.io.toml_text import DEEPEST, TomlError, TomlLimitError, format_value, read_toml
from pipelines.scene.tree_limits import over_limits

Path = tuple[str, ...]


class Whole(dict):
    """A table given as one value, ``--set diagnosis.windows_s={}``: it replaces the table below instead of merging."""


@dataclass(frozen=True)
class Merged:
    """A merged tree, the problems met on the way, and inherited keys that a newly chosen model may not know."""

    tree: dict[str, Any]
    offers: frozenset[Path] = frozenset()
    problems: tuple[Problem, ...] = ()


def merge(base: Merged, change: Mapping[str, Any]) -> Merged:
    """`base` with `change` on top; neither is edited."""
    offers, problems = set(base.offers), list(base.problems)
    tree = _merged_table(base.tree, change, (), offers, problems)
    return Merged(tree, frozenset(offers), tuple(problems))


def _merged_table(
    base: Mapping[str, Any], change: Mapping[str, Any], path: Path, offers: set[Path], problems: list[Problem]
) -> dict[str, Any]:
    if "model" in change and base and change["model"] != base.get("model"):
        offers.update((*path, key) for key in base if key not in change)
    out = dict(base)
    for key, value in change.items():
        offers.discard((*path, key))
        out[key] = _merged(out.get(key), value, (*path, key), offers, problems)
    return out


def _merged(base: Any, change: Any, path: Path, offers: set[Path], problems: list[Problem]) -> Any:
    if isinstance(change, Whole) or not isinstance(change, Mapping):
        return change
    if isinstance(base, Mapping):
        return _merged_table(base, change, path, offers, problems)
    if isinstance(base, list) and change and all(str(key).isdecimal() for key in change):
        items = list(base)
        for key, value in change.items():
            number = int(key)
            if not 1 <= number <= len(items):
                where = ".".join((*path, str(key)))
                problems.append(Problem(where, *no_item(".".join(path), key, len(items))))
                continue
            items[number - 1] = _merged(items[number - 1], value, (*path, str(key)), offers, problems)
        return items
    return _merged_table({}, change, path, offers, problems)


def without(tree: Mapping[str, Any], dropped: Iterable[Path]) -> dict[str, Any]:
    """`tree` without the keys at the paths `dropped`."""
    gone = set(dropped)

    def copy(value: Any, path: Path) -> Any:
        if isinstance(value, Mapping):
            return {k: copy(v, (*path, k)) for k, v in value.items() if (*path, k) not in gone}
        if isinstance(value, list):
            return [copy(v, (*path, str(n))) for n, v in enumerate(value, start=1)]
        return value

    return copy(tree, ())


def settings_tree(settings: Iterable[str] | Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem]]:
    """``["a.b=1", ...]`` or ``{"a.b": 1}`` as a tree to merge, with the problems found.

    The right side is read as TOML; a bare word is a string, so ``casing.model=rigid`` needs no quotes.
    """
    tree: dict[str, Any] = {}
    problems: list[Problem] = []
    pairs: list[tuple[str, Any]] = []
    if isinstance(settings, Mapping):
        pairs = [(str(path), value) for path, value in settings.items()]
    else:
        for text in settings:
            path, equals, value = text.partition("=")
            if not equals or not path.strip():
                problems.append(
                    Problem(
                        f"--set {shown(text)}",
                        "has no value" if path.strip() else "has no key",
                        "Write KEY=VALUE, as in --set stages.1.face_width_mm=32.",
                    )
                )
                continue
            try:
                pairs.append((path.strip(), setting_value(value.strip())))
            except ValueError as error:
                problems.append(Problem(path.strip(), str(error), "Write text in quotes, and lists as [1, 2].", value))
    for dotted, value in pairs:
        keys = [key.strip() for key in dotted.split(".", DEEPEST)]
        if not all(keys):
            problems.append(
                Problem(dotted, "is not the path of a key", "Join keys by single dots, as in stages.1.face_width_mm.")
            )
            continue
        if beyond := [*over_limits(dict.fromkeys(keys)), *over_limits(value, tuple(keys))]:
            problems += beyond
            continue
        table = tree
        for key in keys[:-1]:
            deeper = table.setdefault(key, {})
            if not isinstance(deeper, dict):
                problems.append(
                    Problem(
                        dotted,
                        "is set twice: here, and with a value that contains it",
                        "Delete one of the two.",
                        shown_value(value),
                    )
                )
                break
            table = deeper
        else:
            table[keys[-1]] = Whole(value) if isinstance(value, Mapping) else value
    return tree, problems


def setting_value(text: str) -> Any:
    """The value of ``--set path=text``. ValueError if it looks like TOML but is not, or is beyond a limit."""
    try:
        value = read_toml(f"value = {text}\n")
        if len(value) == 1:
            return value["value"]
    except TomlLimitError:
        raise
    except TomlError:
        pass
    if text[:1] in ("[", "{", '"', "'") or "\n" in text:
        raise ValueError("is not a TOML value")
    return text


def leaves(tree: Mapping[str, Any], path: Path = ()) -> dict[Path, Any]:
    """Every value of a tree that is not a table, by path; items of arrays of tables are counted from 1."""
    out: dict[Path, Any] = {}
    for key, value in tree.items():
        here = (*path, str(key))
        if isinstance(value, Mapping):
            out |= leaves(value, here)
        elif isinstance(value, list | tuple) and value and all(isinstance(item, Mapping) for item in value):
            for number, item in enumerate(value, start=1):
                out |= leaves(item, (*here, str(number)))
        else:
            out[here] = value
    return out


def differences(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[str]:
    """One line per value that differs, ``stages.1.face_width_mm: 12 -> 32``."""
    old, new = leaves(before), leaves(after)
    lines = []
    for path in sorted(old.keys() | new.keys(), key=lambda p: [(not k.isdecimal(), k.zfill(6)) for k in p]):
        if old.get(path) != new.get(path):
            shown = [format_value(side[path]) if side.get(path) is not None else "(none)" for side in (old, new)]
            lines.append(f"{'.'.join(path)}: {shown[0]} -> {shown[1]}")
    return lines


def no_item(where: str, key: str, count: int) -> tuple[str, str]:
    """Message and remedy for the number of an item that a list does not have."""
    if not count:
        return f"there is no item {key}; {where} has none", f"Write the first one as [[{where}]] in the scene file."
    items = "1 item, number 1" if count == 1 else f"{count} items, numbered 1 to {count}"
    return f"there is no item {key}; {where} has {items}", "Correct the number."
