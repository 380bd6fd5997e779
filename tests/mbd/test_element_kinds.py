"""What every element kind must meet, whatever it is: its forces, slopes and works belong to one another."""

import dataclasses

import numpy as np
import pytest
from mbd_rigs import hoisting, no_casing, rigid_casing, swinging, train

from mbd.elements.element import BY_ANGLE, ENERGY, WIDTH, Element, Signal, rule
from mbd.elements.mode_words import ModeWords
from mbd.elements.newton import forces_at
from mbd.elements.table import instant, slope_matrix
from mbd.excitations.base_acceleration import BaseAcceleration
from mbd.excitations.bent_shaft import BentShaft
from mbd.excitations.cage_slip import CageSlip
from mbd.excitations.faulty_bearing import with_faults
from mbd.excitations.misaligned_coupling import MisalignedCoupling
from mbd.excitations.outside_force import ForceSweep, ShaftForce
from mbd.excitations.ripple import TorqueRipple
from mbd.excitations.spall import Spall
from mbd.excitations.unbalance import Unbalance
from mbd.forces.rolling_bearing import hertz_bearing
from mbd.forces.torque import Torque
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.load import OutsideForce
from mbd.parts.losses import Brake, Coulomb, Efficiency
from mbd.parts.rolling_elements import RollingElements
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.linearised import linear_modes
from mbd.system.statics import equilibrium
from mbd.system.system import assemble

CUBIC = 3e13  # N/m3


@rule(__file__)
def snubber_rule(values, motion, answer):
    """A kind of this file alone: F = k u^3 + c u'."""
    u, v = motion.u[0], motion.v[0]
    answer.elastic[0], answer.stiffness[0, 0] = values[0] * u**3, 3.0 * values[0] * u**2
    answer.lost[0], answer.lost_by_v[0, 0] = values[1] * v, values[1]
    answer.log[ENERGY] = 0.25 * values[0] * u**4


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Snubber(OutsideForce):
    def elements(self, lay):
        yield Element(
            kind="snubber", name=self.name, part=self.name, words=ModeWords("snubber", "snubbers"),
            rule=snubber_rule, values=(CUBIC, 50.0),
            rows=lay.axis_row(self.shaft, self.y, 2)[None], row_names=("uz",), scale=(10.0,),
            signals=(Signal(f"{self.name}:force", "N", force=(1.0,)),),
        )  # fmt: skip


def in_rolling_bearings(*names):
    machine = hoisting()
    bearings = tuple(
        hertz_bearing(b.name, b.shaft, b.y, RollingElements(designation=names[i % 2]), 1e-5)
        for i, b in enumerate(machine.bearings)
    )
    return dataclasses.replace(machine, bearings=bearings)


def spalled():
    machine = in_rolling_bearings("6208", "NU208")
    angles = np.linspace(0.0, 2 * np.pi, 9, endpoint=False)  # some of them where elements are pressed
    pits = [Spall(on=on, width=2e-3, depth=1e-6, angle=a) for on in ("outer-ring", "inner-ring") for a in angles]
    slip = CageSlip(share=0.02, seed=(1,))
    return dataclasses.replace(machine, bearings=tuple(with_faults(b, pits, slip) for b in machine.bearings))


def lossy(losses):
    return dataclasses.replace(hoisting(), losses=losses, brake=Brake(shaft="shaft_1", y=-0.2, torque=40.0))


def misaligned(joint):
    """The first shaft in two, motors at the outer one, a coupling between them."""
    machine = hoisting()
    outer = dataclasses.replace(machine.shafts[0], name="shaft_0", disks=())
    bearings = tuple(
        dataclasses.replace(bearing, name=f"bearing_{9 + i}", shaft="shaft_0")
        for i, bearing in enumerate(machine.bearings[:2])
    )
    coupling = MisalignedCoupling(
        name="coupling_1", shafts=("shaft_0", "shaft_1"), y=(0.2, 0.2), torsional_stiffness=3e4, radial_stiffness=1e7,
        axial_stiffness=2e6, tilt_stiffness=2e3, damping_time=1e-5, offset=(1e-4, -5e-5), tilt=(0.02, 0.05),
        radial_stiffness_across=4e6, tilt_stiffness_across=5e2, angle=0.4, joint=joint,
    )  # fmt: skip
    motors = tuple(dataclasses.replace(motor, shaft="shaft_0") for motor in machine.couplings)
    return dataclasses.replace(
        machine, shafts=(outer, *machine.shafts), bearings=(*bearings, *machine.bearings), couplings=motors,
        shaft_couplings=(coupling,),
    )  # fmt: skip


SNUBBER = Snubber(name="snubber", shaft="shaft_1", y=0.0)
PUSH = Torque(name="push", shaft="shaft_2", y=0.0, times=np.array([0.0, 0.02, 0.03]), torques=np.array([0.0, 5.0, 3.0]))
SWEEP = ForceSweep(start=0.0, end=0.1, first=50.0, last=500.0, ramp=0.02, amplitude=20.0)
EXCITED = (
    Unbalance(name="unbalance", shaft="shaft_2", y=0.0, size=1e-4, angle=0.4),
    TorqueRipple(name="ripple", shaft="shaft_2", y=0.1, amplitude=3.0, order=6.0, angle=0.3),
    BentShaft(name="bent", shaft="shaft_1", y=0.0, bow=3e-5, straight=(-0.1, 0.1), angle=1.0),
    BaseAcceleration(name="ground", axis="z", acceleration=SWEEP),
    ShaftForce(name="sweep", shaft="shaft_1", y=0.0, axis="z", force=SWEEP),
)
MACHINES = {
    "rope": hoisting,
    "ground": lambda: hoisting(ground_level=-0.0002, ground_stiffness=1e6),
    "pendulum": swinging,
    "balls": lambda: in_rolling_bearings("6208", "6208"),
    "rollers": lambda: in_rolling_bearings("NU208", "6208"),
    "spalls": spalled,
    "efficiency": lambda: lossy(Efficiency(mesh_efficiency=0.95)),
    "coulomb": lambda: lossy(Coulomb(tooth_friction=0.06, bearing_friction=0.002)),
    "gyroscopic": lambda: dataclasses.replace(hoisting(), gyroscopic=True),
    "from outside": lambda: dataclasses.replace(hoisting(), forces=(SNUBBER, PUSH)),
    "coupled": lambda: misaligned(False),
    "joint": lambda: misaligned(True),
    "excited": lambda: dataclasses.replace(hoisting(), forces=EXCITED),
}


def answer(system, u, v, clock):
    """Residual forces, slope matrices by u and v, and what the elements answered."""
    m = len(v)
    now, force, by_u, by_v = instant(system.table), np.zeros(m), np.zeros((m, WIDTH)), np.zeros((m, WIDTH))
    forces_at(system.table, clock, u, v, u[:0], by_u[:0], force, by_u, by_v, now)
    return force, slope_matrix(by_u, system.table), slope_matrix(by_v, system.table), now


@pytest.mark.parametrize("name", MACHINES)
def test_forces_slopes_and_potentials_belong_together(name):
    """At the equilibrium, motors at speed: slopes are those of the forces, elastic forces and dU/d angle those of U."""
    system = assemble(MACHINES[name](), no_casing(), ())
    state, m, angle, speed = equilibrium(system), len(system.rows), 0.03, 2.0
    u, v = system.all_rows @ state.displacement, np.zeros(m)
    _, by_u, by_v, now = answer(system, u, v, (angle, speed, 0.01))
    owner = np.repeat(np.arange(len(system.elements)), np.diff(system.table.row))
    assert abs(now.log[:, ENERGY]).max() > 0.0
    size, h = system.table.scale, 1e-8
    for r in range(m):
        up, down = u.copy(), u.copy()
        up[r], down[r] = u[r] + h, u[r] - h
        plus, minus = (answer(system, x, v, (angle, speed, 0.01)) for x in (up, down))
        change = plus[0] - minus[0]
        np.testing.assert_allclose(change, 2 * h * by_u[:, r], atol=5e-3 * abs(change).max() + 1e-9 * size[r])
        work = (plus[3].log[owner[r], ENERGY] - minus[3].log[owner[r], ENERGY]) / (2 * h)
        assert work == pytest.approx(now.elastic[r], rel=1e-4, abs=1e-6 * size[r])
        rate = v.copy()
        rate[r] = 1e-6
        moved = answer(system, u, rate, (angle, speed, 0.01))[0] - answer(system, u, -rate, (angle, speed, 0.01))[0]
        np.testing.assert_allclose(moved, 2e-6 * by_v[:, r], rtol=1e-4, atol=1e-9 * size[r])
    turned = [answer(system, u, v, (angle + d, speed, 0.01))[3].log[:, ENERGY] for d in (1e-5, -1e-5)]
    for i, element in enumerate(system.elements):
        if not element.audited and not element.rolls:
            assert now.log[i, BY_ANGLE] == pytest.approx((turned[0][i] - turned[1][i]) / 2e-5, rel=1e-3, abs=1e-9)


def test_a_kind_that_nothing_else_knows_runs_and_its_energy_is_balanced():
    profile = SpeedProfile(times=np.array([0.01, 0.02]), speeds=np.array([0.0, 94.0]))
    machine = dataclasses.replace(hoisting(), forces=(SNUBBER,), profile=profile)
    system = assemble(machine, rigid_casing(machine))
    run = simulate(
        assemble(machine, rigid_casing(machine), ("snubber:force",)),
        MotionSettings(end=0.06, output_rate=5e3, step=1e-5),
    )
    assert run.channel("snubber:force").std() > 1.0
    assert run.energy("snubber", "dissipated") > 0.0
    assert abs(run.energy("snubber", "residual")) < 1e-3 * run.energy("snubber", "scale")
    assert abs(run.energy("total", "residual")) < 1e-6 * run.energy("total", "scale")
    assert "snubber" in linear_modes(system).part_names


@pytest.mark.parametrize("method", ["exponential", "generalised-alpha"])
def test_a_torque_over_time_reaches_the_motors_and_its_work_is_booked(method):
    """A slow torque on the output shaft takes its share off the motors; what it works is what it is said to receive."""
    standing = SpeedProfile(times=np.zeros(1), speeds=np.zeros(1))
    push = Torque(name="push", shaft="shaft_2", y=0.0, times=np.array([0.0, 0.2]), torques=np.array([0.0, 8.0]))
    machine = dataclasses.replace(train(1, profile=standing, coupling_damping=5.0), forces=(push,))
    channels = ("motor_1:torque", "motor_2:torque")
    run = simulate(
        assemble(machine, no_casing(), channels),
        MotionSettings(end=0.3, output_rate=2e3, step=2e-5, integrator=method),
    )
    torque = run.channel(channels[0]) + run.channel(channels[1])
    taken = 8.0 * machine.ratios()["shaft_2"]
    late = run.time > 0.25
    assert torque[0] - torque[late].mean() == pytest.approx(taken, rel=1e-3)
    assert run.energy("push", "stored") == 0.0
    assert run.energy("push", "dissipated") < 0.0  # it gives work
    assert abs(run.energy("total", "residual")) < 1e-5 * run.energy("total", "scale")


def test_a_torque_works_on_the_rolling_train():
    """Lifting at constant speed: its work is torque times angle."""
    push = Torque(name="push", shaft="shaft_2", y=0.0, times=np.zeros(1), torques=np.array([4.0]))
    profile = SpeedProfile(times=np.array([0.01, 0.04]), speeds=np.array([0.0, 94.0]))
    machine = dataclasses.replace(train(1, profile=profile), forces=(push,))
    run = simulate(
        assemble(machine, no_casing(), ("shaft_2:angle",)), MotionSettings(end=0.05, output_rate=1e5, step=1e-5)
    )
    turned = run.channel("shaft_2:angle")[-1] - run.channel("shaft_2:angle")[0]
    assert run.energy("push", "dissipated") == pytest.approx(-4.0 * turned, rel=1e-3)
    assert abs(run.energy("total", "residual")) < 1e-6 * run.energy("total", "scale")
