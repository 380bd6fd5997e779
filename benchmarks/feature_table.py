"""Tables of all features and of the typical population as Markdown: `python -m benchmarks.feature_table`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchmarks.markdown import markdown
from pipelines.datasets.typical_spread import SPREADS
from pipelines.datasets.variables_grid import distribution
from pipelines.signals.features.definitions import DEFINITIONS

PAGE = Path(__file__).resolve().parent.parent / "docs" / "features.md"
POPULATION = PAGE.with_name("campaigns.md")
END = "<!-- end of the table -->\n"
MARK = "<!-- made by: python -m benchmarks.feature_table -->\n"


def feature_table_page(page: str) -> str:
    """The page with the table of today behind the mark, which is its last part."""
    head = ("component", "`feature`", "unit", "level over", "formula", "source")
    rows = [(one.component, f"`{one.name}`", one.unit, one.reference, one.formula, one.source) for one in DEFINITIONS]
    return f"{page.partition(MARK)[0]}{MARK}\n{markdown(head, rows)}\n"


def population_page(page: str) -> str:
    """The page with the table of the typical population between its marks."""
    before, _, rest = page.partition(MARK)
    rows = [
        (
            ", ".join(f"`{key}`" for key in one.keys) + (f" of model `{one.model}`" if one.model else ""),
            f"`{one.text}`",
            distribution(_plain(one.variable)),
            one.source,
        )
        for one in SPREADS
    ]
    table = markdown(("keys", "value", "distribution of x", "source"), rows)
    return f"{before}{MARK}\n{table}\n\n{END}{rest.partition(END)[2]}"


def _plain(variable: Mapping[str, Any]) -> dict[str, Any]:
    rounded = {name: float(f"{one:.3g}") if isinstance(one, float) else one for name, one in variable.items()}
    return {"weights": None} | rounded


if __name__ == "__main__":
    PAGE.write_text(feature_table_page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    POPULATION.write_text(population_page(POPULATION.read_text(encoding="utf-8")), encoding="utf-8")
