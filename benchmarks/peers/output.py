"""What a comparison with a peer leaves behind: a file of results, and what they are on the screen."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def keep(found: dict[str, Any], path: Path) -> None:
    """Write the results with their conditions."""
    path.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def show(found: dict[str, Any]) -> None:
    """Print them without."""
    print(json.dumps({key: value for key, value in found.items() if key != "conditions"}, indent=1))


def report(found: dict[str, Any], path: Path) -> None:
    """Do both."""
    keep(found, path)
    show(found)
