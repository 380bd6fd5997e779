"""Features of a parametric housing beyond the plain box: walls, feet, flange, ribs and fillets (all lengths in m)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fem.options import option

LARGEST = 1e5  # mm; beyond it products of lengths lose all digits


def _wall(key: str) -> Any:
    text = "thickness of this part; without it: wall_thickness_mm"
    return option(None, unit="mm", key=key, gt=0, le=LARGEST, text=text)


@dataclass(frozen=True, kw_only=True)
class Walls:
    """Thicknesses that differ from the common one of the housing (None: the common one).

    `side` are the two walls at -y and +y that carry the bearings, `end` those at -x and +x.
    """

    side: float | None = _wall("side_wall_thickness_mm")
    end: float | None = _wall("end_wall_thickness_mm")
    floor: float | None = _wall("floor_thickness_mm")
    cover: float | None = _wall("cover_thickness_mm")


@dataclass(frozen=True, kw_only=True)
class Feet:
    """Equal feet under the floor, one row along each side wall; `x` holds their middles, the same in both rows.

    A foot is a block, square below the floor and longer by `overhang` outside the side wall. A bolt pad is a disc under
    the foot, in the middle of its overhang (in the middle of the foot if there is none), with a bolt hole through both.
    The ground holds the underside of the pads, or of the feet where there are no pads.
    """

    x: tuple[float, ...]
    length: float = option(
        0.060,
        unit="mm",
        key="foot_length_mm",
        gt=0,
        le=LARGEST,
        text="side of the feet along x; along y their length below the floor, to which foot_overhang_mm is added",
    )
    height: float = option(
        0.015, unit="mm", key="foot_height_mm", gt=0, le=LARGEST, text="height of the feet below the floor"
    )
    overhang: float = option(
        0.0,
        unit="mm",
        key="foot_overhang_mm",
        ge=0,
        le=LARGEST,
        text="distance by which the feet extend beyond the side walls",
    )
    pad_diameter: float = option(
        0.0, unit="mm", ge=0, le=LARGEST, text="diameter of round bolt pads under the feet; 0: none"
    )
    pad_height: float = option(0.0, unit="mm", ge=0, le=LARGEST, text="height of the bolt pads below the feet")
    bolt_diameter: float = option(
        0.0, unit="mm", ge=0, le=LARGEST, text="diameter of the holes through pads and feet; 0: none"
    )


@dataclass(frozen=True, kw_only=True)
class Flange:
    """The flange at the split plane, over which the cover is bonded or bolted to the lower part.

    Unless the cover is bolted on (`Dimensions.bolted`), both form one body: the joint is closed everywhere. Around the
    bearing bosses the rim is interrupted.
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
    `end_wall` vertical ribs over its height, the cover has `cover` ribs across its width, uniformly spaced.
    """

    thickness: float = option(unit="mm", gt=0, le=LARGEST, text="thickness of the plates")
    height: float = option(unit="mm", gt=0, le=LARGEST, text="height of the ribs over their wall")
    per_boss: int = option(0, ge=0, le=3, text="number of vertical ribs from the floor to each boss")
    end_wall: int = option(0, ge=0, le=20, text="number of vertical ribs on each of the two end walls")
    cover: int = option(0, ge=0, le=20, text="number of ribs across the cover")


@dataclass(frozen=True, kw_only=True)
class Fillets:
    """Radii of the rounded edges; 0 leaves them sharp."""

    foot: float = option(
        0.0, unit="mm", key="foot_fillet_mm", ge=0, le=LARGEST, text="radius where feet meet floor or wall; 0: sharp"
    )
    inner: float = option(
        0.0, unit="mm", key="inner_fillet_mm", ge=0, le=LARGEST, text="radius of the edges of the cavity; 0: sharp"
    )
