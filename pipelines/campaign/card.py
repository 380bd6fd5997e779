"""The card of a data set: README.md in its folder, what it holds, how it was made, how it is read."""

from __future__ import annotations

from pathlib import Path


def write_card(folder: Path) -> None:
    (folder / "README.md").write_text("card\n")
