"""Tables of the losses: what makes driving differ from being driven; and of the oil film between flanks."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

from mbd.parts.film import Film
from mbd.parts.losses import Coulomb, Efficiency, NoLosses
from pipelines.scene.tables.base import Table
from pipelines.scene.tables.derived import choice, table


class NoFilm(Table):
    """Dry flanks."""

    model: Literal["none"] = "none"

    def made(self, **others: Any) -> None:
        """No film."""


FilmModel: TypeAlias = choice((NoFilm, table(Film)), "model")
LossModel: TypeAlias = choice(map(table, (NoLosses, Efficiency, Coulomb)), "model")
