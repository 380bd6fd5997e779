"""Registry of classes by name: module and class, imported on request.

A registry therefore imports none of its classes, and results of one do not depend on the code of another.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any


def named_class(known: Mapping[str, tuple[str, str]], name: str, what: str, error: type[Exception]) -> Any:
    """Import the class of a name.

    Parameters
    ----------
    known : (module, class) by name
    name : requested name
    what : kind of class in the message, e.g. "casing model"
    error : type of the error

    Raises
    ------
    error : unknown name; the message lists the known ones
    """
    if name not in known:
        raise error(f"{what} {name!r} is unknown; known: {', '.join(known)}")
    module, kind = known[name]
    return getattr(import_module(module), kind)
