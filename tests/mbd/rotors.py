"""A rotor that has a closed form: a disk amid a light shaft in rigid bearings, motors that hold its speed."""

import math
from dataclasses import dataclass

import numpy as np

from mbd.elements.reading import Reading
from mbd.parts.bearings import rigid_bearing
from mbd.parts.load import OutsideForce, StaticTorque
from mbd.parts.machine import Machine
from mbd.parts.shafts import Disk, Section, ShaftSpec
from mbd.parts.speed_drive import MotorCoupling, SpeedProfile

LENGTH, DIAMETER, MASS, MODULUS, RATIO = 0.5, 0.02, 10.0, 206e9, 0.3
DAMPING = 0.05
SHAFT_SHARE = 17 / 35  # of the mass of a simply supported shaft that moves with its middle

_AREA, _SECOND_MOMENT = math.pi * DIAMETER**2 / 4, math.pi * DIAMETER**4 / 64
_SHEAR = 6 * (1 + RATIO) / (7 + 6 * RATIO) * MODULUS / (2 * (1 + RATIO)) * _AREA  # kappa G A
STIFFNESS = 1 / (LENGTH**3 / (48 * MODULUS * _SECOND_MOMENT) + LENGTH / (4 * _SHEAR))  # N/m amid the shaft
SHAFT_MASS = MASS / 100
MOVING = MASS + SHAFT_SHARE * SHAFT_MASS
CRITICAL = math.sqrt(STIFFNESS / MOVING)  # rad/s


@dataclass(frozen=True, eq=False, kw_only=True)
class Probe(OutsideForce):
    """No force: reads x and z of a shaft."""

    def readings(self, lay):
        return {
            f"{self.name}:{axis}": Reading("m", displacement=lay.axis_row(self.shaft, self.y, i))
            for i, axis in ((0, "x"), (2, "z"))
        }


PROBE = ("probe:x", "probe:z")


def jeffcott(*forces, speed=0.0, profile=None, sense=1, gravity=0.0, disk_mass=MASS):
    """The rotor with further forces; the probe sits on its disk."""
    if profile is None:
        profile = SpeedProfile(times=np.zeros(1), speeds=np.array([speed]))
    disk = Disk(name="disk", y=LENGTH / 2, mass=disk_mass, polar_inertia=1e-3, diametral_inertia=0.025)
    shaft = ShaftSpec(
        name="shaft_1", x=0.0, z=0.0, sense=sense, disks=(disk,), density=SHAFT_MASS / (_AREA * LENGTH),
        sections=(Section(y_start=0.0, y_end=LENGTH, outer_diameter=DIAMETER),), elastic_modulus=MODULUS,
        poisson_ratio=RATIO, damping_time=2 * DAMPING / CRITICAL,
    )  # fmt: skip
    return Machine(
        shafts=(shaft,),
        bearings=tuple(rigid_bearing(f"bearing_{i + 1}", "shaft_1", y) for i, y in enumerate((0.0, LENGTH))),
        meshes=(),
        couplings=(MotorCoupling(name="motor_1", shaft="shaft_1", y=0.0, stiffness=1e5, damping=1.0),),
        profile=profile,
        load=StaticTorque(shaft="shaft_1", drums=(LENGTH,), torque=0.0),
        forces=(Probe(name="probe", shaft="shaft_1", y=LENGTH / 2), *forces),
        gravity=gravity,
    )


def line(time, values, frequency):
    """Complex amplitude of the line at ``frequency`` (rad/s): values = Re(amplitude e^(i frequency t)) and a mean."""
    turned = np.column_stack([np.cos(frequency * time), -np.sin(frequency * time), np.ones_like(time)])
    real, imaginary, _ = np.linalg.lstsq(turned, values, rcond=None)[0]
    return complex(real, imaginary)
