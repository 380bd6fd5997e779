"""A parametric gearbox housing whose dimensions are checked to form a valid body."""

from __future__ import annotations

from dataclasses import dataclass

from fem.casing.geometry.dimension_checks import housing_problems
from fem.casing.geometry.dimensions import Dimensions, HousingError


@dataclass(frozen=True, kw_only=True)
class Housing(Dimensions):
    """The parametric housing: a closed box with bearing bosses in its two side walls, and feet.

    HousingError lists all problems of its dimensions (m) at once.
    """

    def __post_init__(self) -> None:
        if problems := housing_problems(self):
            raise HousingError("\n".join(dict.fromkeys(problems)))
