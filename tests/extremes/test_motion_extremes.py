"""Extreme machines: finite with a closed energy balance, or refused with a reason."""

import dataclasses
import tracemalloc

import numpy as np
import pytest
from mbd_rigs import ROPE, no_casing, rigid_casing, train

from benchmarks.motion import mesh_mode_frequency
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.losses import Coulomb, Efficiency
from mbd.parts.part_checks import EquilibriumError, MachineError, StepError
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.statics import equilibrium
from mbd.system.system import assemble

REFUSALS = (MachineError, EquilibriumError, StepError)
SPEED = 94.2477796
PARTS, ROUND_OFF = 0.01, 1e-11
DEFAULT_STEP = 27e-6  # s, that of the lifted machine of two stages


def ramp(factor=1.0):
    return SpeedProfile(
        times=np.array([0.005, 0.02, 0.03, 0.04]), speeds=np.array([0.0, 1.0, 1.0, -1.0]) * SPEED * factor
    )


def stored_energy(system):
    """Strain of the loaded equilibrium and kinetic energy at the highest speed (J): what round-off is held against."""
    q, turning = equilibrium(system).displacement, system.machine.profile.highest * system.rolling
    return 0.5 * (q @ system.stiffness @ q + turning @ system.mass @ turning)


def runs(machine, casing=None, step=5e-6, end=0.05, total=1e-6, parts=PARTS, rate=5e3):
    """Run it; finite and closed: to ``total`` of all work of the sources, every part to 1 % of what it dissipates (of
    its peak energy if undamped), and both down to the round-off of the stored energy."""
    system = assemble(machine, rigid_casing(machine) if casing is None else casing)
    result = simulate(system, MotionSettings(end=end, output_rate=rate, step=step))
    assert np.isfinite(result.values).all()
    floor = ROUND_OFF * stored_energy(system)
    for part in result.energy_parts:
        share = total if part == "total" else parts
        assert abs(result.energy(part, "residual")) <= max(share * result.energy(part, "scale"), floor), part
    return result


def lifted(**options):
    rope = {"container_mass": 300.0} | options.pop("rope", {})
    return train(2, load="rope", profile=options.pop("profile", ramp()), rope=rope, **options)


def test_the_default_step_is_that_of_the_list():
    machine = lifted()
    mode = mesh_mode_frequency(assemble(machine, rigid_casing(machine)))
    assert pytest.approx(DEFAULT_STEP, rel=0.01) == 1 / 3 / mode


@pytest.mark.parametrize(("factor", "total", "parts"), [(0.1, 1e-6, 0.01), (1.0, 3e-6, 0.01), (20.0, 3e-5, 0.03)])
def test_step(factor, total, parts):
    """1e-6 from half the default step on; above, what is left is the work between the cubic that a mesh force is held
    by and the force itself where steps are cut, at the cells of the law: 1.1e-6 at the default step, 1.9e-5 and 2.2 %
    of the loss of a mesh at 540 us, twenty times it."""
    step = factor * DEFAULT_STEP
    runs(lifted(), step=step, rate=min(5e3, 1 / step), total=total, parts=parts)


@pytest.mark.parametrize("factor", [0.0, 10.0])
def test_speed(factor):
    runs(lifted(profile=ramp(factor)), step=2.5e-6 if factor else 5e-6)


def test_no_container_and_no_torque_rattles_in_the_backlash():
    result = runs(train(2, torque=0.0, profile=ramp()))
    assert result.counter("stage_1:contact_losses") + result.counter("stage_1:coast_contacts") > 0


def test_twenty_times_the_container():
    result = runs(lifted(rope={"container_mass": 6000.0}))
    assert result.channel("motor_1:torque").max() > 15 * 300 * 9.81 * 0.05 * 20 / 55 * 21 / 62 / 2


def test_no_damping_at_all():
    machine = lifted(
        rope={"rope_damping_ratio": 0.0}, shaft_tau=0.0, bearing_tau=0.0, coupling_damping=0.0, stage={"tau": 0.0}
    )
    result = runs(machine, no_casing(), step=2.5e-6)
    assert result.energy("total", "dissipated") == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("stiffness", [1e4, 1e6, 1e10, 1e12])
def test_bearing_stiffness(stiffness):
    machine = lifted(rope={"container_mass": 50.0})
    bearings = tuple(
        dataclasses.replace(b, stiffness=(*(stiffness,) * 3, *b.stiffness[3:]), damping_time=1e-6)
        for b in machine.bearings
    )
    machine = dataclasses.replace(machine, bearings=bearings)
    runs(machine)


@pytest.mark.parametrize("backlash", [0.0, 1e-3])
def test_backlash(backlash):
    runs(lifted(stage={"backlash": backlash}))


def toothless(places, **options):
    """A missing tooth of the number that ``places`` gives for the pinion and the wheel of every mesh."""
    machine, meshes = lifted(**options), []
    for mesh in machine.meshes:
        changes = {}
        for gear, place in places.items():
            teeth = mesh.drive.pinion_teeth if gear == "pinion" else mesh.drive.wheel_teeth
            gone = np.where(np.arange(teeth) == place, np.inf, 0.0)
            changes |= {f"{flank}_clearance_{gear}": gone for flank in ("drive", "coast")}
        meshes.append(dataclasses.replace(mesh, **changes))
    return dataclasses.replace(machine, meshes=tuple(meshes))


@pytest.mark.parametrize("places", [{"wheel": 2}, {"pinion": 2, "wheel": 2}])
def test_a_missing_tooth_on_every_wheel_at_once(places):
    runs(toothless(places))


@pytest.mark.parametrize("stiffness", [0.98, 1.0, 1.002])
def test_two_missing_teeth_side_by_side_in_every_mesh(stiffness):
    """The load falls through the gap: impacts of many times the load, begun and ended within the shortest step, and
    pairs that the mesh law drops under load; the total then closes to 7e-6 only, whatever the stiffness of the rope."""
    rope = {"rope_modulus": stiffness * ROPE["rope_modulus"]}
    result = runs(toothless({"pinion": 1, "wheel": 2}, rope=rope), total=1e-5)
    assert result.energy("total", "scale") > 10 * runs(lifted()).energy("total", "scale")


@pytest.mark.parametrize("length", [0.5, 100.0])
def test_rope_length(length):
    runs(lifted(rope={"rope_length": length}))


def test_winding_more_rope_than_there_is_is_refused():
    machine = lifted(rope={"rope_length": 0.02}, profile=ramp(5.0))
    with pytest.raises(MachineError, match="wound up"):
        runs(machine)


@pytest.mark.parametrize(
    "losses", [Efficiency(mesh_efficiency=0.6), Coulomb(tooth_friction=0.3, bearing_friction=0.05)]
)
def test_large_losses(losses):
    runs(dataclasses.replace(lifted(), losses=losses), step=2.5e-6)


def test_reversal_within_a_sample():
    profile = SpeedProfile(times=np.array([0.0, 0.02, 0.02005]), speeds=np.array([SPEED, SPEED, -SPEED]))
    runs(lifted(profile=profile), step=2.5e-6)


@pytest.mark.slow
def test_ten_minutes_of_motion():
    """Nothing drifts, the energy balance stays closed, and the second half takes no more memory than the first."""
    machine = train(1, model="torsion", speed=20.0, stage={"tau": 1e-5})
    names = ("stage_1:delta", "stage_1:drive_force", "motor_1:torque", "motor_2:torque")
    system, peaks = assemble(machine, no_casing(), names), []

    def keep_peak(done):
        if done >= 0.5 and not peaks:
            peaks.append(tracemalloc.get_traced_memory()[1])
            tracemalloc.reset_peak()

    tracemalloc.start()
    run = simulate(system, MotionSettings(end=600.0, output_rate=100.0, step=2e-4), progress=keep_peak)
    peaks.append(tracemalloc.get_traced_memory()[1])
    tracemalloc.stop()
    print(f"peak memory {peaks[0] / 1e6:.1f} and {peaks[1] / 1e6:.1f} MB")
    assert peaks[1] < 1.1 * peaks[0]
    for part in run.energy_parts:
        share = 1e-6 if part == "total" else PARTS
        print(f"{part}: {run.energy(part, 'residual'):.2g} of {run.energy(part, 'scale'):.3g} J")
        assert abs(run.energy(part, "residual")) <= share * run.energy(part, "scale"), part
    early, late = run.values[:, 1000:7000], run.values[:, -6000:]
    np.testing.assert_allclose(late.mean(axis=1), early.mean(axis=1), rtol=1e-4)
    np.testing.assert_allclose(late.std(axis=1), early.std(axis=1), rtol=0.05)
    torque = (run.channel("motor_1:torque") + run.channel("motor_2:torque"))[1000:].mean()
    assert torque == pytest.approx(equilibrium(system).motor_torque, rel=1e-4)
