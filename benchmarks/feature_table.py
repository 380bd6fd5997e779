"""The table of all features as Markdown, made from their definitions: `python -m benchmarks.feature_table`."""

from __future__ import annotations

from pathlib import Path

from benchmarks.markdown import markdown
from pipelines.signals.features.definitions import DEFINITIONS

PAGE = Path(__file__).resolve().parent.parent / "docs" / "features.md"
MARK = "<!-- made by: python -m benchmarks.feature_table -->\n"


def feature_table_page(page: str) -> str:
    """The page with the table of today behind the mark, which is its last part."""
    head = ("component", "`feature`", "unit", "level over", "formula", "source")
    rows = [(one.component, f"`{one.name}`", one.unit, one.reference, one.formula, one.source) for one in DEFINITIONS]
    return f"{page.partition(MARK)[0]}{MARK}\n{markdown(head, rows)}\n"


if __name__ == "__main__":
    PAGE.write_text(feature_table_page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
