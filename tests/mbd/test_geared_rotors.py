"""Published natural frequencies of a geared pair of rotors, gyroscopic moments included, and their parts one by one."""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import mesh_law, no_casing
from scipy import linalg

from mbd.forces.gyroscopic_plane import planes
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.bearings import BEARING_AXES, BearingSpec
from mbd.parts.gear_mesh import MeshSpec
from mbd.parts.load import StaticTorque
from mbd.parts.machine import Machine
from mbd.parts.part_checks import MachineError
from mbd.parts.shafts import Disk, Section, ShaftSpec, free_shaft, shaft_nodes
from mbd.parts.speed_drive import MotorCoupling, SpeedProfile
from mbd.system.linearised import linear_modes
from mbd.system.statics import equilibrium
from mbd.system.system import assemble

STEEL = {"elastic_modulus": 207e9, "poisson_ratio": 207 / (2 * 79.5) - 1, "density": 7800.0}
TEETH, BASE_RADIUS, PRESSURE_ANGLE, MESH_STIFFNESS = (328, 23), 0.5086, math.radians(22.5), 1e8
SPEED = 1500 / 60 * 2 * math.pi

# Friswell, Penny, Garvey & Lees (2010), Dynamics of Rotating Machines: generator and turbine, a spur pair between them,
# at 1500 rev/min of the generator (data and results also in the tutorial on multi-rotors of petrobras/ross)
PUBLISHED = [
    11.641,
    12.284,
    17.268,
    18.458,
    23.956,
    37.681,
    49.889,
    50.861,
    56.248,
    57.752,
    59.188,
    63.113,
    74.203,
]  # Hz


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
        name=name, shaft=shaft, y=y, stiffness=(horizontal, 1e10, vertical, 0.0, 0.0),
        damping=tuple(
            tuple(damping * (i == j and a in ("ux", "uz")) for j in range(5)) for i, a in enumerate(BEARING_AXES)
        ),
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
        couplings=(MotorCoupling(name="motor", shaft="generator", y=0.0, stiffness=50.0),),  # only keeps it in place
        profile=SpeedProfile(times=np.zeros(1), speeds=np.array([SPEED])),
        load=StaticTorque(shaft="turbine", drums=(pinion + 5.4,), torque=1e-3),
        gravity=0.0,
        gyroscopic=gyroscopic,
    )  # fmt: skip


def test_published_frequencies_of_a_geared_pair_of_rotors():
    system = assemble(turbine_set(), no_casing(), band=np.inf)
    found = linear_modes(system, up_to=90.0, speed=SPEED).frequencies
    found = found[found > 1.0]  # the weak coupling lets the whole set turn
    np.testing.assert_allclose(found[: len(PUBLISHED)], PUBLISHED, rtol=1e-3)


def overhung(speed):
    """A disk on a shaft so stiff that it tilts as a whole on two tilt springs."""
    shaft = ShaftSpec(
        name="rotor", x=0.0, z=0.0, sense=1, damping_time=0.0, model="torsion",
        sections=(Section(y_start=-0.01, y_end=0.01, outer_diameter=0.02),),
        disks=(disk("disk", 0.0, 20.0, 0.1, 0.18),),
    )  # fmt: skip
    bearing = BearingSpec(
        name="bearing", shaft="rotor", y=0.0, stiffness=(1e9, 1e9, 1e9, 4e3, 4e3), damping_time=0.0, support="ground",
    )  # fmt: skip
    return Machine(
        shafts=(shaft,), bearings=(bearing,), meshes=(), gyroscopic=True, gravity=0.0,
        couplings=(MotorCoupling(name="motor", shaft="rotor", y=0.0, stiffness=1e3),),
        profile=SpeedProfile(times=np.zeros(1), speeds=np.array([speed])),
        load=StaticTorque(shaft="rotor", drums=(0.0,), torque=1.0),
    )  # fmt: skip


@pytest.mark.parametrize("speed", [0.0, 100.0, -100.0])
def test_a_tilting_disk_whirls_at_the_two_frequencies_of_the_formula(speed):
    """J_d w^2 -+ J_p Omega w - k = 0: forward whirl rises, backward whirl falls."""
    found = linear_modes(assemble(overhung(speed), no_casing(), band=np.inf), up_to=100.0, speed=speed).frequencies
    diametral, polar, k = 0.1, 0.18, 4e3  # the shaft itself weighs 50 g
    spin = polar * abs(speed)
    expected = [(math.sqrt(spin**2 + 4 * diametral * k) + s * spin) / (4 * math.pi * diametral) for s in (-1, 1)]
    for value in expected:
        assert abs(found / value - 1).min() < 1e-4


def test_the_time_step_whirls_as_the_linearised_view():
    """Free motion at speed: the two tilt frequencies appear in the tilts, and nothing is lost."""
    speed, rate = 100.0, 4000.0
    system = assemble(overhung(speed), no_casing(), band=np.inf, channels=("bearing:fx",))
    assert planes(system.basis.T @ system.gyroscopic @ system.basis)[3] < 1e-3  # left out of the time step
    state = equilibrium(system, speed)
    tilt = system.layout.axis_row("rotor", 0.0, 3)
    push = np.linalg.solve(system.mass, tilt)
    start = dataclasses.replace(state, velocity=1e-3 * push / (tilt @ push))
    run = simulate(system, MotionSettings(end=0.3, output_rate=rate, step=2e-5), start=start)
    assert abs(run.energy("total", "residual")) < 1e-6 * max(run.energy("total", "scale"), 1.0)
    kinetic = 0.5 * start.velocity @ system.mass @ start.velocity
    stored = sum(run.energy(part, "stored") for part in run.energy_parts if part != "total")
    assert abs(stored) < 1e-3 * kinetic  # it goes back and forth between tilts and springs
    bearing = run.channel("bearing:fx")
    assert np.isfinite(bearing).all()


def test_distributed_gyroscopic_moments_are_those_of_the_whole_body():
    """A rigid tilt of a shaft: G sums to its polar inertia, whatever the elements."""
    section = (Section(y_start=-0.2, y_end=0.2, outer_diameter=0.06, inner_diameter=0.02),)
    spec = ShaftSpec(name="s", x=0.0, z=0.0, sense=1, sections=section, element_length=0.05)
    nodes = shaft_nodes(spec)
    shaft = free_shaft(spec, nodes)
    matrix = shaft.own("gyroscopic")
    tilt = np.zeros((len(nodes), 6, 2))
    tilt[:, 3, 0] = tilt[:, 5, 1] = 1.0
    tilt[:, 2, 0], tilt[:, 0, 1] = nodes, -nodes
    whole = tilt.reshape(-1, 2).T @ matrix @ tilt.reshape(-1, 2)
    polar = spec.density * math.pi / 32 * (0.06**4 - 0.02**4) * 0.4
    np.testing.assert_allclose(whole, [[0.0, -polar], [polar, 0.0]], rtol=1e-9, atol=1e-12 * polar)
    assert abs(matrix + matrix.T).max() == 0.0
    assert abs(np.diag(shaft.mass)).min() > 0.0


def test_the_strongest_planes_rebuild_a_skew_matrix():
    random = np.random.default_rng(3)
    turn = linalg.qr(random.standard_normal((9, 9)))[0]
    skew = np.zeros((9, 9))
    for i, g in zip((0, 2, 4), (5.0, -2.0, 1e-3), strict=True):
        skew[i, i + 1], skew[i + 1, i] = g, -g
    a, b, g, left = planes(turn @ skew @ turn.T, kept=0.999)
    assert len(g) == 2
    assert left == pytest.approx(1e-3 / math.hypot(5.0, 2.0), rel=1e-2)
    rebuilt = sum(s * (np.outer(x, y) - np.outer(y, x)) for x, y, s in zip(a, b, g, strict=True))
    assert abs(rebuilt - turn @ skew @ turn.T).max() < 2e-3


def with_density(density):
    machine = turbine_set()
    shafts = tuple(dataclasses.replace(shaft, density=density) for shaft in machine.shafts)
    return assemble(dataclasses.replace(machine, shafts=shafts), no_casing(), band=np.inf)


def test_light_shafts_come_to_the_frequencies_of_disks_on_springs():
    """What the mass of the shafts changes falls with their density, down to where round-off hides it."""
    found = [linear_modes(with_density(density), up_to=90.0, speed=SPEED).frequencies[:6] for density in (10, 1, 0.1)]
    found = [frequencies[frequencies > 1.0] for frequencies in found]
    assert (found[0] - found[1])[:4] / (found[1] - found[2])[:4] == pytest.approx(10.0, rel=0.1)


@pytest.mark.parametrize("density", [1e-3, 1e-4, 1e-6, 1e-8])
def test_a_shaft_of_next_to_no_mass_is_refused(density):
    """Its own frequencies are so high that round-off of their squares would change the lowest ones by some per cent."""
    with pytest.raises(MachineError, match="has almost no mass"):
        with_density(density)
