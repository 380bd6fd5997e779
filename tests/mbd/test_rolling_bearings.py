"""Rolling bearings: Hertz constants, load shares, potential, pass frequencies, varying compliance, energy balance."""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import no_casing, rigid_casing, train

from mbd.forces.rolling_bearing import hertz_bearing, response
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.channels import bearing_force, journal_acceleration
from mbd.parts.checks import EquilibriumError, MachineError
from mbd.parts.load import StaticTorque
from mbd.parts.machine import Machine
from mbd.parts.rolling_catalogue import designations
from mbd.parts.rolling_elements import RollingElements, dimensionless_deflection, pass_frequencies
from mbd.parts.shafts import Disk, Section, ShaftSpec
from mbd.parts.speed_drive import MotorCoupling, SpeedProfile
from mbd.system.statics import equilibrium
from mbd.system.system import assemble

# Harris & Kotzalas (2007), Rolling Bearing Analysis, 5th ed., table 6.1: F(rho) and delta*
HARRIS = [(0.1075, 0.9974), (0.3204, 0.9761), (0.5916, 0.9077), (0.7332, 0.8394), (0.83495, 0.7602), (0.90999, 0.6636),
          (0.95738, 0.5551)]  # fmt: skip


@pytest.mark.parametrize(("difference", "star"), HARRIS)
def test_elliptical_contacts_have_the_tabulated_deflection(difference, star):
    assert dimensionless_deflection(difference) == pytest.approx(star, rel=2e-4)


def ball(count=9, **changes):
    return RollingElements(kind="ball", count=count, diameter=0.012, pitch_diameter=0.06, **changes)


def roller(count=14, **changes):
    return RollingElements(kind="roller", count=count, diameter=0.011, pitch_diameter=0.06, length=0.011, **changes)


def test_a_ball_bearing_is_as_stiff_as_the_handbook_says():
    """K = 2.15e5 (sum rho)^-1/2 (delta*)^-3/2 N/mm^1.5 per contact (Harris & Kotzalas, eq. 7.8; E 206 GPa, nu 0.3)."""
    d, g, f = 12.0, 12.0 / 60.0, 0.52
    found = []
    for sign in (1, -1):
        total = (4 - 1 / f + sign * 2 * g / (1 - sign * g)) / d
        difference = (1 / f + sign * 2 * g / (1 - sign * g)) / (4 - 1 / f + sign * 2 * g / (1 - sign * g))
        found.append(2.15e5 / math.sqrt(total) / dimensionless_deflection(difference) ** 1.5)
    both = (found[0] ** (-2 / 3) + found[1] ** (-2 / 3)) ** -1.5
    assert ball().stiffness / 1000**1.5 == pytest.approx(both, rel=1e-2)  # the handbook gives three digits


def test_a_line_contact_gives_way_as_palmgren_measured():
    """delta = 3.84e-5 Q^0.9/l^0.8 mm per contact (Palmgren 1959); ISO/TS 16281 is within 5 %."""
    load, length = 1000.0, 11.0
    deflection = (load / (roller().stiffness / 1000 ** (10 / 9))) ** 0.9
    assert deflection == pytest.approx(2 * 3.84e-5 * load**0.9 / length**0.8, rel=0.05)


@pytest.mark.parametrize(("make", "integral", "exponent"), [(ball, 0.2288, 1.5), (roller, 0.2453, 10 / 9)])
def test_radial_load_and_deflection_of_many_elements(make, integral, exponent):
    """F = Z K delta^n J(0.5) without clearance; Q_max = F/(Z J): 4.37 and 4.08 F/Z (Harris & Kotzalas, table 7.1)."""
    elements = make(count=12)
    depth = 10e-6
    forces = [
        response(elements, np.array([depth, 0, 0, 0, 0]), cage)[0][0] for cage in np.linspace(0, 2 * np.pi / 12, 24)
    ]
    expected = 12 * elements.stiffness * depth**exponent * integral
    assert np.mean(forces) == pytest.approx(expected, rel=5e-3)
    assert 1 / integral == pytest.approx({1.5: 4.37, 10 / 9: 4.08}[exponent], rel=2e-3)


@pytest.mark.parametrize(
    "elements",
    [ball(), ball(clearance=8e-6), ball(contact_angle=0.6, preload=4e-6), roller(), roller(contact_angle=0.25)],
)
def test_force_and_tangent_follow_from_the_potential(elements):
    u, cage = np.array([2e-5, 1e-5, -1.3e-5, 2e-4, -3e-4]), 0.37
    force, stiff, _ = response(elements, u, cage)
    size = np.array([1e-5, 1e-5, 1e-5, 3e-4, 3e-4])
    for i in range(5):
        step = np.eye(5)[i] * size[i] * 1e-4
        (up, _, high), (down, _, low) = response(elements, u + step, cage), response(elements, u - step, cage)
        assert abs((high - low) / (2 * step[i]) - force[i]) * size[i] < 1e-6 * abs(force * size).max()
        error = abs((up - down) / (2 * step[i]) - stiff[:, i]) * size * size[i]
        assert error.max() < 1e-5 * abs(stiff * np.outer(size, size)).max()
    assert abs(stiff - stiff.T).max() == 0.0
    assert np.linalg.eigvalsh(stiff * np.outer(size, size)).min() > -1e-6 * abs(stiff * np.outer(size, size)).max()


def test_clearance_leaves_a_free_path_and_the_contact_angle_carries_one_way():
    free = ball(clearance=20e-6)
    assert not response(free, np.array([9e-6, 0, 0, 0, 0]))[0].any()
    assert response(free, np.array([15e-6, 0, 0, 0, 0]))[0][0] > 0.0
    angular = RollingElements(designation="7208")
    assert response(angular, np.array([0, 10e-6, 0, 0, 0]))[0][1] > 100.0
    assert not response(angular, np.array([0, -10e-6, 0, 0, 0]))[0].any()
    assert response(RollingElements(designation="NU208"), np.array([0, 1e-4, 0, 0, 0]))[0][1] == 0.0


def test_pass_frequencies_are_those_of_the_bearing_data_center():
    """6205-2RS JEM: 3.5848, 5.4152, 0.39828 of the shaft, defect 4.7135 = 2 BSF (Case Western Reserve University)."""
    found = pass_frequencies(RollingElements(designation="6205"))
    assert found.outer == pytest.approx(3.5848, rel=1e-4)
    assert found.inner == pytest.approx(5.4152, rel=1e-4)
    assert found.cage == pytest.approx(0.39828, rel=2e-4)
    assert 2 * found.spin == pytest.approx(4.7135, rel=2e-4)
    for name in designations():
        elements = RollingElements(designation=name)
        rates = pass_frequencies(elements)
        assert rates.outer + rates.inner == pytest.approx(elements.count)
        assert rates.outer == pytest.approx(elements.count * rates.cage)


def loaded_shaft(elements, speed=60.0, mass=30.0, tau=2e-5):
    """A stiff shaft with a heavy disk in two equal rolling bearings."""
    shaft = ShaftSpec(
        name="shaft_1", x=0.0, z=0.0, sense=1, sections=(Section(y_start=-0.1, y_end=0.1, outer_diameter=0.06),),
        disks=(Disk(name="disk", y=0.0, mass=mass, polar_inertia=0.1, diametral_inertia=0.06),), damping_time=1e-6,
    )  # fmt: skip
    bearings = tuple(
        hertz_bearing(f"bearing_{i + 1}", "shaft_1", y, elements, tau) for i, y in enumerate((-0.05, 0.05))
    )
    return Machine(
        shafts=(shaft,), bearings=bearings, meshes=(),
        couplings=(MotorCoupling(name="motor_1", shaft="shaft_1", y=0.1, stiffness=1e3, damping=1.0),),
        profile=SpeedProfile(times=np.array([0.0, 0.02]), speeds=np.array([0.0, speed])),
        load=StaticTorque(shaft="shaft_1", drums=(0.0,), torque=1.0),
    )  # fmt: skip


def test_the_weight_sinks_into_the_bearings_as_their_curve_says():
    machine = loaded_shaft(ball())
    system = assemble(machine, no_casing())
    q = equilibrium(system).displacement
    motion = np.array([system.layout.axis_row("shaft_1", -0.05, axis) @ q for axis in (0, 1, 2, 3, 5)])
    shaft_mass = 7850 * math.pi * 0.03**2 * 0.2
    force = response(ball(), motion)[0]
    assert -2 * force[2] == pytest.approx((30.0 + shaft_mass) * machine.gravity, rel=1e-6)


def test_the_turning_cage_shakes_the_shaft_at_the_outer_pass_frequency():
    elements, speed = ball(clearance=10e-6), 60.0
    machine = loaded_shaft(elements, speed)
    names = (journal_acceleration("bearing_1", "z"), bearing_force("bearing_1", "z"))
    system = assemble(machine, no_casing(), names)
    run = simulate(system, MotionSettings(end=1.2, output_rate=4000.0, step=2.5e-5))
    late = run.time > 0.4
    signal = run.channel(names[0])[late]
    spectrum = abs(np.fft.rfft(signal * np.hanning(len(signal))))
    frequency = np.fft.rfftfreq(len(signal), 1 / 4000.0)
    low = (frequency > 5) & (frequency < 1000)
    top = frequency[low][np.argmax(spectrum[low])]
    passing = pass_frequencies(elements).outer * speed / (2 * np.pi)
    assert abs(top / passing - round(top / passing)) * passing < 2.0  # a harmonic of it
    assert round(top / passing) >= 1
    weight = (30.0 + 7850 * math.pi * 0.03**2 * 0.2) * machine.gravity
    assert run.channel(names[1])[late].mean() == pytest.approx(-weight / 2, rel=5e-3)
    for part in ("bearing_1", "bearing_2"):
        assert abs(run.energy(part, "residual")) < 0.01 * run.energy(part, "scale")
    assert abs(run.energy("total", "residual")) < 1e-6 * run.energy("total", "scale")


def test_nothing_is_lost_in_an_undamped_bearing_that_stands():
    machine = loaded_shaft(ball(), speed=0.0, tau=0.0)
    machine = dataclasses.replace(
        machine,
        shafts=(dataclasses.replace(machine.shafts[0], damping_time=0.0),),
        couplings=(dataclasses.replace(machine.couplings[0], damping=0.0),),
    )
    system = assemble(machine, no_casing())
    state = equilibrium(system)
    lift = np.linalg.solve(system.mass, system.layout.axis_row("shaft_1", 0.0, 2))
    start = dataclasses.replace(state, velocity=0.02 * lift / abs(lift).max())
    run = simulate(
        system, MotionSettings(end=0.1, output_rate=2000.0, step=2.5e-6), start=start
    )  # 8 times less per halving
    energy = 0.5 * start.velocity @ system.mass @ start.velocity
    stored = sum(run.energy(part, "stored") for part in run.energy_parts if part != "total")
    works = run.energy("total", "received")
    assert abs(stored - works) < 2e-4 * energy


@pytest.mark.parametrize("names", [("6205", "6206"), ("NU205", "6206"), ("7205", "7208")])
def test_a_geared_pair_runs_in_rolling_bearings(names):
    profile = SpeedProfile(times=np.array([0.01, 0.03]), speeds=np.array([0.0, 94.0]))
    machine = train(1, load="rope", profile=profile, rope={"container_mass": 300.0})
    bearings = []
    for i, b in enumerate(machine.bearings):
        elements = RollingElements(designation=names[i // 2])
        if elements.contact_angle:  # face to face: each carries the axial load one way
            angle = elements.contact_angle * (1 if i % 2 else -1)
            elements = dataclasses.replace(elements, contact_angle=angle, preload=8e-6 * (1 if i % 2 else -1))
        if elements.kind == "roller" and i % 2:
            elements = RollingElements(designation="6205")  # locates the shaft
        bearings.append(hertz_bearing(b.name, b.shaft, b.y, elements, 1e-5))
    machine = dataclasses.replace(machine, bearings=tuple(bearings))
    system = assemble(machine, rigid_casing(machine))
    load = machine.load
    exact = load.hoist.container_mass * machine.gravity * load.travel_per_radian * machine.ratios()[load.shaft]
    assert equilibrium(system).motor_torque == pytest.approx(exact, rel=1e-9)
    run = simulate(system, MotionSettings(end=0.06, output_rate=5e3, step=1e-5))
    assert np.isfinite(run.values).all()
    assert abs(run.energy("total", "residual")) < 2e-6 * run.energy("total", "scale")
    for b in machine.bearings:
        assert abs(run.energy(b.name, "residual")) < 0.01 * run.energy(b.name, "scale")


@pytest.mark.parametrize("clearance_um", [5.0, 20.0, 100.0])
@pytest.mark.parametrize("mass", [0.3, 2.0, 20.0, 2000.0])
def test_light_and_heavy_loads_find_their_place_in_wide_clearances(mass, clearance_um):
    """From a start where every bearing is open, so that the shafts have no stiffness; mesh forces balance the load."""
    machine = train(1, load="rope", rope={"container_mass": mass})
    elements = ball(clearance=clearance_um * 1e-6)
    bearings = tuple(hertz_bearing(b.name, b.shaft, b.y, elements, 1e-5) for b in machine.bearings)
    machine = dataclasses.replace(machine, bearings=bearings)
    load, first = machine.load, machine.meshes[0]
    torque = load.hoist.container_mass * machine.gravity * load.travel_per_radian * machine.ratios()[load.shaft]
    state = equilibrium(assemble(machine, no_casing()))
    assert state.motor_torque == pytest.approx(torque, rel=1e-8)
    assert state.mesh_force[0] == pytest.approx(torque / first.base_radius_driving, rel=1e-8)


def test_unloaded_gears_in_bearings_with_clearance_are_refused_by_load_and_bearings():
    """Nothing presses the shafts against the elements: the gears may rest anywhere within the clearance."""
    machine = train(1, torque=0.0)
    bearings = tuple(hertz_bearing(b.name, b.shaft, b.y, ball(clearance=1e-5), 1e-5) for b in machine.bearings)
    machine = dataclasses.replace(machine, bearings=bearings)
    with pytest.raises(EquilibriumError, match=r"carries 0 N.* bearing_1, .*Give the machine a load, or .*clearance"):
        equilibrium(assemble(machine, no_casing()))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: RollingElements(designation="9999"), "not in the catalogue"),
        (lambda: ball(count=30), "overlap"),
        (lambda: RollingElements(kind="roller", count=10, diameter=0.01, pitch_diameter=0.06), "contact length"),
    ],
)
def test_impossible_bearings_are_refused(make, message):
    with pytest.raises(MachineError, match=message):
        make()
