"""Misaligned couplings: no lines from an isotropic one, twice the speed from axes that turn, Cardan's error."""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import no_casing
from rotors import jeffcott, line

from mbd.excitations.misaligned_coupling import MisalignedCoupling
from mbd.forces.torque import Torque
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.bearings import rigid_bearing
from mbd.parts.couplings import ShaftCoupling
from mbd.parts.load import StaticTorque
from mbd.parts.part_checks import MachineError
from mbd.parts.shafts import Section
from mbd.system.system import assemble
from pipelines.io.errors import SceneError
from pipelines.scene.load_scene import load_scene

SPEED = 60.0  # rad/s, far below all modes
OFFSET = 2e-4  # m
FORCES = tuple(f"bearing_{i}:f{axis}" for i in (1, 2) for axis in "xz")


def coupling(**changes):
    fields = {
        "name": "coupling_1", "shafts": ("shaft_1", "shaft_2"), "y": (0.5, 0.6), "torsional_stiffness": 1e5,
        "radial_stiffness": 2e6, "tilt_stiffness": 0.0, "damping_time": 2e-4, "radial_stiffness_across": 2e6,
        "tilt_stiffness_across": 0.0,
    }  # fmt: skip
    return MisalignedCoupling(**fields | changes)


def pair(*couplings, sense=1, forces=(), torque=0.0):
    """Two stiff shafts on one axis, each in two rigid bearings, motors at the first."""
    one = jeffcott(speed=SPEED, sense=sense)
    shaft = dataclasses.replace(
        one.shafts[0], disks=(), density=7850.0, damping_time=2e-4,
        sections=(Section(y_start=0.0, y_end=0.5, outer_diameter=0.06),),
    )  # fmt: skip
    other = dataclasses.replace(shaft, name="shaft_2", sections=(Section(y_start=0.6, y_end=1.1, outer_diameter=0.06),))
    bearings = (
        *(rigid_bearing(f"bearing_{i + 1}", "shaft_1", y) for i, y in enumerate((0.1, 0.5))),
        *(rigid_bearing(f"bearing_{i + 3}", "shaft_2", y) for i, y in enumerate((0.6, 1.0))),
    )
    motors = tuple(dataclasses.replace(motor, damping=50.0) for motor in one.couplings)
    return dataclasses.replace(
        one, shafts=(shaft, other), bearings=bearings, shaft_couplings=couplings, forces=forces, couplings=motors,
        load=StaticTorque(shaft="shaft_2", drums=(1.1,), torque=torque),
    )  # fmt: skip


def lines(machine, orders, channels=FORCES):
    """Complex amplitude of every order of the speed in every channel, and their largest deviation from the mean."""
    run = simulate(assemble(machine, no_casing(), channels), MotionSettings(end=0.6, output_rate=4e3, step=2.5e-5))
    late = run.time > 0.6 - 2 * 2 * math.pi / SPEED
    time = run.time[late]
    found = {n: {order: line(time, run.channel(n)[late], order * SPEED) for order in orders} for n in channels}
    swing = {n: float(np.ptp(run.channel(n)[late])) / 2 for n in channels}
    return found, swing, run


def carried(found, axis, order):
    """Both bearings of shaft 1 together."""
    return found[f"bearing_1:f{axis}"][order] + found[f"bearing_2:f{axis}"][order]


def test_a_fixed_misalignment_of_an_isotropic_coupling_makes_no_lines():
    _, swing, run = lines(pair(coupling(offset=(OFFSET, 0.0), tilt=(0.01, 0.0), tilt_stiffness=100.0,
                                            tilt_stiffness_across=100.0)), (1, 2))  # fmt: skip
    static = 2e6 * OFFSET
    assert abs(sum(run.channel(f"bearing_{i}:fx")[-1] for i in (1, 2))) == pytest.approx(static, rel=0.02)
    assert max(swing.values()) < 1e-4 * static


@pytest.mark.parametrize("sense", [1, -1])
def test_stiffness_axes_that_turn_make_twice_the_speed(sense):
    """Of the offset the force (k_1 - k_2)/2 turns at 2 Omega; nothing at Omega."""
    found, _, run = lines(
        pair(coupling(radial_stiffness=3e6, radial_stiffness_across=1e6, offset=(OFFSET, 0.0)), sense=sense), (1, 2)
    )
    turning = (3e6 - 1e6) / 2 * OFFSET
    assert abs(carried(found, "x", 2)) == pytest.approx(turning, rel=0.02)
    assert carried(found, "z", 2) / carried(found, "x", 2) == pytest.approx(1j * sense, abs=0.02)
    assert abs(carried(found, "x", 1)) < 5e-3 * turning
    assert abs(run.energy("coupling_1, turning", "residual")) < 1e-3 * run.energy("shaft_1", "dissipated") + 1e-7


def test_the_axes_start_at_their_angle():
    """A quarter turn of the axes changes the sign of what turns."""
    options = {"radial_stiffness": 3e6, "radial_stiffness_across": 1e6, "offset": (OFFSET, 0.0)}
    straight, across = (carried(lines(pair(coupling(**options, **a)), (2,))[0], "x", 2) for a in (
        {}, {"angle": math.pi / 2}))  # fmt: skip
    assert across / straight == pytest.approx(-1.0, abs=1e-3)


@pytest.mark.parametrize("alpha", [0.03, 0.07])
def test_a_universal_joint_turns_the_second_shaft_by_cardans_error(alpha):
    """tan phi_2 = cos alpha tan phi_1 at low speed: twice per turn, tan^2(alpha/2) in amplitude."""
    channels = ("shaft_1:angle", "shaft_2:angle")
    _, _, run = lines(pair(coupling(tilt=(alpha, 0.0), joint=True)), (2,), channels)
    late = run.time > 0.3
    first, second = (run.channel(name)[late] for name in channels)
    # the pin along e_1 starts along x, the axis of the tilt
    exact = np.arctan2(np.cos(alpha) * np.sin(first), np.cos(first))
    off = np.angle(np.exp(1j * (second - exact)))
    size = math.tan(alpha / 2) ** 2
    assert abs(off - off.mean()).max() < 0.05 * size
    assert np.ptp(second - first) / 2 == pytest.approx(size, rel=0.02)


def test_a_torque_through_a_tilted_joint_bends_both_shafts_at_twice_the_speed():
    """Moment T alpha/2 on the first shaft, which its two bearings, 0.4 m apart, carry as a pair of forces."""
    torque, alpha = 200.0, 0.03
    found, _, _ = lines(pair(coupling(tilt=(alpha, 0.0), joint=True), torque=torque), (1, 2))
    for axis in "xz":
        pair_of_forces = abs(found[f"bearing_1:f{axis}"][2] - found[f"bearing_2:f{axis}"][2]) / 2
        assert pair_of_forces == pytest.approx(torque * alpha / 2 / 0.4, rel=0.03)
        assert abs(found[f"bearing_1:f{axis}"][1]) < 5e-3 * pair_of_forces


def test_without_misalignment_it_is_the_coupling_of_constant_springs():
    """The same frequency lines, forces and angles when a torque comes and goes."""
    push = Torque(name="push", shaft="shaft_2", y=1.1, times=np.array([0.0, 0.01, 0.02]), torques=np.array([0, 9.0, 0]))
    plain = ShaftCoupling(
        name="coupling_1", shafts=("shaft_1", "shaft_2"), y=(0.5, 0.6), torsional_stiffness=1e5, radial_stiffness=2e6,
        damping_time=2e-4,
    )  # fmt: skip
    runs = [
        simulate(
            assemble(pair(one, forces=(push,)), no_casing(), ("shaft_2:speed", "motor_1:torque")),
            MotionSettings(end=0.05, output_rate=4e3, step=2.5e-5),
        )
        for one in (plain, coupling())
    ]
    for name in ("shaft_2:speed", "motor_1:torque"):
        a, b = (run.channel(name) for run in runs)
        assert abs(a - b).max() < 1e-4 * np.ptp(a)


def test_it_turns_with_the_shafts_when_a_run_starts_elsewhere():
    start = assemble(pair(coupling(angle=0.2)).turned(0.5), no_casing(), ()).element("coupling_1, turning").values[0]
    assert start == pytest.approx(0.2 - 0.5)


def test_a_tilt_beyond_small_angles_is_refused():
    with pytest.raises(MachineError, match="-70 to 70 mrad"):
        coupling(tilt=(0.2, 0.0))


TABLE = {"shafts": [1, 2], "positions_mm": [100.0, 100.0], "torsional_stiffness_N_m_per_rad": 1e4}


def tables(**changes):
    scene = load_scene("minimal", {"couplings": [TABLE | changes], "stages.1.pinion_shaft": 1,
                                   "stages.1.wheel_shaft": 2}).scene  # fmt: skip
    return [table.spec(number) for number, table in enumerate(scene.couplings, 1)]


def test_couplings_of_a_scene_in_si():
    (plain,) = tables(radial_stiffness_N_per_um=2.0)
    assert type(plain) is ShaftCoupling
    (made,) = tables(
        radial_stiffness_N_per_um=3.0, radial_stiffness_across_N_per_um=1.0, tilt_stiffness_N_m_per_rad=50.0,
        offset_um=[100.0, -50.0], tilt_mrad=[2.0, 1.0], stiff_axis_deg=90.0, universal_joint=True,
    )  # fmt: skip
    assert (made.radial_stiffness, made.radial_stiffness_across) == (3e6, 1e6)
    assert (made.tilt_stiffness, made.across[1]) == (50.0, 50.0)  # left out: the same across
    assert (made.offset, made.tilt) == (pytest.approx((1e-4, -5e-5)), pytest.approx((2e-3, 1e-3)))
    assert (made.angle, made.joint) == (pytest.approx(math.pi / 2), True)


def test_a_joint_that_is_tilted_too_far_is_refused():
    with pytest.raises(SceneError, match="tilt_mrad"):
        tables(tilt_mrad=[200.0, 0.0], universal_joint=True)
