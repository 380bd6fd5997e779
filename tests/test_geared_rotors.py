"""Published natural frequencies of a geared pair of rotors, gyroscopic moments included, and their parts one by one."""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import mesh_law, no_casing
from scipy import linalg

from mbd.bearings import BEARING_AXES, BearingSpec
from mbd.drive import CouplingSpec, SpeedProfile
from mbd.gear_mesh import MeshSpec
from mbd.gyroscopic import gyroscopic_matrix, planes
from mbd.linearised import linear_modes
from mbd.load import StaticTorque
from mbd.machine import Machine
from mbd.shafts import Disk, Section, ShaftSpec, shaft_matrices, shaft_nodes
from mbd.simulate import Settings, simulate
from mbd.statics import equilibrium
from mbd.system import assemble

STEEL = {"elastic_modulus": 207e9, "poisson_ratio": 207 / (2 * 79.5) - 1, "density": 7800.0}
TEETH, BASE_RADIUS, PRESSURE_ANGLE, MESH_STIFFNESS = (328, 23), 0.5086, math.radians(22.5), 1e8
SPEED = 1500 / 60 * 2 * math.pi

# Friswell, Penny, Garvey & Lees (2010), Dynamics of Rotating Machines: generator and turbine, a spur pair between them,
# at 1500 rev/min of the generator (data and results also in the tutorial on multi-rotors of petrobras/ross)
PUBLISHED = [11.641, 12.284, 17.268, 18.458, 23.956, 37.681, 49.889, 50.861, 56.248, 57.752, 59.188, 63.113, 74.203]  # Hz


def stepped(lengths, diameters, start):
    places = start + np.concatenate([[0.0], np.cumsum(lengths)])
    return tuple(
        Section(y_start=a, y_end=b, outer_diameter=d) for a, b, d in zip(places, places[1:], diameters, strict=False)
    )


def disk(name, y, mass, diametral, polar):
    return Disk(name=name, y=y, mass=mass, polar_inertia=polar, diametral_inertia=diametral)


def journal(name, shaft, y, horizontal, vertical, damping=3e3):
    """Stiff along the shaft, so that axial motion stays above the published modes."""
    return BearingSpec(
        name=name, shaft=shaft, y=y, stiffness_x=horizontal, stiffness_z=vertical, stiffness_axial=1e10,
        damping=tuple(tuple(damping * (i == j and a in ("ux", "uz")) for j in range(5)) for i, a in enumerate(BEARING_AXES)),
    )  # fmt: skip


def spring_law(flank, stiffness):
    """One pair of constant stiffness on a face so narrow that tilt does not count."""
    width = 1e-6
    law = mesh_law(flank, module=0.003, helix=0.0, width=width, teeth=TEETH, ripple=0.0)
    return dataclasses.replace(law, compliance=np.full_like(law.compliance, width / stiffness))


def turbine_set(gyroscopic=True):
    wheel, pinion = 5.8, 5.8
    first = ShaftSpec(
        name="generator", x=0.0, z=0.0, sense=1, sections=stepped([0.1, 4.24, 1.16, 0.3], [0.3, 0.3, 0.22, 0.22], 0.0),
        disks=(disk("generator", 0.1, 525.7, 16.1, 32.2), disk("disk", 4.34, 116.04, 3.115, 6.23),
               disk("wheel", wheel, 726.4, 56.95, 113.9)), element_length=10.0, damping_time=0.0, **STEEL,
    )  # fmt: skip
    radius = BASE_RADIUS * TEETH[1] / TEETH[0]
    second = ShaftSpec(
        name="turbine", x=(BASE_RADIUS + radius) / math.cos(PRESSURE_ANGLE), z=0.0, sense=-1,
        sections=stepped([0.3, 5.0, 0.1], [0.15] * 3, pinion),
        disks=(disk("pinion", pinion, 5.0, 0.002, 0.004), disk("turbine", pinion + 5.3, 7.45, 0.0745, 0.149)),
        element_length=10.0, damping_time=0.0, **STEEL,
    )  # fmt: skip
    mesh = MeshSpec(
        name="mesh", driving="generator", driven="turbine", y=wheel, base_radius_driving=BASE_RADIUS,
        base_radius_driven=radius, pressure_angle=PRESSURE_ANGLE, base_helix_angle=0.0, backlash=1e-3, damping_time=0.0,
        drive=spring_law("drive", MESH_STIFFNESS), coast=spring_law("coast", MESH_STIFFNESS),
    )  # fmt: skip
    return Machine(
        shafts=(first, second),
        bearings=(journal("b1", "generator", 0.0, 183.9e6, 200.4e6), journal("b2", "generator", 5.5, 183.9e6, 200.4e6),
                  journal("b3", "turbine", pinion + 0.3, 10.1e6, 41.6e6),
                  journal("b4", "turbine", pinion + 5.4, 10.1e6, 41.6e6)),
        meshes=(mesh,),
        couplings=(CouplingSpec(name="motor", shaft="generator", y=0.0, stiffness=50.0),),  # only keeps it in place
        profile=SpeedProfile(times=np.zeros(1), speeds=np.array([SPEED])),
        load=StaticTorque(shaft="turbine", drums=(pinion + 5.4,), torque=1e-3),
        gravity=0.0,
        gyroscopic=gyroscopic,
    )  # fmt: skip


def test_published_frequencies_of_a_geared_pair_of_rotors():
    system = assemble(turbine_set(), no_casing(), band=np.inf)
    found = linear_modes(system, up_to=90.0, speed=SPEED).frequencies
    found = found[found > 1.0]  # the weak coupling lets the whole set turn
    print(np.round(found,3), np.round(found[:13]/PUBLISHED-1,5))
    np.testing.assert_allclose(found[: len(PUBLISHED)], PUBLISHED, rtol=1e-3)
