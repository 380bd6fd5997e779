"""A bent shaft whirls by the closed form of a bowed Jeffcott rotor (Nicholas, Gunter & Allaire 1976)."""

import cmath
import dataclasses
import math

import pytest
from mbd_rigs import no_casing, train
from rotors import CRITICAL, DAMPING, LENGTH, MOVING, PROBE, STIFFNESS, Probe, jeffcott, line

from mbd.excitations.bent_shaft import BentShaft
from mbd.excitations.unbalance import Unbalance
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.part_checks import MachineError
from mbd.system.system import assemble
from pipelines.io.errors import SceneError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene

BOW, ANGLE = 20e-6, 0.3


def bent(**changes):
    fields = {
        "name": "bow", "shaft": "shaft_1", "y": LENGTH / 2, "bow": BOW, "straight": (0.0, LENGTH), "angle": ANGLE,
    }  # fmt: skip
    return BentShaft(**fields | changes)


def whirl(*forces, r, sense=1, channels=PROBE, step=1e-4):
    machine = jeffcott(*forces, speed=r * CRITICAL, sense=sense)
    return simulate(assemble(machine, no_casing(), channels), MotionSettings(end=1.2, output_rate=2000.0, step=step))


@pytest.mark.parametrize("r", [0.2, 0.6, 1.0, 1.6])
@pytest.mark.parametrize("sense", [1, -1])
def test_a_bowed_jeffcott_rotor_whirls_by_the_closed_form_in_size_and_phase(r, sense):
    """x + i z = b/(1 - r^2 + 2 i zeta r), turning; at low speed the bow itself."""
    run = whirl(bent(), r=r, sense=sense)
    late = run.time > 0.8
    answer = BOW / complex(1 - r * r, 2 * DAMPING * r) * cmath.exp(-1j * sense * ANGLE)
    for name, quarter in (("probe:x", 1.0), ("probe:z", 1j * sense)):
        found = line(run.time[late], run.channel(name)[late], r * CRITICAL)
        assert abs(found / (answer * quarter) - 1) < 5e-3


def test_a_bow_against_an_unbalance_cancels_it_at_one_speed():
    """b - e mu r^2 = 0: the rotor runs still at r^2 = b/(e mu), here 1.3, far from still with either alone."""
    r = 1.3
    size = BOW * MOVING / r**2
    heavy = Unbalance(name="unbalance", shaft="shaft_1", y=LENGTH / 2, size=size, angle=ANGLE + math.pi)
    still, alone = (whirl(*forces, r=r) for forces in ((bent(), heavy), (bent(),)))
    late = still.time > 0.8
    left, full = (abs(line(run.time[late], run.channel("probe:x")[late], r * CRITICAL)) for run in (still, alone))
    assert full > BOW
    assert left < 5e-3 * full


def test_the_motor_pays_for_the_whirl():
    run = whirl(bent(), r=1.0, channels=("motor_1:torque",), step=2e-5)
    late = run.time > 0.8
    amplitude = BOW / (2 * DAMPING)
    drag = 2 * DAMPING * CRITICAL * MOVING * CRITICAL * amplitude**2  # c v^2 over the speed
    assert run.channel("motor_1:torque")[late].mean() == pytest.approx(drag, rel=0.01)
    assert abs(run.energy("bow", "residual")) < 1e-3 * run.energy("shaft_1", "dissipated")


def test_a_bow_needs_no_force_but_its_own():
    """At rest the rotor takes the shape of the bow, and its bearings are free of load."""
    system = assemble(jeffcott(bent(angle=0.0)), no_casing(), (*PROBE, "bearing_1:fx", "bearing_2:fx"))
    run = simulate(system, MotionSettings(end=0.01, output_rate=1e3, step=1e-4))
    assert run.channel("probe:x")[0] == pytest.approx(BOW, rel=1e-6)
    assert abs(run.channel("bearing_1:fx")[0]) < 1e-6 * STIFFNESS * BOW


def test_an_overhung_end_is_bent_without_load_on_the_bearings():
    """Straight at both bearings, bent beyond them: the end lies off by the bow, the bearings carry nothing."""
    end = Probe(name="end", shaft="shaft_1", y=LENGTH)
    machine = jeffcott(bent(y=LENGTH, straight=(0.0, 0.3), angle=0.0), end)
    bearings = tuple(dataclasses.replace(b, y=y) for b, y in zip(machine.bearings, (0.0, 0.3), strict=True))
    system = assemble(
        dataclasses.replace(machine, bearings=bearings), no_casing(), ("end:x", "bearing_1:fx", "bearing_2:fx")
    )
    run = simulate(system, MotionSettings(end=0.01, output_rate=1e3, step=1e-4))
    assert run.channel("end:x")[0] == pytest.approx(BOW, rel=1e-6)
    for name in ("bearing_1:fx", "bearing_2:fx"):
        assert abs(run.channel(name)[0]) < 1e-6 * STIFFNESS * BOW


def test_what_is_no_bow_is_refused():
    for straight in ((0.0, 0.0), (0.25, 0.5)):
        with pytest.raises(MachineError, match="two places other than position_mm"):
            bent(straight=straight)
    with pytest.raises(MachineError, match="does not bend"):
        assemble(
            dataclasses.replace(train(1, model="torsion"), forces=(bent(y=0.0, straight=(-0.1, 0.1)),)),
            no_casing(),
            (),
        )


TABLE = {"model": "bent-shaft", "shaft": 2, "position_mm": 10.0, "bow_um": 30.0, "straight_at_mm": [-20.0, 25.0]}


def test_a_bent_shaft_of_a_scene_in_si():
    (force,) = make_machine(load_scene("minimal", {"forces": [TABLE | {"angle_deg": 45.0}]}).scene).parts.forces
    assert (force.shaft, force.y, force.bow) == ("shaft_2", 0.01, pytest.approx(3e-5))
    assert force.straight == (-0.02, 0.025)
    assert force.angle == pytest.approx(math.pi / 4)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"straight_at_mm": [-20.0, 2500.0]}, "forces.1.straight_at_mm.2: y = 2500 mm is not on shaft 2"),
        ({"straight_at_mm": [10.0, 25.0]}, "two places other than position_mm"),
    ],
)
def test_bows_that_cannot_be_are_refused(changes, message):
    with pytest.raises(SceneError, match=message):
        checked_machine(load_scene("minimal", {"forces": [TABLE | changes]}).scene, "scene")
