"""Print the lowest version of each requirement in pyproject.toml, for use and for development, as constraints for pip.

Usage: python tests/lowest_versions.py > constraints.txt (`make test-lowest` installs these and runs the default tests).
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent / "pyproject.toml"


def lowest_versions() -> list[str]:
    """One `name==version` for each requirement.

    Raises
    ------
    ValueError : a requirement without a lowest version
    """
    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]
    return [_lowest(text) for text in (*project["dependencies"], *project["optional-dependencies"]["dev"])]


def _lowest(requirement: str) -> str:
    found = re.match(r"([\w.-]+)>=([\w.]+)", requirement)
    if found is None:
        raise ValueError(f"pyproject.toml: {requirement} has no lowest version; write it as name>=version")
    return f"{found[1]}=={found[2]}"


if __name__ == "__main__":
    sys.stdout.writelines(f"{line}\n" for line in lowest_versions())
