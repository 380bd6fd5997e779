"""Features of a parametric housing beyond the plain box: walls, feet, flange, ribs and fillets (all lengths in m)."""

from __future__ import annotations

from dataclasses import dataclass

from fem.options import option

LARGEST = 1e5  # mm; beyond it products of lengths lose all digits


@dataclass(frozen=True, kw_only=True)
class Walls:
    """Thicknesses that differ from the common one of the housing (None: the common one)."""

    side: float | None = None  # the two walls at -y and +y that carry the bearings
    end: float | None = None  # the two walls at -x and +x
    floor: float | None = None
    cover: float | None = None


@dataclass(frozen=True, kw_only=True)
class Feet:
    """Equal feet under the floor, one row along each side wall; `x` are their middles, the same in both rows.

    A foot is a block, square below the floor and longer by `overhang` outside the side wall. A bolt pad is a disc under
    the foot, in the middle of its overhang (in the middle of the foot if there is none), with a bolt hole through both.
    The ground holds the underside of the pads, or of the feet where there are no pads.
    """

    x: tuple[float, ...]
    length: float = 0.060  # side of the square
    height: float = 0.015  # below the underside of the floor
    overhang: float = 0.0  # beyond the outer face of the side wall
    pad_diameter: float = 0.0  # 0: no pads
    pad_height: float = 0.0
    bolt_diameter: float = 0.0  # 0: no holes


@dataclass(frozen=True, kw_only=True)
class Flange:
    """The flange at the split plane, over which the cover is bonded or bolted to the lower part.

    Unless the cover is bolted on (`Dimensions.bolted`), both are one body, as if their joint were closed everywhere.
    Around the bearing bosses the rim is interrupted.
    """

    split: float = option(
        0.0,
        unit="mm",
        key="split_plane_mm",
        ge=-LARGEST,
        le=LARGEST,
        text="z of the split plane; shaft 1 is at z = 0",
    )
    width: float = option(unit="mm", gt=0, le=LARGEST, text="width beyond the outer faces of the walls")
    height: float = option(unit="mm", gt=0, le=LARGEST, text="height of both halves of the flange together")


@dataclass(frozen=True, kw_only=True)
class Ribs:
    """Ribs on the outside of the housing, all of one thickness and height.

    Below every boss `per_boss` vertical ribs reach from the underside of the floor up to the boss; each end wall has
    `end_wall` vertical ribs over its height, the cover has `cover` ribs across its width, evenly spread.
    """

    thickness: float = option(unit="mm", gt=0, le=LARGEST, text="thickness of the plates")
    height: float = option(unit="mm", gt=0, le=LARGEST, text="height of the ribs over their wall")
    per_boss: int = option(0, ge=0, le=3, text="number of vertical ribs from the floor to each boss")
    end_wall: int = option(0, ge=0, le=20, text="number of vertical ribs on each of the two end walls")
    cover: int = option(0, ge=0, le=20, text="number of ribs across the cover")


@dataclass(frozen=True, kw_only=True)
class Fillets:
    """Radii of the rounded edges; 0 leaves them sharp."""

    foot: float = 0.0  # where feet meet the floor and the side wall
    inner: float = 0.0  # the twelve edges of the cavity
