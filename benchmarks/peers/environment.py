"""The environment of the peers that are Python packages: `.peers` beside the package, made by `make peers`."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent.parent
REMEDY = "make peers installs it"


class NotInstalledError(RuntimeError):
    """The environment does not hold the peer."""


def answer(package: str, module: str) -> dict[str, Any]:
    """What `python -m module --here` prints last in the environment that holds `package`.

    Raises
    ------
    NotInstalledError : with the remedy
    CalledProcessError : the module failed there
    """
    interpreter = python(package)
    if interpreter is None:
        raise NotInstalledError(f"{package} is not installed; {REMEDY}")
    command = [str(interpreter), "-m", module, "--here"]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    found: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return found


def python(package: str) -> Path | None:
    """The interpreter of the environment if it holds `package`, else None."""
    for path in (ROOT / ".peers" / "bin" / "python", ROOT / ".peers" / "Scripts" / "python.exe"):
        if path.exists():
            code = f"import importlib.util, sys; sys.exit(importlib.util.find_spec({package!r}) is None)"
            return path if subprocess.run([str(path), "-c", code], check=False).returncode == 0 else None
    return None
