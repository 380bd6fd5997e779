"""Start of child processes, which import the same modules as their parent and none from the working folder.

Python searches modules in the working folder or that of the script, and in PYTHONPATH, before its standard library: a
file ``queue.py`` there would replace that of the library. This file is therefore started by its path with -P (its
folder is not searched) and -S (only the library is searched). It appends the parent's folders after the library,
without the working folder and that of the parent's script. The packages of this product come from the parent's
location, even if that is the working folder. This file imports only the standard library.
"""

from __future__ import annotations

import atexit
import gc
import importlib.machinery
import json
import os
import runpy
import site
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

PACKAGES = ("fem", "mbd", "meshes", "pipelines")


def command(module: str, *arguments: str) -> list[str]:
    """The command that runs a module of this product, or of a package next to it, as a program."""
    home = str(Path(__file__).resolve().parents[2])
    own = [*PACKAGES, module.partition(".")[0]]
    return [sys.executable, "-P", "-S", __file__, json.dumps([home, own, _folders()]), module, *arguments]


def environment(**changes: str) -> dict[str, str]:
    """The environment of this process without PYTHONPATH, whose folders would precede the library."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | changes


def collect_rarely() -> None:
    """Search for garbage after 50,000 new objects instead of 700, and not when the process ends.

    The searches take a sixth of the time of imports, and half a second at the end, where the system takes all memory.
    """
    gc.set_threshold(50_000)
    atexit.register(gc.freeze)


def _folders() -> list[str]:
    """Search folders of modules in this process, without the working folder and that of its script."""
    left_out = {os.path.realpath(os.getcwd())}
    main = sys.modules.get("__main__")
    if main is not None and getattr(main, "__spec__", None) is None and getattr(main, "__file__", None):
        left_out.add(os.path.dirname(os.path.realpath(str(main.__file__))))
    entries = [os.path.abspath(entry) if os.path.exists(entry) else entry for entry in sys.path if entry]
    return [entry for entry in entries if os.path.realpath(entry) not in left_out]


class _Own:
    """Module finder for the packages `names` in one folder, and no others there."""

    def __init__(self, home: str, names: Sequence[str]) -> None:
        self._home, self._names = home, frozenset(names)

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Specification of one of the packages; None for any other module."""
        if path is None and name in self._names:
            return importlib.machinery.PathFinder.find_spec(name, [self._home])
        return None


def _main() -> None:
    home, names, folders = json.loads(sys.argv[1])
    library = list(sys.path)
    site.main()  # postponed by -S: the folders of this environment, including editable installations
    sys.path[:] = dict.fromkeys([*library, *folders, *sys.path])
    sys.meta_path.insert(0, _Own(home, names))
    collect_rarely()
    module = sys.argv[2]
    del sys.argv[1:3]
    try:
        runpy.run_module(module, run_name="__main__", alter_sys=True)
    except ImportError as error:
        sys.exit(f"a child process cannot import {error.name or 'a module'}: {error}")


if __name__ == "__main__":
    _main()
