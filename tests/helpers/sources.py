"""Source files of the packages, each parsed once in a process."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("fem", "mbd", "pipelines", "gearcase")
FILES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))


def module_name(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def text(path):
    return path.read_text(encoding="utf-8")


@cache
def nodes(path):
    """All nodes of the syntax tree, the module first."""
    return tuple(ast.walk(ast.parse(text(path), path)))
