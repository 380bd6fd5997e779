"""Torsional modes of branched and closed gear trains against small matrices written down by hand.

Shafts that only twist, in rigid bearings, with gears whose teeth give way next to not at all: every gear train is then
a few inertias on springs, reduced to the first shaft by the squares of the speed ratios (Rao, Mechanical Vibrations,
and Friswell, Penny, Garvey & Lees 2010, Dynamics of Rotating Machines, geared and branched systems). The matrices below
are typed in; nothing of ours assembles them.
"""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import mesh_law, no_casing
from scipy.linalg import eigh

from mbd.forces.torque import Torque
from mbd.parts.bearings import rigid_bearing
from mbd.parts.gear_mesh import MeshSpec
from mbd.parts.machine import Machine
from mbd.parts.shafts import Disk, Section, ShaftSpec
from mbd.parts.speed_drive import MotorCoupling, SpeedProfile
from mbd.system.linearised import linear_modes
from mbd.system.system import assemble

ANGLE = math.radians(20.0)
SHEAR = 206e9 / 2 / 1.3
TEETH_STIFFNESS = 1e13  # N/m: 1e-6 of the compliance of the shafts
HOLD = 500.0  # N m/rad, of the motor's coupling, that keeps the train in place
LENGTH = 0.5  # of every shaft, m
TOLERANCE = 5e-5


def spring(diameter):
    """Torsional stiffness of a shaft, G pi d^4/(32 L)."""
    return SHEAR * math.pi * diameter**4 / 32 / LENGTH


def shaft(name, place, sense, diameter, y, first, second):
    """A light shaft from y on with an inertia (kg m2) at either end."""
    return ShaftSpec(
        name=name, x=place[0], z=place[1], sense=sense, model="torsion", elastic_modulus=206e9, poisson_ratio=0.3,
        density=10.0, damping_time=0.0, element_length=10.0,
        sections=(Section(y_start=y, y_end=y + LENGTH, outer_diameter=diameter),),
        disks=tuple(
            Disk(name=f"{name} at {at}", y=at, mass=1.0, polar_inertia=inertia, diametral_inertia=inertia / 2)
            for at, inertia in ((y, first), (y + LENGTH, second))
        ),
    )  # fmt: skip


def teeth(name, y, radii, numbers):
    """A spur mesh "ab" of shafts a and b at y, of constant stiffness, with pitch radii (m) and numbers of teeth."""
    width = 1e-6  # so narrow that tilt does not count
    drive, coast = (
        dataclasses.replace(
            law := mesh_law(flank, module=0.003, helix=0.0, width=width, teeth=numbers, ripple=0.0),
            compliance=np.full_like(law.compliance, width / TEETH_STIFFNESS),
        )
        for flank in ("drive", "coast")
    )
    return MeshSpec(
        name=name, driving=name[0], driven=name[1], y=y, pressure_angle=ANGLE, base_helix_angle=0.0, backlash=1e-3,
        base_radius_driving=radii[0] * math.cos(ANGLE), base_radius_driven=radii[1] * math.cos(ANGLE),
        damping_time=0.0, drive=drive, coast=coast,
    )  # fmt: skip


def frequencies_of(shafts, meshes, loads, motor=True):
    """Oscillating modes (Hz) of a train, the motor's end of shaft a held by a spring or rolling free.

    `loads` (N m) by shaft press the teeth together; they act at the far ends.
    """
    bearings = tuple(
        rigid_bearing(f"{s.name} at {y}", s.name, y, "ground") for s in shafts for y in (s.y_start, s.y_end)
    )
    ends = {s.name: s.y_end for s in shafts}
    forces = [constant(f"load of {name}", name, ends[name], -torque) for name, torque in loads.items()]
    if not motor:
        forces.append(constant("motor", "a", 0.0, 10.0, drives=True))
    machine = Machine(
        shafts=shafts, bearings=bearings, meshes=meshes, gravity=0.0, forces=tuple(forces),
        couplings=(MotorCoupling(name="motor", shaft="a", y=0.0, stiffness=HOLD),) if motor else (),
        input_shaft="" if motor else "a", profile=SpeedProfile(times=np.zeros(1), speeds=np.array([100.0])),
    )  # fmt: skip
    return linear_modes(assemble(machine, no_casing(), band=np.inf), up_to=500.0).frequencies


def constant(name, shaft_name, y, torque, **options):
    return Torque(name=name, shaft=shaft_name, y=y, times=np.zeros(1), torques=np.array([torque]), **options)


def by_hand(stiffness, inertia):
    """Frequencies (Hz) of K q = omega^2 J q, those of rolling left out."""
    squares = eigh(np.array(stiffness), np.diag(inertia), eigvals_only=True)
    return np.sqrt(squares[squares > 1e-6 * squares[-1]]) / (2 * math.pi)


@pytest.mark.parametrize("motor", [True, False])
def test_two_branches_behind_one_pinion(motor):
    """A motor on shaft a turns b at 20/50 and c at 20/30 of its speed: four inertias.

    Angles of shaft a: at the motor, at the gears, at the ends of b and c.
    """
    pinion, b, c = 0.04, 0.04 * 50 / 20, 0.04 * 30 / 20
    shafts = (
        shaft("a", (0.0, 0.0), 1, 0.030, 0.0, 0.8, 0.05),
        shaft("b", (pinion + b, 0.0), -1, 0.035, LENGTH, 0.6, 4.0),
        shaft("c", (-pinion - c, 0.0), -1, 0.025, LENGTH, 0.1, 1.2),
    )
    meshes = teeth("ab", LENGTH, (pinion, b), (20, 50)), teeth("ac", LENGTH, (pinion, c), (20, 30))
    n_b, n_c = (20 / 50) ** 2, (20 / 30) ** 2
    k_a, k_b, k_c = spring(0.030), n_b * spring(0.035), n_c * spring(0.025)
    k_m = HOLD if motor else 0.0
    stiffness = [
        [k_m + k_a, -k_a, 0.0, 0.0],
        [-k_a, k_a + k_b + k_c, -k_b, -k_c],
        [0.0, -k_b, k_b, 0.0],
        [0.0, -k_c, 0.0, k_c],
    ]
    expected = by_hand(stiffness, [0.8, 0.05 + n_b * 0.6 + n_c * 0.1, n_b * 4.0, n_c * 1.2])
    found = frequencies_of(shafts, meshes, {"b": 20.0, "c": 10.0}, motor)
    assert len(expected) == (4 if motor else 3)
    np.testing.assert_allclose(found[: len(expected)], expected, rtol=TOLERANCE)


@pytest.mark.parametrize("motor", [True, False])
def test_two_paths_between_motor_and_load(motor):
    """Shaft a turns d by two paths of unlike gears, 20/60 30/90 over b and 20/40 20/90 over c: 1/9 both.

    Angles of shaft a: at the motor, at its pinion, at the wheel of d, at the load. Between pinion and wheel the shafts
    b and c are springs side by side. The axes of b and c lie where the circles of their centre distances about a and d
    meet, b above and c below.
    """
    pinion, wheel, apart = 0.03, 0.12, 0.2
    b_first, b_second, c_first, c_second = pinion * 60 / 20, wheel * 30 / 90, pinion * 40 / 20, wheel * 20 / 90
    shafts = (
        shaft("a", (0.0, 0.0), 1, 0.030, 0.0, 0.5, 0.02),
        shaft("b", meeting(apart, pinion + b_first, wheel + b_second, 1), -1, 0.040, LENGTH, 0.3, 0.1),
        shaft("c", meeting(apart, pinion + c_first, wheel + c_second, -1), -1, 0.025, LENGTH, 0.2, 0.05),
        shaft("d", (apart, 0.0), 1, 0.060, 2 * LENGTH, 5.0, 30.0),
    )
    meshes = (
        teeth("ab", LENGTH, (pinion, b_first), (20, 60)), teeth("ac", LENGTH, (pinion, c_first), (20, 40)),
        teeth("bd", 2 * LENGTH, (b_second, wheel), (30, 90)), teeth("cd", 2 * LENGTH, (c_second, wheel), (20, 90)),
    )  # fmt: skip
    n_b, n_c, n_d = (1 / 3) ** 2, (1 / 2) ** 2, (1 / 9) ** 2
    k_a, k_p, k_d = spring(0.030), n_b * spring(0.040) + n_c * spring(0.025), n_d * spring(0.060)
    k_m = HOLD if motor else 0.0
    stiffness = [
        [k_m + k_a, -k_a, 0.0, 0.0],
        [-k_a, k_a + k_p, -k_p, 0.0],
        [0.0, -k_p, k_p + k_d, -k_d],
        [0.0, 0.0, -k_d, k_d],
    ]
    inertia = [0.5, 0.02 + n_b * 0.3 + n_c * 0.2, n_b * 0.1 + n_c * 0.05 + n_d * 5.0, n_d * 30.0]
    expected = by_hand(stiffness, inertia)
    found = frequencies_of(shafts, meshes, {"d": 90.0}, motor)
    assert len(expected) == (4 if motor else 3)
    np.testing.assert_allclose(found[: len(expected)], expected, rtol=TOLERANCE)


def meeting(apart, first, second, side):
    """Where circles about (0, 0) and (apart, 0) with these radii meet, above (1) or below (-1) their centres."""
    x = (apart**2 + first**2 - second**2) / (2 * apart)
    return x, side * math.sqrt(first**2 - x**2)
