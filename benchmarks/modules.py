"""What every file of the packages holds and imports, a page of the site: python -m benchmarks.modules."""

from __future__ import annotations

import ast
from pathlib import Path

from benchmarks.markdown import markdown

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("fem", "mbd", "pipelines", "gearcase")


def modules() -> dict[str, Path]:
    """Source files of the packages by module name, without the empty `__init__` files."""
    found = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            if path.name != "__init__.py" and path.stat().st_size:
                found[".".join(path.relative_to(ROOT).with_suffix("").parts)] = path
    return found


def purpose(tree: ast.Module) -> str:
    """First sentence or line of the docstring."""
    first = (ast.get_docstring(tree) or "").split("\n\n")[0].replace("\n", " ")
    return first.partition(". ")[0].rstrip(".").replace("|", "\\|")


def imports(tree: ast.Module, known: dict[str, Path]) -> list[str]:
    """Modules of ours that a module imports, wherever in its text."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    return sorted(names & known.keys())


def folder_table(folder: str, known: dict[str, Path]) -> str:
    """The modules of one folder."""
    rows = []
    for name, path in known.items():
        if name.rpartition(".")[0] != folder:
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        depends = ", ".join(f"`{other}`" for other in imports(tree, known)) or "-"
        rows.append([f"`{name}`", purpose(tree), depends])
    return markdown(("module", "what it is", "depends on"), rows)


def tables() -> str:
    """All folders."""
    known = modules()
    folders = sorted({name.rpartition(".")[0] for name in known}, key=lambda f: (PACKAGES.index(f.split(".")[0]), f))
    return "\n\n".join(f"## {folder}\n\n{folder_table(folder, known)}" for folder in folders)


if __name__ == "__main__":
    print(tables())
