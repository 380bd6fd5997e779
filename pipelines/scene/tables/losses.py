"""Tables of the losses: what makes driving differ from being driven; and of the oil film between flanks."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

from mbd.parts.losses import Coulomb, Efficiency, NoLosses
from mbd.parts.oil_film import Film
from pipelines.scene.tables.derived import choice, table
from pipelines.scene.tables.scene_table import Table


class NoFilm(Table):
    """Dry flanks."""

    model: Literal["none"] = "none"

    def made(self, **others: Any) -> None:
        """No film."""


FilmModel: TypeAlias = choice((NoFilm, table(Film)), "model")
LossModel: TypeAlias = choice(map(table, (NoLosses, Efficiency, Coulomb)), "model")
