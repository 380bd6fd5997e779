"""Assembly: rows and virtual work, geared frequencies, channels, refusals, the import rule."""

import dataclasses
import math
import subprocess
import sys

import numpy as np
import pytest
from mbd_rigs import TRANSVERSE_ANGLE, mesh, no_casing, rigid_casing, train

from mbd.parts.channels import acceleration, bearing_force, channel_names
from mbd.parts.gear_mesh import mesh_rows
from mbd.parts.load import StaticTorque
from mbd.parts.machine import Machine
from mbd.parts.part_checks import MachineError
from mbd.parts.shafts import Disk, Section, ShaftSpec
from mbd.parts.speed_drive import MotorCoupling, SpeedProfile
from mbd.system.statics import equilibrium
from mbd.system.system import assemble, natural_frequencies


def pair(angle=0.0, sense=1, hand=1, helix=0.2):
    """A mesh and its two shafts, the driven one in the direction ``angle`` (rad) from x."""
    spec = mesh("m", "a", "b", 0.0, teeth=(20, 55), module=0.002, helix=helix, width=0.012, hand=hand)
    distance = (spec.base_radius_driving + spec.base_radius_driven) / math.cos(TRANSVERSE_ANGLE)
    section = (Section(y_start=-0.1, y_end=0.1, outer_diameter=0.02),)
    a = ShaftSpec(name="a", x=0.0, z=0.0, sense=sense, sections=section)
    b = ShaftSpec(name="b", x=distance * math.cos(angle), z=distance * math.sin(angle), sense=-sense, sections=section)
    return spec, a, b


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5, -1.3])
@pytest.mark.parametrize("sense", [1, -1])
def test_forces_on_a_gear_pair_balance(angle, sense):
    """A rigid motion of both gears together leaves delta and psi alone: by virtual work the forces balance."""
    spec, a, b = pair(angle, sense)
    rows = mesh_rows(spec, a, b)
    for k in range(3):
        translation = np.tile(np.eye(6)[k], 2)
        assert abs(rows @ translation).max() < 1e-15
    for k in range(3):  # rotation about the global axes moves gear b by theta x r
        theta = np.eye(3)[k]
        motion = np.concatenate([np.zeros(3), theta, np.cross(theta, [b.x, 0.0, b.z]), theta])
        assert abs(rows @ motion).max() < 1e-15


@pytest.mark.parametrize("sense", [1, -1])
def test_rolling_leaves_delta_alone_and_torque_closes_the_drive_flank(sense):
    spec, a, b = pair(0.4, sense)
    rows = mesh_rows(spec, a, b)
    roll = np.zeros(12)
    roll[4], roll[10] = sense, -sense * spec.ratio
    assert abs(rows @ roll).max() < 1e-17
    advance = np.zeros(12)
    advance[4] = sense  # the driving gear turns ahead in lifting
    assert (rows @ advance)[0] == pytest.approx(spec.base_radius_driving, rel=1e-12)
    assert (rows @ advance)[2] == pytest.approx(-spec.base_radius_driving, rel=1e-12)


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("hand", [1, -1])
def test_axial_force_of_a_right_hand_driver(sense, hand):
    """The driven gear is pushed along N; a right-hand driver turned about +y is pushed towards +y, itself."""
    spec, a, b = pair(0.0, sense, hand)
    drive, _, coast, _ = mesh_rows(spec, a, b)
    on_driver = -drive[:3]  # force on the driving gear for F = 1
    assert on_driver[1] == pytest.approx(sense * hand * math.tan(0.2), rel=1e-12)
    assert coast[1] == pytest.approx(-drive[1], rel=1e-12)
    assert on_driver[0] == pytest.approx(-math.sin(TRANSVERSE_ANGLE), rel=1e-12)  # pushed away from the wheel


def test_the_normal_is_square_to_the_contact_lines():
    spec, a, b = pair()
    drive = mesh_rows(spec, a, b)[0]
    law = spec.drive
    slope = np.diff(law.cycle_shift)[0] * law.base_pitch / np.diff(law.face_coordinate)[0]
    n = drive[:3] - drive[1] * np.eye(3)[1]
    line = slope * n / np.linalg.norm(n) + np.eye(3)[1] * a.sense
    assert abs(line @ drive[:3]) < 1e-15


def test_tilt_about_the_plane_of_action_is_psi():
    spec, a, b = pair(0.3)
    rows = mesh_rows(spec, a, b)
    n = rows[0, :3] - rows[0, 1] * np.eye(3)[1]
    m = np.cross([0, 1, 0], n)
    tilt = np.concatenate([np.zeros(3), m, np.zeros(6)])
    assert (rows @ tilt)[1] == pytest.approx(a.sense, rel=1e-12)


def test_the_rolling_pattern_loads_no_spring_but_the_couplings():
    machine = train(3, load="rope")
    system = assemble(machine, rigid_casing(machine))
    assert abs(system.rows @ system.rolling).max() < 1e-12
    for part in system.parts:
        if part.name != "drive":
            assert abs(part.stiffness @ system.rolling[part.index]).max() < 1e-9 * abs(part.stiffness).max(initial=1)


def test_geared_inertias_have_the_frequency_of_the_formula():
    """omega^2 = k (r1^2/J1 + r2^2/J2) for two free inertias that touch through a mesh."""
    spec, a, b = pair(helix=0.0)
    inertia = (2e-3, 8e-2)
    stiff = (Section(y_start=-0.01, y_end=0.01, outer_diameter=0.1),)
    shafts = tuple(
        dataclasses.replace(
            s, sections=stiff, density=1.0, model="torsion",
            disks=(Disk(name="d", y=0.0, mass=1e5, polar_inertia=j, diametral_inertia=1e5),),
        )
        for s, j in zip((a, b), inertia, strict=True)
    )  # fmt: skip
    machine = Machine(
        shafts=shafts,
        bearings=tuple(bearing(s.name, s.name) for s in shafts),
        meshes=(spec,),
        couplings=(MotorCoupling(name="motor_1", shaft="a", y=0.0, stiffness=1e-1),),
        profile=SpeedProfile(times=np.zeros(1), speeds=np.zeros(1)),
        load=StaticTorque(shaft="b", drums=(0.0,), torque=50.0),
    )
    system = assemble(machine, no_casing(), band=np.inf)
    k = system.element("m:drive").stiffness[0]
    expected = k * (spec.base_radius_driving**2 / inertia[0] + spec.base_radius_driven**2 / inertia[1])
    found = natural_frequencies(system)
    assert abs(found - math.sqrt(expected) / (2 * math.pi)).min() < 1e-3 * math.sqrt(expected) / (2 * math.pi)


def bearing(name, shaft):
    from mbd.parts.bearings import BearingSpec

    return BearingSpec(
        name=f"bearing_{name}", shaft=shaft, y=0.0, stiffness=(1e9,) * 5,
    )  # fmt: skip


def test_modes_within_the_band_do_not_depend_on_it():
    machine = train(1)
    casing = rigid_casing(machine)
    some, every = (natural_frequencies(assemble(machine, casing, band=band)) for band in (8e3, np.inf))
    count = int((every < 8e3).sum())
    np.testing.assert_allclose(some[:count], every[:count], rtol=1e-9)


def test_channels_are_named_after_what_they_read():
    machine = train(1, load="rope")
    names = channel_names(machine, ("sensor_1",))
    assert acceleration("sensor_1", "z") in names
    assert bearing_force("bearing_4", "x") in names
    assert assemble(machine, rigid_casing(machine), names).channels.names == names


@pytest.mark.parametrize(
    ("names", "message"),
    [(("stage_9:delta",), "unknown"), (("sensor_9:ax",), "no row"), (("shaft_1:colour",), "known: motor_1:angle")],
)
def test_unknown_channels_are_refused(names, message):
    machine = train(1)
    with pytest.raises(MachineError, match=message):
        assemble(machine, rigid_casing(machine), names)


def test_casing_sensors_are_refused_without_a_casing():
    machine = train(1)
    with pytest.raises(MachineError, match="does not move"):
        assemble(machine, no_casing(), ("sensor_1:ax",))


def test_a_casing_for_another_layout_is_refused():
    machine = train(1)
    casing = rigid_casing(machine)
    moved = casing.replaced(point_positions=casing.point_positions + [1e-3, 0, 0])
    with pytest.raises(MachineError, match=r"1\.000 mm"):
        assemble(machine, moved)


def test_a_shaft_without_axial_hold_is_refused_by_name():
    machine = train(1)
    loose = tuple(dataclasses.replace(b, stiffness=(1e8, 0.0, 1e8, 1e4, 1e4)) for b in machine.bearings)
    spur = dataclasses.replace(machine, bearings=loose, meshes=(mesh(
        "stage_1", "shaft_1", "shaft_2", -0.05, teeth=(20, 55), module=0.002 / math.cos(0.21), helix=0.0, width=0.012,
    ),))  # fmt: skip
    with pytest.raises(MachineError, match=r"shaft_\d:\d+:uy has no stiffness"):
        assemble(spur, no_casing())


@pytest.mark.parametrize(("times", "speeds"), [([0, 0.3, 0.2], [0, 1, 2]), ([0, 0], [0, 1]), ([0], [0, 1]), ([], [])])
def test_a_speed_table_that_goes_back_in_time_is_refused(times, speeds):
    with pytest.raises(MachineError, match="speed profile"):
        SpeedProfile(times=np.array(times), speeds=np.array(speeds))


def test_the_motor_angle_is_the_integral_of_its_speed():
    profile = SpeedProfile(times=np.array([0.2, 0.3, 0.5]), speeds=np.array([0.0, 90.0, -30.0]))
    t = np.linspace(-0.1, 0.8, 90001)
    speed = profile.speed(t)
    summed = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(t))])
    np.testing.assert_allclose(profile.angle(t), summed - np.interp(0.0, t, summed), atol=1e-6)


def test_multibody_needs_none_of_the_mesh_packages():
    code = (
        "import sys\n"
        "for name in ('gmsh', 'skfem', 'meshio', 'pyvista', 'pydantic', 'matplotlib'): sys.modules[name] = None\n"
        "import mbd.output.simulate, mbd.integrators.methods\n"
        "loaded = sorted(n for n in sys.modules if n.startswith('fem.'))\n"
        "allowed = ('fem.storage', 'fem.numerics', 'fem.contact', 'fem.named_classes', 'fem.options')\n"
        "allowed += ('fem.casing.reduced.reduced_body', 'fem.casing.parts.casing_choices')\n"
        "bad = [n for n in loaded if not any(f'{n}.'.startswith(f'{a}.') for a in allowed)]\n"
        "bad = [n for n in bad if n not in ('fem.casing', 'fem.casing.reduced', 'fem.casing.parts')]\n"
        "assert not bad, bad\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_equilibrium_state_has_no_rates():
    machine = train(1)
    assert not equilibrium(assemble(machine, no_casing())).velocity.any()


def test_a_casing_may_leave_out_a_tilt_that_no_bearing_holds():
    """As the interfaces of a reduced casing do: the machine is the same to the last bit."""
    machine = train(1, torque=5.0)
    bearings = [dataclasses.replace(b, stiffness=(*b.stiffness[:3], 0.0, 0.0)) for b in machine.bearings]
    machine, body = dataclasses.replace(machine, bearings=tuple(bearings)), rigid_casing(machine)
    kept = [n for n, name in enumerate(body.row_names) if not name.endswith((":rx", ":rz"))]
    names = tuple(body.row_names[n] for n in kept)
    lean = dataclasses.replace(body, row_names=names, rows=body.rows[kept], row_shifts=body.row_shifts[kept])
    assert np.array_equal(assemble(machine, lean).stiffness, assemble(machine, body).stiffness)
    first = dataclasses.replace(bearings[0], stiffness=(*bearings[0].stiffness[:3], 1.0, 0.0))
    held = dataclasses.replace(machine, bearings=(first, *bearings[1:]))
    with pytest.raises(MachineError, match="has no row"):
        assemble(held, lean)
