"""The version of the code of a step: a hash of the source of every module of ours that it can reach.

Imports are followed by reading the source, those inside functions too, so that an edited helper changes the version
and an edited neighbour does not. They are found by a pattern, in a third of the time that syntax trees take; a line
of a text that looks like one only makes the version change more often.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.util
import os
import re
from importlib import metadata
from pathlib import Path

OWN_PACKAGES = ("fem", "mbd", "pipelines")
_IMPORT = re.compile(r"^[ \t]*(?:import +([^\n]+)|from +([\w.]+) +import +(\([^)]*\)|[^\n]*))", re.MULTILINE)


@functools.cache
def code_version(*modules: str) -> str:
    """SHA-256 over the source texts of `modules` and all that they import from our packages."""
    total = hashlib.sha256()
    for name in reachable(*modules):
        total.update(name.encode())
        total.update(hashlib.sha256(_source(name)).digest())
    return total.hexdigest()[:16]


def reachable(*modules: str) -> list[str]:
    """The modules and everything of ours that they import, directly or not, sorted."""
    found: set[str] = set()
    waiting = list(modules)
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting.extend(_imports(name))
    return sorted(found)


def library_versions(*names: str) -> dict[str, str]:
    """Installed versions of distributions; "absent" where there is none."""
    return {name: _version(name) for name in names}


@functools.cache
def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "absent"


@functools.cache
def _imports(module: str) -> tuple[str, ...]:
    out: set[str] = set()
    for plain, origin, names in _IMPORT.findall(_source(module).decode()):
        if plain:
            out.update(re.findall(r"[\w.]+", plain))
        elif _own(origin):
            members = (f"{origin}.{name}" for name in re.findall(r"(\w+)(?: +as +\w+)?", names))
            out.update(member if _path(member) else origin for member in members)
    return tuple(name for name in out if _own(name) and _path(name))


def _own(name: str) -> bool:
    return name.partition(".")[0] in OWN_PACKAGES


@functools.cache
def _source(module: str) -> bytes:
    path = _path(module)
    if path is None:
        raise ModuleNotFoundError(f"{module}: its source is not found; steps need modules with a source file")
    return Path(path).read_bytes()


@functools.cache
def _path(module: str) -> str | None:
    top, *rest = module.split(".")
    spec = importlib.util.find_spec(top)
    if spec is None or spec.origin is None:
        return None
    if not rest:
        return spec.origin
    base = os.path.join(os.path.dirname(spec.origin), *rest)  # strings: one call for each import of each module
    return next((path for path in (f"{base}.py", os.path.join(base, "__init__.py")) if os.path.isfile(path)), None)
