"""Rolling elements of a bearing: geometry, stiffness of one element, pass frequencies.

K of a ball combines its contacts with both rings, 1/K = (K_i^(-2/3) + K_o^(-2/3))^(3/2), by Hertz' theory of elliptical
contacts; K of a roller is c_L l^(8/9), c_L = 35 948 N/mm^(10/9) mm^(-8/9) for steel (both contacts).

References
----------
Harris & Kotzalas (2007), Rolling Bearing Analysis, 5th ed., ch. 6 (Hertz contacts); ISO/TS 16281:2008, 4.3 (c_L);
Brewe & Hamrock (1977), J. Lubr. Technol. 99, 485-487.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from fem.numerics.root_finding import brentq
from fem.options import option
from mbd.parts.part_checks import MachineError, positive
from mbd.parts.rolling_catalogue import catalogued

LINE_CONSTANT = 35948.0 * 1000.0 ** (10 / 9 + 8 / 9)  # c_L in N, m
STEEL = (206e9, 0.3)
REFERENCE_SHARE = 0.02
_NEEDED = {
    "kind": "kind",
    "count": "elements",
    "diameter": "element_diameter_mm",
    "pitch_diameter": "pitch_diameter_mm",
}  # keys of a scene


@dataclass(frozen=True, kw_only=True)
class RollingElements:
    """Rolling elements and races; those that are not given are taken from the catalogue by their ``designation``."""

    designation: str | None = option(
        None,
        text='bearing of the built-in catalogue, e.g. "6208"; without it give kind, elements, element_diameter_mm and '
        "pitch_diameter_mm",
    )
    kind: Literal["ball", "roller"] = option(None, text="shape of the rolling elements")
    count: int = option(None, key="elements", ge=3, le=100, text="number of rolling elements")
    diameter: float = option(None, unit="mm", key="element_diameter_mm", gt=0, text="diameter of a ball or roller")
    pitch_diameter: float = option(
        None, unit="mm", gt=0, text="diameter of the circle through the centres of the elements"
    )
    contact_angle: float = option(
        None,
        unit="deg",
        ge=-60,
        le=60,
        text="contact angle without load; positive: the bearing supports the shaft against +y",
    )
    length: float = option(None, unit="mm", key="roller_length_mm", ge=0, text="effective contact length of a roller")
    inner_conformity: float = option(
        0.52, gt=0.5, le=0.6, text="groove radius of the inner race divided by ball diameter"
    )
    outer_conformity: float = option(
        0.52, gt=0.5, le=0.6, text="groove radius of the outer race divided by ball diameter"
    )
    clearance: float = option(
        0.0,
        unit="um",
        key="radial_clearance_um",
        ge=-100,
        le=1000,
        text="clearance on the diameter; negative: interference",
    )
    preload: float = option(
        0.0,
        unit="um",
        key="axial_preload_um",
        ge=-1000,
        le=1000,
        text="axial displacement of the inner ring relative to the outer one at assembly",
    )
    cage_start: float = option(0.0, unit="deg", ge=-360, le=360, text="angle of the first rolling element at t = 0")

    def __post_init__(self) -> None:
        known = {} if self.designation is None else catalogued(self.designation)
        for name, value in ({"contact_angle": 0.0, "length": 0.0} | known).items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)
        if missing := [key for name, key in _NEEDED.items() if getattr(self, name) is None]:
            raise MachineError(
                f"{', '.join(missing)}: not set. Set them, or designation for a bearing of the catalogue"
            )
        if given := [key for name, key in _NEEDED.items() if known and getattr(self, name) != known[name]]:
            raise MachineError(
                f'designation = "{self.designation}" already determines {", ".join(given)}. Delete one or the other'
            )
        room = self.pitch_diameter * math.sin(math.pi / self.count)
        if self.diameter > room:
            raise MachineError(
                f"{self.count} rolling elements of element_diameter_mm = {self.diameter * 1e3:g} overlap on "
                f"pitch_diameter_mm = {self.pitch_diameter * 1e3:g}. Set an element diameter of at most "
                f"{room * 1e3:.3f}."
            )
        if self.kind == "roller":
            positive("rolling elements length", self.length, "Set the effective contact length, roller_length_mm.")

    @property
    def gamma(self) -> float:
        """D cos a over the pitch diameter."""
        return self.diameter * math.cos(self.contact_angle) / self.pitch_diameter

    @property
    def stiffness(self) -> float:
        """K of one element, N/m^1.5 for a ball, N/m^(10/9) for a roller: both contacts in series."""
        if self.kind == "roller":
            return LINE_CONSTANT * self.length ** (8 / 9)
        d, g = self.diameter, self.gamma
        inner = ball_contact(2 / d, 2 / d, 2 * g / (d * (1 - g)), -1 / (self.inner_conformity * d))
        outer = ball_contact(2 / d, 2 / d, -2 * g / (d * (1 + g)), -1 / (self.outer_conformity * d))
        return float((inner ** (-2 / 3) + outer ** (-2 / 3)) ** -1.5)


def ball_contact(*curvatures: float) -> float:
    """Constant K (N/m^1.5) in Q = K delta^1.5 of a steel contact.

    ``curvatures`` (1/m): body 1 in the rolling direction and across it, then body 2 (hollow negative).
    The ratio kappa of the axes solves F(rho) = ((k^2 + 1) E - 2 F)/((k^2 - 1) E), F and E the complete elliptic
    integrals of 1 - 1/k^2; delta = delta* (3 Q/(2 sum E'))^(2/3) sum/2, delta* = (2 F/pi) (pi/(2 k^2 E))^(1/3).
    """
    one, across_one, two, across_two = curvatures
    total = sum(curvatures)
    star = dimensionless_deflection(abs((one - across_one) + (two - across_two)) / total)
    modulus, nu = STEEL
    soft = 3 / (2 * total) * 2 * (1 - nu**2) / modulus
    return float((star * soft ** (2 / 3) * total / 2) ** -1.5)


def dimensionless_deflection(difference: float) -> float:
    """delta* of the curvature difference F(rho) in [0, 1)."""
    if difference < 1e-9:
        return 1.0

    from scipy import special  # imported here because it is slow to import, and only known rolling elements need it

    def miss(log_kappa: float) -> float:
        k2 = math.exp(2 * log_kappa)
        first, second = special.ellipk(1 - 1 / k2), special.ellipe(1 - 1 / k2)
        return ((k2 + 1) * second - 2 * first) / ((k2 - 1) * second) - difference

    k2 = math.exp(2 * brentq(miss, 1e-6, 12.0, xtol=1e-13))
    first, second = special.ellipk(1 - 1 / k2), special.ellipe(1 - 1 / k2)
    return float(2 * first / math.pi * (math.pi / (2 * k2 * second)) ** (1 / 3))


@dataclass(frozen=True)
class PassFrequencies:
    """Pass frequencies per revolution of the shaft, with a fixed outer ring."""

    outer: float  # BPFO, elements that pass a point of the outer ring
    inner: float  # BPFI
    spin: float  # BSF, turns of an element; a defect on it strikes twice as often
    cage: float  # FTF


def pass_frequencies(elements: RollingElements) -> PassFrequencies:
    """Pass frequencies without slip."""
    z, g = elements.count, elements.gamma
    spin = elements.pitch_diameter / (2 * elements.diameter) * (1 - g * g)
    return PassFrequencies(z / 2 * (1 - g), z / 2 * (1 + g), spin, (1 - g) / 2)


def reference_load(elements: RollingElements) -> float:
    """Radial load (N), a small share of the static capacity: 12 MPa Z D^2 of balls, 44 MPa Z D l of rollers."""
    across = elements.diameter if elements.kind == "ball" else elements.length
    capacity = (12e6 if elements.kind == "ball" else 44e6) * elements.count * elements.diameter * across
    return REFERENCE_SHARE * capacity * math.cos(elements.contact_angle)
