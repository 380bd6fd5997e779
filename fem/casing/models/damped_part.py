"""A part of a casing with a separate loss factor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fem.casing.parts.casing_choices import COVER, FEET, JOINTS, LARGEST_LOSS_FACTOR, MOUNTS
from fem.options import option

if TYPE_CHECKING:
    from fem.casing.parts.regions import Region

KNOWN_PARTS = (COVER, FEET, MOUNTS, JOINTS)
_FAR = math.inf
Corner = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class DampedPart:
    """A part of the casing that damps a mode in proportion to its share of the strain energy."""

    name: str = option(
        pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,39}$",
        text="cover or feet of a parametric housing, mounts, joints (bolts), or any other name together with box_mm",
    )
    loss_factor: float = option(
        ge=0,
        lt=LARGEST_LOSS_FACTOR,
        text="loss factor of its material: twice the damping ratio of a body of this material alone",
    )
    box: tuple[Corner, Corner] | None = option(
        None,
        unit="mm",
        text="lower and upper corner of a box; the part is all elements whose centre is inside",
    )

    def __post_init__(self) -> None:
        if (self.box is None) != (self.name in KNOWN_PARTS):
            if self.name in KNOWN_PARTS:
                raise ValueError(
                    f'name = "{self.name}" is a part of the parametric housing, found without box_mm. For a part in a '
                    "box set another name"
                )
            raise ValueError(f'name = "{self.name}" needs box_mm. Set it, or a name of {", ".join(KNOWN_PARTS)}')
        if self.box is not None and not all(a < b for a, b in zip(*self.box, strict=True)):
            corners = tuple(tuple(float(f"{1000 * value:.12g}") for value in corner) for corner in self.box)
            raise ValueError(
                f"box_mm: the second of the corners {corners} must be above the first in x, y and z. Correct them"
            )

    def region(self, housing: Any) -> Region | None:
        """The box of its elements; None for a part without elements.

        A cover begins at the split plane of the flange or, without a flange, at the underside of the top wall; feet are
        below the floor.
        """
        from fem.casing.parts.regions import Region

        if self.box is not None:
            return Region(name=self.name, low=self.box[0], high=self.box[1])
        if self.name == COVER:
            return Region(name=COVER, low=(-_FAR, -_FAR, housing.cover_start), high=(_FAR, _FAR, _FAR))
        if self.name == FEET:
            return Region(name=FEET, low=(-_FAR, -_FAR, -_FAR), high=(_FAR, _FAR, -housing.axis_height))
        return None
