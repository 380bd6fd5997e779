"""Which rigid radius stands for a pinion that is cut on its shaft: python -m benchmarks.shaft_pinion

The shaft model takes the torque at mid face and runs through the pinion at its own diameter; the pinion is elastic from
a rigid radius outwards. Tetrahedra of pinion and shaft in one piece, held at one end of the shaft, give what both
together should: their deflection less that of the beam is what the pinion alone has to have. The rigid radius that
gives it is found from rings of tetrahedra of the same sizes, held at their bores. Once for an even torque on all teeth
and once for the force on one tooth, which bends the shaft as well.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.clock import conditions
from benchmarks.gear_pairs import gear
from benchmarks.tetrahedral_gear import Patch, Ring, Sizes, compliance
from fem.gears.gear import Gear
from fem.gears.profile import form_radius, roll_length

RESULTS = Path(__file__).resolve().parent / "results" / "shaft_pinion.json"
YOUNG, POISSON = 206e9, 0.3
SHEAR = YOUNG / 2 / (1 + POISSON)
SIZES = Sizes(flank=0.6e-3, teeth=1.6e-3, body=2.4e-3)  # the same in all: what they cost cancels
HOLE = 0.2  # of the root radius: a hole in the shaft, which spares a mesh at the axis
BORES = (0.4, 0.6, 0.8)  # of the root radius
LAYER = 2.0e-3  # m


@dataclass(frozen=True, kw_only=True)
class Case:
    """A pinion of module 2 mm, spur: teeth, face width in mm and the shaft's diameter over that of the root circle."""

    teeth: int
    face: float
    shaft: float


CASES = (
    Case(teeth=20, face=12.0, shaft=0.75),
    Case(teeth=20, face=12.0, shaft=0.9),
)


def _patches(one: Gear) -> list[Patch]:
    """The same line on every tooth, in the middle of the involute."""
    low, high = (roll_length(one, r) ** 2 / (2 * one.base_radius) for r in (form_radius(one), one.tip_form_radius))
    half, width = one.face_width / 2, 0.25 * one.normal_module
    return [Patch(arc=(low + high) / 2, half_width=width, low=-half, high=half, tooth=n) for n in range(one.teeth)]


def _modes(matrix: np.ndarray) -> tuple[float, float]:
    """Deflection (m/N) of tooth 0 under a force shared by all teeth, and under one on itself."""
    return float(matrix[0].mean()), float(matrix[0, 0])


def on_bore(case: Case, bore: float) -> tuple[float, float]:
    """Deflections of the pinion held at a radius, given over that of the root circle."""
    one = gear(case.teeth, face_mm=case.face, bore_mm=1.0)
    half = one.face_width / 2
    ring = Ring(inner=bore * one.root_radius, outer=one.tip_radius, low=-half, high=half)
    layers = np.linspace(-half, half, math.ceil(one.face_width / LAYER) + 1)
    return _modes(compliance(one, [ring], "bore", _patches(one), layers, SIZES, YOUNG, POISSON)[0])


def on_shaft(case: Case) -> tuple[float, float]:
    """Deflections of the pinion in one piece with its shaft less those of the beam."""
    one = gear(case.teeth, face_mm=case.face, bore_mm=1.0)
    half, outer = one.face_width / 2, case.shaft * one.root_radius
    inner, shaft_end = HOLE * one.root_radius, 2 * outer
    rings = [
        Ring(inner=outer, outer=one.tip_radius, low=-half, high=half),
        Ring(inner=inner, outer=outer, low=-half - shaft_end, high=half + outer),
    ]
    parts = [(-half - shaft_end, -half), (-half, half), (half, half + outer)]
    layers = np.unique(
        np.round(np.concatenate([np.linspace(a, b, math.ceil((b - a) / LAYER) + 1) for a, b in parts]), 9)
    )
    torque, force = _modes(compliance(one, rings, "end", _patches(one), layers, SIZES, YOUNG, POISSON)[0])
    length = half + shaft_end
    second, area, ratio = math.pi / 4 * (outer**4 - inner**4), math.pi * (outer**2 - inner**2), (inner / outer) ** 2
    twist = one.base_radius**2 * length / (SHEAR * 2 * second)
    # Cowper (1966): shear of the hollow circle
    shear = 6 * (1 + POISSON) * (1 + ratio) ** 2 / ((7 + 6 * POISSON) * (1 + ratio) ** 2 + (20 + 12 * POISSON) * ratio)
    bending = length**3 / (3 * YOUNG * second) + length / (shear * SHEAR * area)
    return torque - twist, force - twist - bending


def _store(found: dict) -> None:
    RESULTS.write_text(json.dumps({"conditions": conditions(), "cases": found}, indent=1) + "\n", encoding="utf-8")


def main() -> None:
    """Compute, store and print."""
    found = json.loads(RESULTS.read_text(encoding="utf-8"))["cases"] if RESULTS.exists() else {}
    for case in CASES:
        name = f"z {case.teeth}, b {case.face:g} mm, shaft {case.shaft:g} of the root circle"
        base = f"z {case.teeth}, b {case.face:g} mm, rings"
        if base not in found:
            found[base] = [on_bore(case, bore) for bore in BORES]
            _store(found)
        if name not in found:
            found[name] = on_shaft(case)
            _store(found)
        rings = np.array(found[base])
        for mode, label in enumerate(("even torque", "force on one tooth")):
            wanted = found[name][mode]
            # nearly linear in 1 / radius^2, as the wind-up of an annulus is
            radius = np.interp(-wanted, -rings[:, mode], np.array(BORES) ** -2.0, left=np.nan, right=np.nan) ** -0.5
            print(
                f"{name}, {label}: {1e9 * wanted:.3f} nm/N, rings {np.round(1e9 * rings[:, mode], 3)}, "
                f"rigid radius {radius:.3f} r_f",
                flush=True,
            )


if __name__ == "__main__":
    main()
