"""Tables of the bearings: one table for all of them, or one per bearing of a shaft."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from mbd.forces.bearing_models import BEARINGS, bearing_model
from pipelines.scene.tables.derived import by_default, choice, table

BearingModel: TypeAlias = Annotated[
    choice((table(bearing_model(name)) for name in BEARINGS), "model"), by_default("linear")
]
