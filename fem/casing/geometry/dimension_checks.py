"""Checks of the dimensions of a parametric housing: every problem with its values, limit and remedy."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations, pairwise

import numpy as np

from fem.casing.geometry.dimensions import Box, Dimensions

THINNEST_LIGAMENT = 0.3  # least material between two holes or bosses, or around a bore, in wall thicknesses
SMALLEST_FILLET = 0.0005  # m; at 0.1 mm OpenCASCADE or gmsh fails to make or mesh surfaces
_TOUCH = 1e-9  # m
_Check = tuple[bool, str]  # whether it is a problem, in these words


def housing_problems(housing: Dimensions) -> list[str]:
    """All problems of the dimensions; the parts are checked only if the box itself has none."""
    if problems := [words for wrong, words in _box_problems(housing) if wrong]:
        return problems
    checks = (
        _bore_problems,
        _foot_problems,
        _pad_problems,
        _flange_problems,
        _rib_problems,
        _fillet_problems,
        _name_problems,
    )
    return [words for check in checks for wrong, words in check(housing) if wrong]


def _ligament(housing: Dimensions) -> float:
    return THINNEST_LIGAMENT * housing.wall("side")


def _box_problems(housing: Dimensions) -> Iterator[_Check]:
    limit = min(housing.length, housing.width, housing.height) / 2
    if housing.wall_thickness >= limit:
        yield (
            True,
            (
                f"wall thickness {_mm(housing.wall_thickness)} fills the housing (limit {_mm(limit)}, half of its "
                "smallest side). Reduce wall_thickness_mm"
            ),
        )
        return
    for what, used, room in (
        ("end walls", 2 * housing.wall("end"), housing.length),
        ("side walls", 2 * housing.wall("side"), housing.width),
        ("floor and cover", housing.wall("floor") + housing.wall("cover"), housing.height),
    ):
        yield used >= room, f"{what} are {_mm(used)} thick together and fill the box of {_mm(room)}. Reduce them"


def _bore_problems(housing: Dimensions) -> Iterator[_Check]:
    yield not housing.bores, "no bores. Set one for each bearing"
    (low, high), wall, ligament = housing.cavity, housing.wall("side"), _ligament(housing)
    for bore in housing.bores:
        ring = (bore.boss_diameter - bore.diameter) / 2
        yield (
            ring < ligament,
            (
                f"{bore.name}: boss ring is {_mm(ring)} thick, and must be at least {_mm(ligament)}. Raise its "
                f"boss_diameters_mm from {_mm(bore.boss_diameter)} to {_mm(bore.diameter + 2 * ligament)} or more, or "
                f"reduce its bore_diameters_mm from {_mm(bore.diameter)} to "
                f"{_mm(bore.boss_diameter - 2 * ligament)} or less"
            ),
        )
        yield (
            bore.boss_length < wall,
            (
                f"{bore.name}: boss length {_mm(bore.boss_length)} is less than the wall thickness {_mm(wall)}. "
                "Raise boss_length_mm"
            ),
        )
        limit = housing.width / 2 - wall / 2
        yield (
            bore.boss_length > limit,
            (
                f"{bore.name}: boss length {_mm(bore.boss_length)} reaches the opposite boss. Set boss_length_mm to "
                f"at most {_mm(limit)}"
            ),
        )
        room = min(bore.x - low[0], high[0] - bore.x, bore.z - low[2], high[2] - bore.z) - bore.boss_diameter / 2
        yield (
            room < 0.0,
            (
                f"{bore.name}: boss at x = {_mm(bore.x)}, z = {_mm(bore.z)} extends {_mm(-room)} beyond the inner area "
                "of its side wall. Reduce its boss_diameters_mm, or correct left_end_mm, length_mm, shaft_height_mm or "
                "height_mm"
            ),
        )
    for one, two in combinations(housing.bores, 2):
        distance, total = math.hypot(one.x - two.x, one.z - two.z), one.boss_diameter + two.boss_diameter
        gap = distance - total / 2
        if one.side == two.side and gap < ligament:
            smallest = one.diameter + two.diameter + 4 * ligament  # sum of the diameters with the thinnest rings
            smaller = (
                f"Reduce the sum of their boss diameters from {_mm(total)} to {_mm(2 * (distance - ligament))} or "
                f"less, or raise the distance of their axes from {_mm(distance)} to {_mm(total / 2 + ligament)} or more"
            )
            farther = (
                f"With the thinnest rings allowed, {_mm(ligament)}, the sum of their boss diameters is "
                f"{_mm(smallest)}. Raise the distance of their axes from {_mm(distance)} to "
                f"{_mm(smallest / 2 + ligament)} or more, or reduce bore_diameters_mm"
            )
            remedy = smaller if smallest <= 2 * (distance - ligament) else farther
            what = "overlap by" if gap < 0.0 else "leave a ligament of only"
            yield (
                True,
                (
                    f"bosses of {one.name} and {two.name} {what} {_mm(abs(gap))} (limit: a ligament of {_mm(ligament)} "
                    f"or more). {remedy}"
                ),
            )


def _foot_problems(housing: Dimensions) -> Iterator[_Check]:
    feet = housing.feet
    if not len(feet.x) >= 2:
        yield True, f"{len(feet.x)} feet along each side wall. Reduce foot_pitch_mm for at least 2"
        return
    yield (
        2 * feet.length >= housing.width,
        (
            f"feet of {_mm(feet.length)} meet in the middle of the box. Set foot_length_mm to at most "
            f"{_mm(housing.width / 2)}"
        ),
    )
    ends = sorted((x - feet.length / 2, x + feet.length / 2) for x in feet.x)
    for (_, end), (start, _) in pairwise(ends):
        yield (
            start <= end,
            f"two feet overlap by {_mm(end - start)} in x. Reduce foot_length_mm, or raise foot_pitch_mm",
        )
    low, high = housing.box
    yield (
        ends[0][0] < low[0] - 1e-12 or ends[-1][1] > high[0] + 1e-12,
        (
            f"feet from x = {_mm(ends[0][0])} to {_mm(ends[-1][1])} leave the box "
            f"({_mm(low[0])} to {_mm(high[0])}). Reduce foot_length_mm"
        ),
    )


def _pad_problems(housing: Dimensions) -> Iterator[_Check]:
    feet, ligament = housing.feet, _ligament(housing)
    yield (
        (feet.pad_diameter > 0.0) != (feet.pad_height > 0.0),
        (
            f"bolt pads of diameter {_mm(feet.pad_diameter)} and height {_mm(feet.pad_height)}. Set both "
            "pad_diameter_mm and pad_height_mm, or none"
        ),
    )
    room = min(feet.length, feet.overhang or feet.length)
    yield (
        feet.pad_diameter > room,
        (
            f"bolt pads of {_mm(feet.pad_diameter)} do not fit on the foot (limit {_mm(room)}). Reduce "
            f"pad_diameter_mm, or raise {'foot_overhang_mm' if room < feet.length else 'foot_length_mm'} to this value"
        ),
    )
    if not feet.bolt_diameter:
        return
    yield (
        not feet.pad_diameter,
        f"bolt holes of {_mm(feet.bolt_diameter)} need bolt pads. Set pad_diameter_mm and pad_height_mm",
    )
    ring = (feet.pad_diameter - feet.bolt_diameter) / 2
    yield (
        feet.pad_diameter > 0.0 and ring < ligament,
        f"bolt pads leave a ring of {_mm(ring)} around the hole (limit {_mm(ligament)}). Raise pad_diameter_mm",
    )
    least = feet.bolt_diameter + 2 * ligament
    yield (
        least > feet.overhang,
        (
            f"bolt holes of {_mm(feet.bolt_diameter)} need feet that extend {_mm(least)} beyond the side wall, and "
            "they "
            f"extend {_mm(feet.overhang)}. Raise foot_overhang_mm"
        ),
    )


def _flange_problems(housing: Dimensions) -> Iterator[_Check]:
    if (flange := housing.flange) is None:
        return
    (low, high), ligament = housing.box, _ligament(housing)
    bottom, top = flange.split - flange.height / 2, flange.split + flange.height / 2
    floor = low[2] + housing.wall("floor")
    yield (
        bottom < floor or top > high[2] + _TOUCH,
        (
            f"flange from z = {_mm(bottom)} to {_mm(top)} is not on the walls ({_mm(floor)} to {_mm(high[2])}). "
            "Correct "
            "flange.split_plane_mm, or reduce flange.height_mm"
        ),
    )
    for bore in housing.bores:
        radius = bore.boss_diameter / 2
        for edge, name in ((bottom - bore.z, "underside"), (-(top - bore.z), "upper side")):
            # distance from the flange to the boss, seen from the side on which the flange passes
            yield (
                -ligament < edge - radius < ligament and abs(edge - radius) > _TOUCH,
                (
                    f"the {name} of the flange is {_mm(edge - radius)} outside the boss of {bore.name} (negative: "
                    f"inside; allowed: {_mm(ligament)} or more, or {_mm(-ligament)} or less). Correct "
                    "flange.split_plane_mm"
                ),
            )


def _rib_problems(housing: Dimensions) -> Iterator[_Check]:
    if (ribs := housing.ribs) is None:
        return
    if not ribs.per_boss + ribs.end_wall + ribs.cover:
        yield True, "there are no ribs in the table ribs. Set per_boss, end_wall or cover, or delete the table"
        return
    ligament, boxes = _ligament(housing), housing.rib_boxes()
    for bore in housing.bores if ribs.per_boss else ():
        outermost = (ribs.per_boss - 1) / ribs.per_boss * bore.boss_diameter / 2 + ribs.thickness / 2
        limit = (bore.diameter + bore.boss_diameter) / 4
        yield (
            outermost > limit,
            (
                f"{ribs.per_boss} ribs of {_mm(ribs.thickness)} under {bore.name} reach {_mm(outermost)} from its axis "
                f"(limit {_mm(limit)}, the middle of the boss ring). Reduce ribs.per_boss or thickness_mm"
            ),
        )
    limit = min(housing.length, housing.width) / 4
    yield (
        ribs.thickness > limit,
        (f"ribs are {_mm(ribs.thickness)} thick (limit {_mm(limit)}, a quarter of the box). Reduce ribs.thickness_mm"),
    )
    for name, (start, end) in boxes.items():
        for bore in housing.bores if " under " in name else ():
            if name.endswith(f"under {bore.name}") or (bore.side > 0) != (end[1] > 0.0):
                continue
            gap = _distance(start, end, bore.x, bore.z) - bore.diameter / 2
            yield (
                gap < ligament,
                (
                    f"{name} is {_mm(gap)} from the bore of {bore.name} (limit {_mm(ligament)}). Reduce "
                    "ribs.thickness_mm"
                ),
            )
    for (name, one), (other, two) in combinations(boxes.items(), 2):
        if (gap := _gap(one, two)) < ligament:
            what = f"leave only {_mm(gap)} between them" if gap > 0.0 else f"overlap by {_mm(-gap)}"
            what = "touch" if abs(gap) < _TOUCH else what
            yield (
                True,
                f"{name} and {other} {what} (limit: {_mm(ligament)} or more between them). Set fewer or thinner ribs",
            )


def _fillet_problems(housing: Dimensions) -> Iterator[_Check]:
    fillets, (low, high) = housing.fillets, housing.cavity
    for name, radius, limit, why in (
        ("foot", fillets.foot, housing.feet.height, "the height of the feet"),
        ("inner", fillets.inner, 0.5 * float((high - low).min()), "half of the smallest side of the cavity"),
    ):
        yield (
            0.0 < radius < SMALLEST_FILLET,
            (
                f"{name} fillet radius is {_mm(radius)}; faces below {_mm(SMALLEST_FILLET)} cannot be meshed. Raise "
                "it, or set 0 for a sharp edge"
            ),
        )
        yield (
            radius >= limit,
            f"{name} fillet radius is {_mm(radius)} (limit: 0 to below {_mm(limit)}, {why}). Reduce it",
        )


def _name_problems(housing: Dimensions) -> Iterator[_Check]:
    names = [b.name for b in housing.bores] + [s.name for s in housing.sensors]
    for name in dict.fromkeys(names):
        yield names.count(name) > 1, f"the name {name!r} occurs {names.count(name)} times. Set another name"


def _distance(low: np.ndarray, high: np.ndarray, x: float, z: float) -> float:
    """Distance from a point (x, z) to the rectangle of a box seen along y."""
    return math.hypot(max(low[0] - x, x - high[0], 0.0), max(low[2] - z, z - high[2], 0.0))


def _gap(one: Box, two: Box) -> float:
    """Clearance of two boxes along the axis that separates them most; negative when they overlap."""
    return float(max(max(a - b, c - d) for a, b, c, d in zip(two[0], one[1], one[0], two[1], strict=True)))


def _mm(metres: float) -> str:
    return f"{1000 * metres:.6g} mm"
