"""Places on shafts, in m."""

from __future__ import annotations

from pipelines.scene.tables.shafts import ShaftTable


def shaft_ends(shaft: ShaftTable) -> tuple[float, float]:
    """y of the two ends of a shaft (m)."""
    return shaft.sections[0].si.start, shaft.sections[-1].si.end
