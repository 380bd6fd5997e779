"""Check that no folder of the user shadows our packages or modules of Python, which takes the first on its path.

``python -c`` and ``python -m`` put the working folder there, ``python script.py`` the folder of the script. The command
`gearcase` does not.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
from pathlib import Path

HOME = Path(__file__).resolve().parent.parent
PACKAGES = ("fem", "mbd", "meshes", "pipelines")
_REMEDY = "rename it, or start Python in another folder or with the option -P"


def refuse_shadowed() -> None:
    """Nothing, if our packages and Python's own modules are found where they belong.

    Raises
    ------
    ImportError : names the folder and the package that it hides
    """
    if sys.argv[:1] == ["-m"]:
        return  # `python -m gearcase`, which leaves the working folder out itself
    for name in PACKAGES:
        found = _origin(name)
        if found is not None and found != HOME / name / "__init__.py":
            raise ImportError(_hides(found, f"the package {name} of gearcase in {HOME}"), name=name, path=str(found))
    suspects = _named_like_pythons_own()
    if not suspects:
        return
    failure: Exception | None = None
    try:
        importlib.import_module("pipelines.runs.run")
        importlib.import_module("concurrent.futures.thread")
    except Exception as error:
        failure = error
    for name, path in suspects.items():
        if _is_file(sys.modules.get(name), path):
            raise ImportError(_hides(path, f"Python's own module {name}"), name=name, path=str(path)) from failure


def _hides(path: Path, what: str) -> str:
    place = path.parent if path.name == "__init__.py" else path
    return f"{place} in the folder {place.parent} hides {what}: {_REMEDY}."


def _origin(name: str) -> Path | None:
    """The file that `name` is imported from; None for a package of ours that is not to be found at all."""
    try:
        spec = importlib.util.find_spec(name)
    except ValueError:  # imported already, by something without a spec
        return None
    if spec is None:
        return None
    if spec.origin is None:  # a folder without __init__.py
        return Path(next(iter(spec.submodule_search_locations or [""]))).resolve() / "__init__.py"
    return Path(spec.origin).resolve()


def _named_like_pythons_own() -> dict[str, Path]:
    """Files in the first folder of the path that have the name of a module of Python itself, by that name."""
    first = Path(sys.path[0]) if sys.path else HOME
    folder = first.resolve()
    if folder == Path(os.__file__).resolve().parent or not folder.is_dir():
        return {}
    names = {path.stem if path.suffix == ".py" else path.name: path for path in folder.iterdir()}
    found = {}
    for name in names.keys() & sys.stdlib_module_names:
        for path in (folder / f"{name}.py", folder / name / "__init__.py"):
            if path.is_file():
                found[name] = path
    return found


def _is_file(module: object, path: Path) -> bool:
    origin = getattr(module, "__file__", None)
    return origin is not None and Path(origin).resolve() == path.resolve()
