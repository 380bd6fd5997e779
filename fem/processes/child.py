"""Child processes: they find every module where their parent finds it, and none in the working folder.

Python looks for modules in the folder it is started in, or in that of the script, and in PYTHONPATH, before it looks
in its own library: a file ``queue.py`` there would be run in place of the library's. So this file is started by its
path (-P: its folder is not searched; -S: nothing but the library is), and puts the parent's folders behind the
library, without the working folder and that of the parent's script. Our own packages come from where the parent has
them, even if that is the working folder. This file imports the standard library alone.
"""

from __future__ import annotations

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
    """The command that runs a module of our packages, or of one beside them, as a program."""
    home = str(Path(__file__).resolve().parents[2])
    own = [*PACKAGES, module.partition(".")[0]]
    return [sys.executable, "-P", "-S", __file__, json.dumps([home, own, _folders()]), module, *arguments]


def environment(**changes: str) -> dict[str, str]:
    """The environment of this process without PYTHONPATH, whose folders come before the library."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | changes


def _folders() -> list[str]:
    """Where this process looks for modules, without the working folder and that of its script."""
    left_out = {os.path.realpath(os.getcwd())}
    main = sys.modules.get("__main__")
    if main is not None and getattr(main, "__spec__", None) is None and getattr(main, "__file__", None):
        left_out.add(os.path.dirname(os.path.realpath(str(main.__file__))))
    entries = [os.path.abspath(entry) if os.path.exists(entry) else entry for entry in sys.path if entry]
    return [entry for entry in entries if os.path.realpath(entry) not in left_out]


class _Own:
    """Finds the packages of `names` in one folder, and nothing else there."""

    def __init__(self, home: str, names: Sequence[str]) -> None:
        self._home, self._names = home, frozenset(names)

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """The place of a package of ours; None for all else."""
        if path is None and name in self._names:
            return importlib.machinery.PathFinder.find_spec(name, [self._home])
        return None


def _main() -> None:
    home, names, folders = json.loads(sys.argv[1])
    library = list(sys.path)
    site.main()  # what -S put off: the folders of this environment and what is installed in them to be edited
    sys.path[:] = dict.fromkeys([*library, *folders, *sys.path])
    sys.meta_path.insert(0, _Own(home, names))
    module = sys.argv[2]
    del sys.argv[1:3]
    try:
        runpy.run_module(module, run_name="__main__", alter_sys=True)
    except ImportError as error:
        sys.exit(f"a child process cannot import {error.name or 'a module'}: {error}")


if __name__ == "__main__":
    _main()
