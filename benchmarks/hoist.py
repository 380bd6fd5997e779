"""A hoist that tests and checks share: one shaft whose motor prescribes the drum, and a container on its ropes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from mbd.forces.rope import Rope, RopeLoad
from mbd.parts.bearings import BearingSpec
from mbd.parts.machine import STANDARD_GRAVITY, Machine
from mbd.parts.shafts import Disk, Section, ShaftSpec
from mbd.parts.speed_drive import MotorCoupling, SpeedProfile

MASS, RADIUS, LENGTH, FALLS = 1000.0, 0.1, 5.0, 8
LOAD = RopeLoad(
    container_mass=MASS,
    drum_radius=RADIUS,
    drum_mass=10.0,
    drum_inertia=0.05,
    rope_falls=FALLS,
    rope_length=LENGTH,
    rope_damping_ratio=0.0,
)
EA = LOAD.axial_stiffness
OMEGA = math.sqrt(FALLS * EA / LENGTH / MASS)  # rad/s
WEIGHT = MASS * STANDARD_GRAVITY


def hoist(
    *,
    speed: float = 0.2,
    tau: float = 0.1,
    start: float = 0.05,
    damping: float = 0.0,
    follow: bool = False,
    coupling: float = 5e7,
) -> Machine:
    """A container lifted to `speed` (m/s) within `tau` from `start` on (s).

    `damping` is the ratio of the ropes, whose length `follow`s the drum or stays; `coupling` the stiffness by which the
    motor holds the shaft (N m/rad).
    """
    shaft = ShaftSpec(
        name="shaft_1",
        x=0.0,
        z=0.0,
        sense=1,
        sections=(Section(y_start=-0.2, y_end=0.2, outer_diameter=0.1),),
        disks=(Disk(name="drum", y=0.0, mass=20.0, polar_inertia=0.1, diametral_inertia=0.1),),
    )
    bearings = tuple(
        BearingSpec(name=name, shaft="shaft_1", y=y, stiffness=(1e9, 1e8, 1e9, 0.0, 0.0))
        for name, y in (("bearing_1", -0.15), ("bearing_2", 0.15))
    )
    load = Rope(
        shaft="shaft_1",
        drums=(-0.02, 0.02),
        hoist=replace(LOAD, rope_damping_ratio=damping),
        follow_length=follow,
    )
    return Machine(
        shafts=(shaft,),
        bearings=bearings,
        meshes=(),
        couplings=(MotorCoupling(name="motor_1", shaft="shaft_1", y=0.0, stiffness=coupling),),
        profile=SpeedProfile(times=np.array([start, start + tau]), speeds=np.array([0.0, speed * 2 / RADIUS])),
        load=load,
    )
