"""Prescribed deviations of a gear's teeth: eccentricity, waves, errors of single teeth, measured flanks.

Deviations are positive for more material, as in ISO 1328-1 and ISO 21771-1. Along the transverse line of action they
are gaps of the opposite sign. phi is the rotation of the gear since tooth 0 touched at the pitch point at mid face,
positive in its direction of rotation while the pinion drives at positive speed:

    eccentricity e at the angle a in front of that point of tooth 0:      gap -e sin(phi + a + alpha_wt)
                                                                          gap  e sin(phi + a - alpha_wt)
    wave of order k, amplitude A, phase q:                                deviation A cos(k phi + q)

The first gap is that of the drive flank of a pinion and of the coast flank of a wheel, the second that of the other
two: they are the displacement e (cos, sin)(phi + a) of the axis, in the frame of the line of centres, projected on the
force on the mate, (sin alpha_wt, +-cos alpha_wt). All teeth in contact at one time have the same gap, so that the
transmission error is a wave of amplitude e, which includes the slope within a tooth. The change of the working centre
distance is of second order and neglected. Run-out of ISO 1328-1 is 2 e.

A wave results from the drive of the machine tool on a flank that is generated along its contact lines; it is constant
along them. Orders that are not a multiple of z have a different phase on each tooth, and give a ghost order: Smith
(2003), Gear Noise and Vibration, 2nd ed., 10.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from fem.gears.gear import Gear
from fem.gears.gear_checks import require
from fem.gears.geometry import GearPair
from fem.options import option

FLANKS = ("drive", "coast")
LARGEST_PART = 0.1  # modules; a larger deviation indicates wrong units


@dataclass(frozen=True, kw_only=True)
class Eccentricity:
    """Distance of the axis of the teeth from the axis of rotation, and its direction from tooth 0."""

    amount: float = option(
        0.0,
        unit="um",
        key="eccentricity_um",
        ge=0,
        le=5000,
        text="eccentricity of the teeth from the axis of rotation, half the run-out",
    )
    angle: float = option(
        0.0,
        unit="deg",
        key="eccentricity_angle_deg",
        ge=-360,
        le=360,
        text="angle from tooth 0 to the eccentricity, positive in the sense of rotation of the gear",
    )


@dataclass(frozen=True, kw_only=True)
class Wave:
    """Waviness of the flanks along the circumference: ghost orders."""

    order: int = option(ge=1, le=100_000, text="number of waves around the circumference")
    amplitude: float = option(unit="um", ge=0, le=1000, text="half the height from trough to crest")
    phase: float = option(
        0.0, unit="deg", ge=-360, le=360, text="phase of the waves where tooth 0 touches at the pitch point; 0: a crest"
    )
    flank: Literal["drive", "coast", "both"] = option("both", text="flanks that have the waves")


@dataclass(frozen=True, kw_only=True)
class ToothError:
    """Deviations of one flank of one tooth."""

    tooth: int = option(ge=0, text="number of the tooth; tooth 0 touches at the pitch point at mesh cycle c = 0")
    flank: Literal["drive", "coast"] = option("drive", text="flank of the tooth")
    pitch: float = option(
        0.0,
        unit="um",
        ge=-1000,
        le=1000,
        text="pitch deviation along the reference circle; positive: more material",
    )
    profile_slope: float = option(
        0.0,
        unit="um",
        ge=-1000,
        le=1000,
        text="profile slope deviation f_Halpha over the active profile; positive: more material towards the tip",
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class MeasuredFlanks:
    """Deviations (m) at points of the flanks of some teeth, linear between the points and constant beyond them.

    tooth (t,) int; radius (r,) and face (y,), m, ascending; deviation (flank, t, r, y), drive first, along the face
    coordinate of the mesh law
    """

    tooth: np.ndarray
    radius: np.ndarray
    face: np.ndarray
    deviation: np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class PrescribedDeviations:
    """All prescribed deviations of a gear."""

    eccentricity: Eccentricity = field(default_factory=Eccentricity)
    waves: tuple[Wave, ...] = ()
    teeth: tuple[ToothError, ...] = ()
    measured: MeasuredFlanks | None = None


def check_prescribed(gear: Gear, given: PrescribedDeviations, positions: float) -> None:
    """Refuse implausible deviations, and waves too short for the resolution of the mesh law.

    Parameters
    ----------
    gear, given : the gear and its prescribed deviations
    positions : grid points of the mesh law per base pitch

    Raises
    ------
    GeometryError : a deviation above 0.1 m_n, a tooth that does not exist, an order with less than 8 grid points per
        wave
    """
    limit = LARGEST_PART * gear.normal_module
    amounts = {"eccentricity": given.eccentricity.amount}
    amounts |= {f"amplitude of the wave of order {wave.order}": wave.amplitude for wave in given.waves}
    for error in given.teeth:
        amounts |= {
            f"pitch of tooth {error.tooth}": error.pitch,
            f"profile of tooth {error.tooth}": error.profile_slope,
        }
    if given.measured is not None:
        amounts["largest measured deviation"] = float(np.abs(given.measured.deviation).max())
    for name, value in amounts.items():
        require(
            abs(value) <= limit,
            f"gear z={gear.teeth}: the {name} is {value * 1e6:.4g} um, more than 0.1 modules. Set at most "
            f"{limit * 1e6:.4g} um",
        )
    most = math.floor(gear.teeth * positions / 8)
    for wave in given.waves:
        require(
            1 <= wave.order <= most,
            f"gear z={gear.teeth}: order = {wave.order} of a wave is too high for {positions:g} mesh positions per "
            "base "
            f"pitch, 8 for each wave. Set 1 to {most}, or raise mesh.positions",
        )
    teeth = [error.tooth for error in given.teeth]
    if given.measured is not None:
        teeth += given.measured.tooth.tolist()
    for tooth in teeth:
        require(
            0 <= tooth < gear.teeth,
            f"gear z={gear.teeth}: there is no tooth {tooth}. Set 0 to {gear.teeth - 1}",
        )


def rotation_waves(pair: GearPair, gear: str, flank: str, given: PrescribedDeviations) -> Iterator[tuple[int, complex]]:
    """Orders k and complex amplitudes z (m) of the gaps Re z exp(i k phi) of one flank.

    Parameters
    ----------
    pair, gear : "pinion" or "wheel", whose deviations are `given`
    flank : "drive" or "coast"
    given : all that is stated of the gear
    """
    if given.eccentricity.amount:
        ahead = 1.0 if (gear == "pinion") == (flank == "drive") else -1.0
        turned = given.eccentricity.angle + ahead * (pair.working_pressure_angle + math.pi / 2)
        yield 1, given.eccentricity.amount * np.exp(1j * turned)
    for wave in given.waves:
        if wave.flank in ("both", flank):
            yield wave.order, -wave.amplitude * np.exp(1j * wave.phase)


def single_tooth_terms(
    pair: GearPair, gear: str, flank: str, given: PrescribedDeviations
) -> tuple[np.ndarray, np.ndarray]:
    """Clearance (m) and profile slope (m per base pitch) of the teeth (tooth,), see `fem.contact.teeth`.

    Parameters
    ----------
    pair, gear : "pinion" or "wheel", whose deviations are `given`
    flank : "drive" or "coast"
    given : all that is stated of the gear
    """
    own: Gear = getattr(pair, gear)
    clearance, slope = np.zeros(own.teeth), np.zeros(own.teeth)
    side, length = 1.0 if gear == "pinion" else -1.0, pair.xi_end - pair.xi_start
    for error in given.teeth:
        if error.flank == flank:
            rise = -side * error.profile_slope / length
            middle = rise * (pair.xi_start + pair.xi_end) / 2
            clearance[error.tooth] -= error.pitch * math.cos(own.transverse_pressure_angle) + middle
            slope[error.tooth] += rise
    return clearance, slope


def measured_gap(given: MeasuredFlanks, flank: str, radius: np.ndarray, face: np.ndarray) -> np.ndarray:
    """Gap (t, s, p), m, of the measured teeth.

    Parameters
    ----------
    given : the measured flanks
    flank : "drive" or "coast"
    radius : (p,), m
    face : (s,) face coordinates, m
    """
    along, across = _hats(given.face, face), _hats(given.radius, radius)
    deviation = given.deviation[FLANKS.index(flank)]
    return -np.einsum("sy,try,pr->tsp", along, deviation, across, optimize=True)


def _hats(nodes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Weights (point, node) of linear interpolation, constant beyond the ends."""
    return np.stack([np.interp(points, nodes, unit) for unit in np.eye(len(nodes))], axis=1)
