"""Classes named by module and class, imported when they are asked for.

So a registry imports none of its classes, and what one of them computes does not depend on the code of another.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any


def named_class(known: Mapping[str, tuple[str, str]], name: str, what: str, error: type[Exception]) -> Any:
    """The class of a name, imported.

    Parameters
    ----------
    known : (module, class) by name
    name : the one asked for
    what : what it is called in the message, e.g. "casing model"
    error : what is raised

    Raises
    ------
    error : no such name, with the known ones
    """
    if name not in known:
        raise error(f"{what} {name!r} is unknown; known: {', '.join(known)}")
    module, kind = known[name]
    return getattr(import_module(module), kind)
