"""A shorter simulation keeps the windows of diagnosis that still fit, and says which fell away.

Windows are inherited: from a scene below by ``extends``, from the file by ``--set simulation.end_s=0.5``. Who shortens
the simulation has not asked for them, so that one which ends later is no mistake. A window that is written beside
``end_s`` is one, and is refused as such.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

from pipelines.io.errors import SceneWarning
from pipelines.io.shown import shown
from pipelines.scene.merge import Merged, Whole, merge, without

_WINDOWS = ("diagnosis", "windows_s")


def shortened(base: Merged, change: Mapping[str, Any], source: str | None) -> Merged:
    """`base` with `change` on top, without the windows of `base` that end after the ``end_s`` of `change`.

    Parameters
    ----------
    base : the tree below
    change : what goes on top
    source : of the scene, for the warning; None of a control, whose scene has said it

    Warns
    -----
    SceneWarning : a window fell away
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
    """The value at a path, None where there is none."""
    for key in path:
        tree = tree.get(key) if isinstance(tree, Mapping) else None
    return tree


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _ends(span: Any) -> float:
    """End of a window (s); -inf of what is none, which is refused later."""
    whole = isinstance(span, list | tuple) and len(span) == 2 and _is_number(span[1])
    return float(span[1]) if whole else float("-inf")
