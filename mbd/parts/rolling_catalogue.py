"""A small catalogue of rolling bearings by designation.

Boundary dimensions follow ISO 15. Manufacturers do not publish the internal geometry. That of 6205 and 6203 is known
(ball and pitch diameters by the Case Western Reserve University Bearing Data Center for SKF 6205-2RS JEM and
6203-2RS JEM). All others are estimates: pitch diameter (d + D)/2, usual sizes and numbers of elements, groove radii of
0.52 ball diameters. If pass frequencies must be accurate to a few per cent or better, give the actual geometry.
"""

from __future__ import annotations

import difflib
import math
from typing import Any

from mbd.parts.checks import MachineError

# elements, element diameter, pitch diameter, contact angle (deg), roller length; mm
_BALLS: dict[str, tuple[int, float, float, float]] = {
    "6203": (8, 6.746, 28.50, 0.0),
    "6204": (8, 7.938, 33.5, 0.0),
    "6205": (9, 7.940, 39.04, 0.0),
    "6206": (9, 9.525, 46.0, 0.0),
    "6207": (9, 11.112, 53.5, 0.0),
    "6208": (9, 12.000, 60.0, 0.0),
    "6209": (9, 12.700, 65.0, 0.0),
    "6210": (10, 12.700, 70.0, 0.0),
    "6212": (10, 15.875, 85.0, 0.0),
    "6005": (10, 6.350, 36.0, 0.0),
    "6007": (11, 7.938, 48.5, 0.0),
    "6009": (12, 8.731, 60.0, 0.0),
    "6012": (13, 10.319, 77.5, 0.0),
    "6308": (8, 15.081, 65.0, 0.0),
    "6310": (8, 19.050, 80.0, 0.0),
    "6312": (8, 22.225, 95.0, 0.0),
    "7205": (12, 7.938, 38.5, 40.0),
    "7208": (13, 11.906, 60.0, 40.0),
    "7210": (14, 12.700, 70.0, 40.0),
}
_ROLLERS: dict[str, tuple[int, float, float, float, float]] = {
    "NU205": (13, 7.5, 38.5, 0.0, 8.0),
    "NU208": (14, 11.0, 60.0, 0.0, 11.0),
    "NU210": (16, 11.0, 70.0, 0.0, 11.0),
    "30205": (17, 6.9, 38.5, 14.036, 10.5),
    "30208": (18, 9.6, 61.0, 14.036, 12.5),
    "30210": (20, 9.9, 71.0, 15.642, 13.5),
}


def designations() -> tuple[str, ...]:
    """All designations of the catalogue."""
    return (*_BALLS, *_ROLLERS)


def bore_of(name: str) -> float:
    """Bore (m) of a bearing of the catalogue by the bore number of ISO 15, the last two digits: 03 is 17 mm, else five
    times the number."""
    number = int(name[-2:])
    return (17 if number == 3 else 5 * number) / 1000


def catalogued(name: str) -> dict[str, Any]:
    """The fields of `mbd.parts.rolling_elements.RollingElements` of the bearing called ``name``.

    Raises
    ------
    MachineError : not in the catalogue, with what is
    """
    if found := _BALLS.get(name) or _ROLLERS.get(name):
        count, diameter, pitch, angle, *length = found
        return {
            "kind": "roller" if length else "ball",
            "count": count,
            "diameter": diameter / 1000,
            "pitch_diameter": pitch / 1000,
            "contact_angle": math.radians(angle),
            "length": length[0] / 1000 if length else 0.0,
        }
    wanted, known = name.replace(" ", "").upper(), designations()
    near = [one for one in known if wanted.startswith(one)]
    near += [one for one in difflib.get_close_matches(wanted, known, n=4) if one not in near]
    hint = f"Similar: {', '.join(near)}. " if near else ""
    raise MachineError(
        f'designation = "{name}": is not in the catalogue ({", ".join(known)}). {hint}Set one of these, or instead of '
        "designation the geometry (kind, elements, element_diameter_mm, pitch_diameter_mm)"
    )
