"""Linearised view: closed formulas, the time step reproduces it in small free motion, energy shares, the command."""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import TRANSVERSE_ANGLE, mesh, no_casing, rigid_casing, train
from scipy import linalg

from benchmarks.hoist import EA, FALLS, LENGTH, LOAD, MASS, RADIUS
from fem.contact.evaluation.evaluator import LawEvaluator
from mbd.forces.rolling_bearing import hertz_bearing
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.bearings import BearingSpec
from mbd.parts.channels import DIRECTIONS, channel_names, journal_acceleration
from mbd.parts.load import StaticTorque
from mbd.parts.machine import Machine
from mbd.parts.part_checks import MachineError
from mbd.parts.rolling_elements import RollingElements
from mbd.parts.shafts import Disk, Section, ShaftSpec
from mbd.parts.speed_drive import MotorCoupling, SpeedProfile
from mbd.system.linearised import linear_modes, tangent, turned
from mbd.system.statics import equilibrium
from mbd.system.system import assemble
from pipelines.cli.main import main

STANDING = SpeedProfile(times=np.zeros(1), speeds=np.zeros(1))


def rotor(name, x, sense, mass, inertia):
    """A torsionally rigid disk without bending, so heavy that its bearing hardly counts."""
    return ShaftSpec(
        name=name, x=x, z=0.0, sense=sense, density=1.0, model="torsion",
        sections=(Section(y_start=-0.01, y_end=0.01, outer_diameter=0.1),),
        disks=(Disk(name="d", y=0.0, mass=mass, polar_inertia=inertia, diametral_inertia=mass),),
    )  # fmt: skip


def held(shaft):
    return BearingSpec(name=f"at_{shaft}", shaft=shaft, y=0.0, stiffness=(1e9,) * 5, damping_time=0.0)


INERTIA, COUPLING, TORQUE = (2e-3, 8e-2), 2e3, 50.0


def two_inertias(cycle, tau=0.0):
    spec = mesh("mesh_1", "a", "b", 0.0, teeth=(20, 55), module=0.002, helix=0.0, width=0.012, start=cycle, tau=tau)
    distance = (spec.base_radius_driving + spec.base_radius_driven) / math.cos(TRANSVERSE_ANGLE)
    return Machine(
        shafts=(rotor("a", 0.0, 1, 1e6, INERTIA[0]), rotor("b", distance, -1, 1e6, INERTIA[1])),
        bearings=(held("a"), held("b")),
        meshes=(spec,),
        couplings=(MotorCoupling(name="motor_1", shaft="a", y=0.0, stiffness=COUPLING),),
        profile=STANDING,
        load=StaticTorque(shaft="b", drums=(0.0,), torque=TORQUE),
        gravity=0.0,
    )


@pytest.mark.parametrize("cycle", [0.0, 0.35, 0.8, 7.5])
def test_two_geared_inertias_at_the_tangent_stiffness_of_their_load_and_place(cycle):
    """[J1 0; 0 J2] and [k r1^2 + k_c, -k r1 r2; -k r1 r2, k r2^2], k = dF/d delta at F = T2/r2 and the wound-up c."""
    machine = two_inertias(cycle)
    spec = machine.meshes[0]
    r1, r2 = spec.base_radius_driving, spec.base_radius_driven
    force, law = TORQUE / r2, LawEvaluator(spec.drive)
    place = cycle - force * r1 / COUPLING * spec.cycles_per_radian
    k = float(law.evaluate(place, law.approach_at(force, place)).stiffness[0])
    squares = linalg.eigh([[k * r1**2 + COUPLING, -k * r1 * r2], [-k * r1 * r2, k * r2**2]], np.diag(INERTIA))[0]
    found = linear_modes(assemble(machine, no_casing(), band=np.inf), up_to=1e5)
    assert found.mesh_forces[0] == pytest.approx(force, rel=1e-5)
    assert found.mesh_stiffness[0] == pytest.approx(k, rel=1e-5)
    for expected, part in zip(np.sqrt(squares) / (2 * np.pi), ("motor coupling", "mesh 1"), strict=True):
        i = int(np.argmin(abs(found.frequencies - expected)))
        assert found.frequencies[i] == pytest.approx(expected, rel=1e-4)
        assert found.dominant[i] == part


def test_turning_the_motor_is_starting_at_another_cycle():
    machine = turned(two_inertias(0.1), 0.7 / two_inertias(0.0).meshes[0].cycles_per_radian)
    moved, direct = (linear_modes(assemble(m, no_casing()), up_to=1e4) for m in (machine, two_inertias(0.8)))
    stiff = direct.frequencies > 10.0  # rounding sets the modes of 1e6 kg on their supports at 5 Hz
    before = linear_modes(assemble(two_inertias(0.1), no_casing()), up_to=1e4)
    np.testing.assert_allclose(moved.frequencies[stiff], direct.frequencies[stiff], rtol=1e-5)  # rounding: 1e-6
    assert (abs(before.frequencies[stiff] / direct.frequencies[stiff] - 1.0) > 1e-3).any()


def test_mesh_damping_gives_the_mesh_mode_tau_omega_over_two():
    tau = 2e-6
    found = linear_modes(assemble(two_inertias(0.2, tau), no_casing(), band=np.inf), up_to=1e5)
    i = found.dominant.index("mesh 1")
    expected = tau * np.pi * found.frequencies[i] * 2 * found.share("mesh_1")[i]  # tau times the mesh's strain share
    assert found.damping_ratios[i] == pytest.approx(expected, rel=1e-3)


HOLD = 5e7


def hoist():
    """A container on a drum that its motor holds."""
    return Machine(
        shafts=(rotor("drum", 0.0, 1, 20.0, 0.1),),
        bearings=(held("drum"),),
        meshes=(),
        couplings=(MotorCoupling(name="motor_1", shaft="drum", y=0.0, stiffness=HOLD),),
        profile=STANDING,
        load=dataclasses.replace(LOAD, rope_damping_ratio=0.02).load("drum", (0.0,)),
    )  # fmt: skip


@pytest.mark.parametrize("length", [5.0, 2.0, 0.5, 12.0])
def test_the_container_bounces_on_the_rope_that_is_left(length):
    """omega^2 = 1/(m (L/(n EA) + travel^2/k_c)), zeta = 2 % of the rope alone."""
    machine = turned(hoist(), (LENGTH - length) / (RADIUS / 2))
    found = linear_modes(assemble(machine, no_casing()), up_to=100.0)
    flexibility = length / (FALLS * EA) + (RADIUS / 2) ** 2 / HOLD
    assert found.frequencies[0] == pytest.approx(math.sqrt(1 / flexibility / MASS) / (2 * math.pi), rel=1e-5)
    assert found.dominant[0] == "rope bounce"
    assert found.share("rope")[0] > 0.99
    assert found.damping_ratios[0] == pytest.approx(0.02, rel=5e-3)


def test_more_rope_than_there_is_cannot_be_wound():
    with pytest.raises(MachineError, match=r"wound 5\.05 m of 5 m of rope"):
        turned(hoist(), 101.0)


def undamped_machine(stages, load):
    return train(
        stages, load=load, profile=STANDING, coupling_damping=0.0, bearing_tau=0.0, shaft_tau=0.0, torque=300.0,
        rope={"rope_damping_ratio": 0.0}, stage={"tau": 0.0},
    )  # fmt: skip


def undamped(stages, load):
    machine = undamped_machine(stages, load)
    journals = tuple(journal_acceleration(b.name, a) for b in machine.bearings for a in DIRECTIONS)
    names = channel_names(machine, ("sensor_1",)) + journals
    return assemble(machine, rigid_casing(machine, ratio=0.0), names)


def free_motion(system, modes, i, periods=4):
    """The channel that shows mode i best: its deviation from rest, the sampling interval, the expected amplitude.

    The velocity of the undamped tangent mode disturbs each mesh and rope by at most 0.5 % of its load.
    """
    state = equilibrium(system)
    small = tangent(system, state)
    shapes = linalg.eigh(small.stiffness, system.mass)[1]
    swing = dict(zip(modes.channel_names, modes.amplitudes[:, i], strict=True))
    limits = [1e-4]
    for m, force, k in zip(system.machine.meshes, modes.mesh_forces, modes.mesh_stiffness, strict=True):
        moved = swing[f"{m.name}:delta"] + abs(m.drive.face_coordinate).max() * swing[f"{m.name}:psi"]
        limits.append((0.005 * force / k / moved) ** 2)
    if "rope:force" in swing:
        limits.append((50.0 / swing["rope:force"]) ** 2)
    energy, step = min(limits), min(1 / (64 * modes.frequencies[i]), 1e-5)
    rate = min(1 / step, 200e3)
    start = dataclasses.replace(state, velocity=shapes[:, i] * math.sqrt(2 * energy))
    run, rest = (
        simulate(system, MotionSettings(end=end, output_rate=rate, step=step), start=begin)
        for end, begin in ((periods / modes.frequencies[i], start), (4 / rate, state))
    )
    largest = modes.amplitudes.max(axis=1)
    best = int(np.argmax(modes.amplitudes[:, i] / np.where(largest > 0, largest, np.inf)))
    return run.values[best] - rest.values[best, 0], 1 / rate, modes.amplitudes[best, i] * math.sqrt(energy)


def fitted_eigenvalue(signal, step, frequency):
    """lambda of x(t + 2T) = a x(t + T) + b x(t), T about a fifth of a period."""
    n = round(0.2 / frequency / step)
    now, then, later = signal[: -2 * n], signal[n:-n], signal[2 * n :]
    a, b = np.linalg.lstsq(np.column_stack([then, now]), later, rcond=None)[0]
    return np.log(np.roots([1.0, -a, -b]).astype(complex)[0]) / (n * step)


@pytest.mark.parametrize(
    ("stages", "load"),
    [(1, "torque"), (1, "rope"), pytest.param(2, "rope", marks=pytest.mark.slow)],  # [1-rope] with more shafts
)
def test_small_free_motion_has_the_linearised_frequencies_and_shapes(stages, load):
    system = undamped(stages, load)
    modes = linear_modes(system, up_to=9e3)
    assert abs(modes.damping_ratios).max() < 1e-9
    chosen = {modes.dominant.index(word) for word in modes.dominant}  # the first of every kind
    chosen |= {int(modes.share(name).argmax()) for name in modes.mesh_names}
    assert len(chosen) >= 6
    for i in sorted(chosen):
        signal, step, amplitude = free_motion(system, modes, i)
        found = abs(fitted_eigenvalue(signal, step, modes.frequencies[i]).imag) / (2 * np.pi)
        assert found == pytest.approx(modes.frequencies[i], rel=5e-3), modes.dominant[i]
        assert abs(signal).max() == pytest.approx(amplitude, rel=0.02), modes.dominant[i]


def test_small_free_motion_in_rolling_bearings_has_the_linearised_frequencies():
    """At rest the cages stand; the bearings' stiffness is the tangent of their Hertz contacts under the load."""
    machine = dataclasses.replace(undamped_machine(1, "torque"), gravity=9.80665)
    bearings = tuple(
        hertz_bearing(b.name, b.shaft, b.y, RollingElements(designation="6206"), 0.0) for b in machine.bearings
    )
    machine = dataclasses.replace(machine, bearings=bearings)
    journals = tuple(journal_acceleration(b.name, a) for b in bearings for a in DIRECTIONS)
    system = assemble(machine, rigid_casing(machine, ratio=0.0), channel_names(machine, ("sensor_1",)) + journals)
    modes = linear_modes(system, up_to=5e3)
    chosen = {modes.dominant.index(word) for word in modes.dominant}
    chosen |= set(np.argsort(modes.share("bearing"))[-3:].tolist())
    assert modes.share("bearing").max() > 0.3
    for i in sorted(chosen):
        signal, step, _ = free_motion(system, modes, i)
        found = abs(fitted_eigenvalue(signal, step, modes.frequencies[i]).imag) / (2 * np.pi)
        print(f"{modes.dominant[i]} {modes.frequencies[i]:.2f} Hz: {found / modes.frequencies[i] - 1:+.1e}")
        assert found == pytest.approx(modes.frequencies[i], rel=5e-3), modes.dominant[i]


def test_a_damped_bounce_decays_at_the_linearised_rate():
    machine = train(1, load="rope", profile=STANDING, rope={"rope_damping_ratio": 0.05})
    system = assemble(machine, rigid_casing(machine))
    modes, state = linear_modes(system), equilibrium(system)
    i = modes.dominant.index("rope bounce")
    velocity = np.zeros_like(state.velocity)
    velocity[system.layout.names.index("container:lift")] = 1e-3
    start = dataclasses.replace(state, velocity=velocity)
    run = simulate(system, MotionSettings(end=0.6, output_rate=1000.0, step=1e-5), start=start)
    lift = run.channel("container:lift")[50:] - state.displacement[system.layout.names.index("container:lift")]
    value = fitted_eigenvalue(lift, 1e-3, modes.frequencies[i])
    assert abs(value) / (2 * np.pi) == pytest.approx(modes.frequencies[i], rel=5e-3)
    assert -value.real / abs(value) == pytest.approx(modes.damping_ratios[i], rel=0.02)


@pytest.mark.parametrize(("stages", "load"), [(1, "torque"), (3, "rope")])
@pytest.mark.parametrize("model", ["timoshenko", "torsion"])
def test_the_energy_of_the_parts_is_that_of_the_whole(stages, load, model):
    machine = train(stages, load=load, model=model)
    modes = linear_modes(assemble(machine, rigid_casing(machine, extra=5)))
    np.testing.assert_allclose(modes.shares.sum(axis=1), 1.0, rtol=1e-8)
    assert modes.strain_shares.min() > -1e-12
    assert modes.kinetic_shares.min() >= 0.0
    assert (np.diff(modes.frequencies) >= 0).all()
    assert (modes.damping_ratios > 0).all()
    assert modes.frequencies[-1] <= 10e3
    kinds = ["shaft", "bearing", "casing", "drive", "mesh"] + ["rope"] * (load == "rope")
    np.testing.assert_allclose(sum(modes.share(kind) for kind in kinds), 1.0, rtol=1e-8)
    with pytest.raises(KeyError, match="mesh_9"):
        modes.share("mesh_9")


def test_undamped_modes_hold_as_much_strain_as_kinetic_energy():
    modes = linear_modes(undamped(1, "torque"))
    np.testing.assert_allclose(modes.strain_shares.sum(axis=1), 0.5, rtol=1e-6)


def test_a_stored_record_is_the_same(tmp_path):
    machine = train(1)
    modes = linear_modes(assemble(machine, no_casing()))
    modes.save(tmp_path / "modes.h5")
    assert type(modes).load(tmp_path / "modes.h5").digest() == modes.digest()


def test_without_load_there_is_no_tangent():
    machine = train(2, torque=0.0)
    with pytest.raises(MachineError, match="stage 1 carries no force"):
        linear_modes(assemble(machine, no_casing()))


@pytest.mark.parametrize("up_to", [0.0, -1.0, math.nan])
def test_a_band_that_is_none_is_refused(up_to):
    with pytest.raises(MachineError, match="up_to"):
        linear_modes(assemble(train(1), no_casing()), up_to=up_to)


def table_of(text):
    """Cells of the rows of the first table, split at two blanks."""
    lines = text.splitlines()
    rule = next(i for i, line in enumerate(lines) if line.startswith("----"))
    return [line.split(maxsplit=8) for line in lines[rule + 1 :] if line.strip()[:1].isdigit()]


def test_the_command_prints_the_modes(capsys):
    assert main(["modes", "minimal", "--quiet"]) == 0
    out = capsys.readouterr().out
    rows = table_of(out)
    assert len(rows) > 10
    for row in rows:
        assert sum(float(cell) for cell in row[3:8]) == pytest.approx(100.0, abs=0.3)
    assert {"casing", "mesh 1", "motor coupling"} <= {row[8] for row in rows}
    assert "mesh 1: force 1061 N, tangent stiffness" in out
    assert main(["modes", "minimal", "--quiet", "--up-to", "1000", "--cycle", "0.4"]) == 0
    fewer = capsys.readouterr().out
    assert "stage 1 at mesh cycle 0.4" in fewer
    assert len(table_of(fewer)) == sum(float(row[1]) <= 1000 for row in rows)
    assert main(["modes", "minimal", "--quiet", "--up-to", "1"]) == 0
    assert "raise --up-to" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--up-to", "0"], "not a number above 0"),
        (["--up-to", "high"], "not a finite number"),
        (["--cycle", "nan"], "not a finite number"),
        (["--set", "stages.1.module_mm=0"], "stages.1.module_mm = 0"),
        (["--set", "load.container_kg=0"], "carries no force at the equilibrium"),
    ],
)
def test_bad_input_gives_exit_code_2(capsys, arguments, words):
    try:
        code = main(["modes", "minimal", "--quiet", *arguments])
    except SystemExit as end:
        code = end.code
    captured = capsys.readouterr()
    assert code == 2
    assert words in captured.err
    assert captured.out == ""
