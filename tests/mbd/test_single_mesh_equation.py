"""One mesh between rigid bearings: m x'' + c x' + k (x - delta_0) = m [T1/(m1 r_b1) + T2/(m2 r_b2)].

m_i = J_i/r_bi^2 and m = m1 m2/(m1 + m2). The left side is the law's force F(c, x) with its damping tau dF/dx x', at the
mesh cycle c of the turning wheels; T2 is constant, or that of a container on an undamped rope of fixed stiffness.
The equation is integrated by SciPy, with the machine's data and nothing of `mbd`.
"""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import TRANSVERSE_ANGLE, mesh, no_casing
from scipy.integrate import solve_ivp

from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.kernel import evaluate
from mbd.forces.rope import Rope, RopeLoad
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.bearings import rigid_bearing
from mbd.parts.load import StaticTorque
from mbd.parts.machine import STANDARD_GRAVITY, Machine
from mbd.parts.shafts import Disk, Section, ShaftSpec
from mbd.parts.speed_drive import MotorCoupling, SpeedProfile
from mbd.system.statics import equilibrium
from mbd.system.system import assemble

INERTIA, HALF, SOFT, SPEED, RATE = (2e-3, 8e-2), 3e-3, 0.5, 94.0, 40e3
ROPE = RopeLoad(
    container_mass=100.0, drum_radius=0.1, drum_mass=1.0, drum_inertia=1.0, rope_falls=4, rope_modulus=2.8e10,
    rope_length=4.0, rope_damping_ratio=0.0,
)  # fmt: skip
TORQUE, WEIGHT = ROPE.torque, ROPE.container_mass * STANDARD_GRAVITY
ROPE_STIFFNESS = ROPE.rope_falls * ROPE.axial_stiffness / ROPE.rope_length


def wheel(name, x, sense, inertia):
    """A gear that only turns: its shaft is short and so heavy that it stays where it is; ``inertia`` in all."""
    of_shaft = 7850.0 * math.pi * 0.1**4 / 32 * 2 * HALF
    return ShaftSpec(
        name=name, x=x, z=0.0, sense=sense, density=7850.0, model="torsion",
        sections=(Section(y_start=-HALF, y_end=HALF, outer_diameter=0.1),),
        disks=(Disk(name="gear", y=0.0, mass=1e6, polar_inertia=inertia - of_shaft, diametral_inertia=1e6),),
    )  # fmt: skip


def single_mesh(load, coupling=SOFT):
    """With a motor so soft that its torque is constant; pitch deviations give delta_0; no Hertz flattening."""
    spec = mesh("mesh_1", "a", "b", 0.0, teeth=(20, 55), module=0.002, helix=0.0, width=0.012, start=0.3, hertz=False)
    deviations = 3e-6 * np.sin(2 * np.pi * np.arange(55) / 55) + 1e-6 * np.cos(np.arange(55) * 2.4)
    spec = dataclasses.replace(spec, drive_clearance_wheel=deviations)
    distance = (spec.base_radius_driving + spec.base_radius_driven) / math.cos(TRANSVERSE_ANGLE)
    hanging = Rope(shaft="b", drums=(0.0,), hoist=ROPE, follow_length=False)
    return Machine(
        shafts=(wheel("a", 0.0, 1, INERTIA[0]), wheel("b", distance, -1, INERTIA[1])),
        bearings=tuple(rigid_bearing(f"bearing_{s}{y}", s, y, "ground") for s in "ab" for y in (-HALF, HALF)),
        meshes=(spec,),
        couplings=(MotorCoupling(name="motor_1", shaft="a", y=0.0, stiffness=coupling),),
        profile=SpeedProfile(times=np.zeros(1), speeds=np.array([SPEED])),
        load=StaticTorque(shaft="b", drums=(0.0,), torque=TORQUE) if load == "torque" else hanging,
        gravity=STANDARD_GRAVITY if load == "rope" else 0.0,
    )


def integrated(machine, torque, times, x_start):
    """x of the equation at ``times``, from rest in the rolling frame; y = (x, x', phi_1, phi_1', lift, lift')."""
    spec = machine.meshes[0]
    r1, r2 = spec.base_radius_driving, spec.base_radius_driven
    m1, m2 = INERTIA[0] / r1**2, INERTIA[1] / r2**2
    m, tables, teeth = m1 * m2 / (m1 + m2), LawEvaluator(spec.drive).packed, spec.terms[0]
    wound = torque / SOFT  # of the motor coupling at the start
    winch, spring = ROPE.drum_radius / 2, ROPE_STIFFNESS
    weight, hangs = WEIGHT, isinstance(machine.load, Rope)

    def rate(t, y):
        x, dx, phi, dphi, lift, dlift = y
        cycle = spec.cycle_at_start + (SPEED * t - wound + phi) * spec.cycles_per_radian
        f, _, _, slope, _, _ = evaluate(tables, cycle, x, 0.0, *teeth)
        push = max(0.0, f + spec.damping_time * slope * dx) if f > 0 else 0.0
        pull = weight + spring * (winch * (r1 * phi - (x - x_start)) / r2 - lift) if hangs else 0.0
        t1, t2 = torque - SOFT * phi, winch * pull if hangs else TORQUE
        ddx = t1 / (m1 * r1) + t2 / (m2 * r2) - push / m
        return [dx, ddx, dphi, (t1 - r1 * push) / INERTIA[0], dlift, (pull - weight) / ROPE.container_mass]

    start = [x_start, 0.0, 0.0, 0.0, 0.0, 0.0]
    return solve_ivp(rate, (0.0, times[-1]), start, t_eval=times, rtol=1e-9, atol=1e-14, max_step=1e-4).y[0]


@pytest.mark.parametrize("load", ["torque", "rope"])
def test_the_machine_moves_as_the_equation_says(load):
    machine = single_mesh(load)
    system = assemble(machine, no_casing(), ("mesh_1:delta", "motor_1:torque"), band=np.inf)
    run = simulate(system, MotionSettings(end=0.04, output_rate=RATE, step=1 / RATE / 8))
    approach, n = run.channel("mesh_1:delta"), 100  # the output filter rings at both ends
    torque = equilibrium(system).motor_torque
    np.testing.assert_allclose(run.channel("motor_1:torque"), torque, rtol=1e-3)
    exact = integrated(machine, torque, run.time, float(equilibrium_approach(system)))
    assert np.ptp(approach) > 0.2 * approach.mean()
    error = (approach - exact)[n:-n]
    print(f"{load}: {np.sqrt((error**2).mean()) / exact.std():.2e} of the standard deviation")
    assert np.sqrt((error**2).mean()) < 1e-3 * exact.std()


def equilibrium_approach(system):
    return system.rows[system.row_names.index("mesh_1:drive:delta")] @ equilibrium(system).displacement


def test_the_static_load_is_that_of_the_right_side():
    """At rest F = m [T1/(m1 r1) + T2/(m2 r2)] = T1/r1. The form (M2 - M1)/r1, met in print, gives another load:
    none with both torques referred to one shaft, (i - 1) times it with each on its own; and with
    M2 = (m_c g + k_c x_c) R the weight counts twice, since the rope's stretch x_c at rest carries it."""
    machine = single_mesh("rope", coupling=2e4)
    spec, state = machine.meshes[0], equilibrium(assemble(machine, no_casing()))
    r1, r2 = spec.base_radius_driving, spec.base_radius_driven
    m1, m2 = INERTIA[0] / r1**2, INERTIA[1] / r2**2
    t1, t2, force = state.motor_torque, TORQUE, state.mesh_force[0]
    assert force == pytest.approx(m1 * m2 / (m1 + m2) * (t1 / (m1 * r1) + t2 / (m2 * r2)), rel=1e-6)
    assert (t2 * r1 / r2 - t1) / r1 == pytest.approx(0.0, abs=1e-6 * force)
    assert (t2 - t1) / r1 == pytest.approx((55 / 20 - 1) * force, rel=1e-6)
    stretch = WEIGHT / ROPE_STIFFNESS
    hanging = (WEIGHT + ROPE_STIFFNESS * stretch) * ROPE.drum_radius / 2
    assert hanging == pytest.approx(2 * t2, rel=1e-12)
