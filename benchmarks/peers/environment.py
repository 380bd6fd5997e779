"""The environment of the peers that are Python packages: `.peers` beside the package, made by `make peers`."""

from __future__ import annotations

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
REMEDY = "make peers installs it"


def python(package: str) -> Path | None:
    """The interpreter of the environment if it holds `package`, else None."""
    for path in (ROOT / ".peers" / "bin" / "python", ROOT / ".peers" / "Scripts" / "python.exe"):
        if path.exists():
            code = f"import importlib.util, sys; sys.exit(importlib.util.find_spec({package!r}) is None)"
            return path if subprocess.run([str(path), "-c", code], check=False).returncode == 0 else None
    return None
