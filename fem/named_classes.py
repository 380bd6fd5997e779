"""Classes named by module and class, imported when they are asked for.

So a registry imports none of its classes, and what one of them computes does not depend on the code of another.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any


def named_class(known: Mapping[str, tuple[str, str]], name: str, what: str, error: type[Exception]) -> Any:
    """The class that `known` gives as (module, class) under `name`; `error` with the known names if there is none."""
    if name not in known:
        raise error(f"{what} {name!r} is unknown; known: {', '.join(known)}")
    module, kind = known[name]
    return getattr(import_module(module), kind)
