"""Spalls of rolling bearings and slipping cages: path over the edge, transit, passages, energy balance."""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import no_casing
from test_rolling_bearings import loaded_shaft

from benchmarks.reference_integrator import ReferenceSettings
from mbd.elements.element import ENERGY
from mbd.elements.rule_call import evaluated
from mbd.excitations.cage_slip import PITCHES, CageSlip, lag_at
from mbd.excitations.faulty_bearing import FaultyContacts, drop_at, faulty_rule, with_faults
from mbd.excitations.spall import Spall, race_radius
from mbd.forces.rolling_bearing import RollingContacts, hertz_bearing
from mbd.forces.torque import Torque
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.bearings import rigid_bearing
from mbd.parts.channels import journal_acceleration, shaft_channels
from mbd.parts.checks import MachineError
from mbd.parts.load import StaticTorque
from mbd.parts.rolling_elements import RollingElements, pass_frequencies
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.system import assemble

BALLS, ROLLERS = RollingElements(designation="6208"), RollingElements(designation="NU208")
DOWN = 1.5 * math.pi  # where a weight presses the elements
RINGS = ("outer-ring", "inner-ring")
SURFACES = (*RINGS, "element")


def spall(on="outer-ring", width=2e-3, depth=5e-4, angle=0.0):
    return Spall(on=on, width=width, depth=depth, angle=angle)


def answer(elements, angle, *spalls, u=(0.0, 0.0, -3e-5, 0.0, 0.0), slip=None, twist=0.0, ratio=1.0):
    inside = FaultyContacts(contacts=RollingContacts(elements=elements), spalls=spalls, slip=slip)
    return evaluated(faulty_rule, inside.values(1, ratio), np.array(u), angle=angle, seen=np.array([twist]))


# the path of an element, by geometry alone


def drop(pit, elements, place, race="outer-ring"):
    """Of an element whose contact lies ``place`` (m) along the surface from the middle of the spall."""
    own = race if pit.on == "element" else pit.on
    shape = pit.width, pit.depth, pit.surface(elements)
    return drop_at(place, *shape, elements.diameter / 2, race_radius(elements, own))


@pytest.mark.parametrize("elements", [BALLS, ROLLERS])
@pytest.mark.parametrize("race", RINGS)
def test_an_element_rolls_about_the_edge_of_a_spall_on_a_circular_arc(elements, race):
    """From entry to the middle its centre keeps the distance of its radius from the edge."""
    pit, r = spall(race), elements.diameter / 2
    rho, side = abs(race_radius(elements, race)), 1.0 if race == "outer-ring" else -1.0
    edge = pit.width / (2 * rho)
    for angle in np.linspace(-edge, 0.0, 50):
        centre = rho - side * r + side * drop(pit, elements, angle * rho)
        apart = centre * np.array([math.cos(angle), math.sin(angle)]) - rho * np.array(
            [math.cos(edge), -math.sin(edge)]
        )
        assert np.linalg.norm(apart) == pytest.approx(r, rel=1e-12)


@pytest.mark.parametrize("race", RINGS)
def test_the_edges_of_a_spalled_element_roll_over_the_race(race):
    """Where both edges touch, they lie on the race."""
    pit, r = spall("element"), BALLS.diameter / 2
    rho, side = abs(race_radius(BALLS, race)), 1.0 if race == "outer-ring" else -1.0
    half = pit.width / (2 * r)
    centre = rho - side * r + side * drop(pit, BALLS, 0.0, race)
    assert math.hypot(centre + side * r * math.cos(half), r * math.sin(half)) == pytest.approx(rho, rel=1e-12)


@pytest.mark.parametrize("depth", [5e-4, 20e-6])
@pytest.mark.parametrize("on", SURFACES)
def test_the_path_is_continuous_and_enters_without_a_corner(on, depth):
    pit = spall(on, depth=depth)
    places = np.linspace(-0.6, 0.6, 24001) * pit.width
    path = np.array([drop(pit, BALLS, place) for place in places])
    slope = np.diff(path) / np.diff(places)
    steepest = pit.width / BALLS.diameter * 1.5
    assert abs(slope).max() < steepest  # no jump: a step of the path would be 1e5 times as steep
    entry = np.searchsorted(places, -pit.width / 2)
    assert not path[: entry - 1].any()
    assert abs(slope[entry - 2 : entry + 20]).max() < 0.01 * steepest
    np.testing.assert_allclose(path, path[::-1], atol=1e-15)


@pytest.mark.parametrize("race", RINGS)
def test_an_element_drops_to_the_bottom_or_by_its_sagitta(race):
    """Across the chord of the spall, and measured from the race, whose own sagitta is hollow or bulges."""
    r, rho = BALLS.diameter / 2, abs(race_radius(BALLS, race))
    chord = 2 * rho * math.sin(2e-3 / (2 * rho))
    sagitta = r - math.sqrt(r**2 - chord**2 / 4)
    own = rho - math.sqrt(rho**2 - chord**2 / 4)
    expected = sagitta - own if race == "outer-ring" else sagitta + own
    assert drop(spall(race), BALLS, 0.0) == pytest.approx(expected, rel=1e-9)
    assert drop(spall(race, depth=expected / 2), BALLS, 0.0) == pytest.approx(expected / 2)


# the bearing


@pytest.mark.parametrize("name", ["6208", "7208", "NU208"])
def test_without_a_spall_the_bearing_is_the_sound_one(name):
    elements, u = RollingElements(designation=name), np.array([2e-5, 8e-6, -1.3e-5, 1e-4, -2e-4])
    sound = RollingContacts(elements=elements)
    expected = evaluated(sound.rule, sound.values(pass_frequencies(elements).cage), u, angle=1.3)
    found = answer(elements, 1.3, u=u)
    for one, other in ((found.elastic, expected.elastic), (found.stiffness, expected.stiffness)):
        assert abs(one - other).max() < 1e-12 * abs(other).max()
    assert found.log[ENERGY] == pytest.approx(expected.log[ENERGY], rel=1e-12)


@pytest.mark.parametrize("name", ["6208", "7208", "NU208"])
@pytest.mark.parametrize("on", SURFACES)
def test_forces_over_a_spall_follow_from_the_potential(name, on):
    elements, u = RollingElements(designation=name), np.array([1e-5, 2e-5, -2e-5, 1e-4, -2e-4])
    pit = spall(on, depth=10e-6, angle=DOWN if on != "element" else 0.05)
    elements = dataclasses.replace(elements, cage_start=DOWN + 0.01)
    force, size = answer(elements, 0.0, pit, u=u).elastic, np.array([1e-5, 1e-5, 1e-5, 3e-4, 3e-4])
    assert answer(elements, 0.0, u=u).log[ENERGY] > 1.01 * answer(elements, 0.0, pit, u=u).log[ENERGY]
    for i in range(5):
        step = np.eye(5)[i] * size[i] * 1e-4
        high, low = (answer(elements, 0.0, pit, u=u + way).log[ENERGY] for way in (step, -step))
        assert abs((high - low) / (2 * step[i]) - force[i]) * size[i] < 1e-6 * abs(force * size).max()


def test_the_true_rotation_of_the_shaft_moves_spalls_and_cage():
    """Angle of the motor times the ratio, and torsion of the shaft: only their sum counts."""
    pits = [spall(on, depth=10e-6, angle=DOWN) for on in SURFACES]
    slip = CageSlip(share=0.02, seed=(1,))
    turned = answer(BALLS, 4.0, *pits, slip=slip, ratio=0.5)
    twisted = answer(BALLS, 1.0, *pits, slip=slip, ratio=0.5, twist=1.5)
    np.testing.assert_allclose(twisted.elastic, turned.elastic, rtol=1e-9, atol=1e-9 * abs(turned.elastic).max())
    assert abs(turned.elastic - answer(BALLS, 4.1, *pits, slip=slip, ratio=0.5).elastic).max() > 1.0


def test_a_shaft_that_turns_the_other_way_is_the_mirror_image():
    """Seen from the other end, z upside down: spalls, cage and forces."""
    pits = [spall("outer-ring", angle=DOWN + 0.1), spall("inner-ring", angle=0.4), spall("element", angle=0.2)]
    mirrored = [dataclasses.replace(pit, angle=-pit.angle) if pit.on != "element" else pit for pit in pits]
    slip, u = CageSlip(share=0.02, seed=(1,)), np.array([1e-5, 0.0, -3e-5, 0.0, 0.0])
    for angle in np.linspace(0.0, 3.0, 40):
        found = []
        for sense, given in ((1, pits), (-1, mirrored)):
            sound = RollingContacts(elements=dataclasses.replace(BALLS, cage_start=sense * 0.3))
            inside = FaultyContacts(contacts=sound, spalls=tuple(given), slip=slip)
            values, at = inside.values(sense, 1.0), u * np.array([1, 1, sense, 1, 1])
            found.append(evaluated(faulty_rule, values, at, angle=angle, seen=np.zeros(1)).elastic)
        np.testing.assert_allclose(found[1] * np.array([1, 1, -1, 1, 1]), found[0], rtol=1e-6, atol=1e-4)


# the shaft in its bearings


def transit(elements, on, speed, middle):
    """Duration (s), and the bearing in which an element is over the middle of the spall at ``middle`` (s), at DOWN."""
    per, turned = pass_frequencies(elements), speed * middle
    width, r = 1.5e-3, elements.diameter / 2
    start = DOWN + per.cage * turned
    angle = {"outer-ring": DOWN, "inner-ring": DOWN + turned, "element": -per.spin * turned}[on]
    pace = {
        "outer-ring": race_radius(elements, "outer-ring") * per.cage,
        "inner-ring": -race_radius(elements, "inner-ring") * (1 - per.cage),
        "element": r * per.spin,
    }[on]
    pit = spall(on, width=width, depth=10e-6, angle=angle)
    return width / (pace * speed), dataclasses.replace(elements, cage_start=start), pit


def shaken(
    elements, pits, *, speed, end, rate, step, mass=30.0, tau=2e-5, gravity=9.81, torque=0.0, slip=None,
    integrator="exponential",
):  # fmt: skip
    """The shaft in a bearing with spalls and without: time, what they change in its acceleration, the run with them."""
    machine = dataclasses.replace(
        loaded_shaft(BALLS, mass=mass, tau=tau),
        profile=SpeedProfile(times=np.zeros(1), speeds=np.array([speed])),
        load=StaticTorque(
            shaft="shaft_1", drums=(0.0,), torque=torque
        ),  # 0: no torsion, the shaft is where the motor is
        gravity=gravity,
    )
    old, *others = machine.bearings
    first = hertz_bearing(old.name, old.shaft, old.y, elements, tau)
    name, runs = journal_acceleration(first.name, "z"), []
    for spalls in (pits, ()):
        bearings = (with_faults(first, spalls, slip), *others)
        system = assemble(dataclasses.replace(machine, bearings=bearings), no_casing(), (name,))
        runs.append(
            simulate(
                system,
                ReferenceSettings(end=end, output_rate=rate, step=step, integrator=integrator),
            )
        )
    return runs[0].time, runs[0].channel(name) - runs[1].channel(name), runs[0]


@pytest.mark.parametrize("on", SURFACES)
def test_an_element_is_in_a_spall_as_long_as_geometry_says(on):
    """Slowly, so that a heavily damped shaft follows the path: it is accelerated from entry to exit and no longer."""
    speed, middle, tight = 0.2, 0.5, dataclasses.replace(BALLS, clearance=-20e-6)
    duration, elements, pit = transit(tight, on, speed, middle)
    time, change, _ = shaken(
        elements, (pit,), speed=speed, end=1.0, rate=1e4, step=1e-4, mass=2.0, tau=5e-4, gravity=500.0
    )  # fmt: skip
    felt = time[abs(change) > 2e-3 * abs(change).max()]
    assert felt[0] == pytest.approx(middle - duration / 2, abs=0.005 * duration)
    assert felt[-1] - felt[0] == pytest.approx(duration, rel=0.005)


@pytest.mark.parametrize("on", SURFACES)
def test_spalls_pass_at_the_frequency_of_the_geometry(on):
    """BPFO, BPFI and 2 BSF: from the first to the last shock of the run, of which each is a whole number of periods."""
    speed, per = 60.0, pass_frequencies(BALLS)
    pit = spall(on, width=1e-3, depth=50e-6, angle=DOWN)
    time, change, _ = shaken(BALLS, (pit,), speed=speed, end=1.0, rate=1e4, step=5e-5, tau=5e-4)
    felt = time[abs(change) > 0.05 * abs(change).max()]
    shocks = felt[np.diff(felt, prepend=-1.0) > 0.005]
    gaps = np.diff(shocks)
    period = (shocks[-1] - shocks[0]) / np.round(gaps / gaps.min()).sum()
    passages = {"outer-ring": per.outer, "inner-ring": per.inner, "element": 2 * per.spin}[on]
    assert len(shocks) > 8
    assert 1 / period == pytest.approx(passages * speed / (2 * math.pi), rel=0.005)


def test_passages_follow_the_rotation_of_a_shaft_that_a_torque_speeds_up():
    """The shaft gains more than a third of its speed; a shock comes at every pitch of the cage all the same."""
    torque = Torque(name="motor_1", shaft="shaft_1", y=0.1, times=np.zeros(1), torques=np.array([6.0]), drives=True)
    machine = dataclasses.replace(
        loaded_shaft(BALLS, mass=30.0, tau=5e-4), couplings=(), input_shaft="shaft_1", load=None, forces=(torque,),
        profile=SpeedProfile(times=np.zeros(1), speeds=np.array([60.0])),
    )  # fmt: skip
    names = journal_acceleration("bearing_1", "z"), *shaft_channels("shaft_1")
    sound, *others = machine.bearings
    runs = []
    for spalls in ((spall(width=1e-3, depth=50e-6, angle=DOWN),), ()):
        spec = dataclasses.replace(machine, bearings=(with_faults(sound, spalls), *others))
        runs.append(simulate(assemble(spec, no_casing(), names), MotionSettings(end=0.5, output_rate=1e4, step=5e-5)))
    change = abs(runs[0].channel(names[0]) - runs[1].channel(names[0]))
    angle, speed = (runs[0].channel(name) for name in names[1:])
    assert speed[-1] > 1.33 * speed[0]
    felt = np.flatnonzero(change > 0.05 * change.max())
    shocks = angle[felt[np.diff(felt, prepend=-100) > 50]]
    assert len(shocks) > 10
    pitch = 2 * math.pi / pass_frequencies(BALLS).outer
    assert (shocks[-1] - shocks[0]) / (len(shocks) - 1) == pytest.approx(pitch, rel=0.005)
    np.testing.assert_allclose(np.diff(shocks), pitch, rtol=0.05)


@pytest.mark.parametrize("elements", [BALLS, ROLLERS], ids=["balls", "rollers"])
def test_the_energy_balance_of_a_spalled_bearing_is_closed(elements):
    """What the moving spalls give is parametric work, in a bearing whose cage slips, too."""
    pits = [spall(on, depth=40e-6, angle=DOWN + 0.3 * k) for k, on in enumerate(SURFACES)]
    slip = CageSlip(share=0.02, seed=(3,))
    _, change, run = shaken(elements, pits, speed=100.0, end=0.15, rate=1e4, step=1e-5, torque=1.0, slip=slip)
    assert abs(change).max() > 10.0
    assert run.energy("bearing_1", "dissipated") > 1e-4
    assert run.energy("bearing_1", "parametric") > 0.5 * run.energy("bearing_1", "dissipated")
    assert abs(run.energy("bearing_1", "residual")) < 1e-3 * run.energy("bearing_1", "scale")
    assert abs(run.energy("total", "residual")) < 1e-6 * run.energy("total", "scale")


@pytest.mark.slow
def test_two_integrators_find_the_same_shocks():
    pits = [spall(on, depth=40e-6, angle=DOWN + 0.3 * k) for k, on in enumerate(SURFACES)]
    found = [
        shaken(BALLS, pits, speed=100.0, end=0.03, rate=1e4, step=1e-5, integrator=name)[1]
        for name in ("exponential", "reference")
    ]
    assert abs(found[1]).max() > 10.0
    assert np.linalg.norm(found[0] - found[1]) < 0.005 * np.linalg.norm(found[1])


# cage slip


def test_the_cage_walks_at_random_by_its_angle():
    """Zero at the start, continuous with its rate, spread by share times pitch times the root of the pitches."""
    pitch, share = 2 * math.pi / 9, 0.02
    walks = [CageSlip(share=share, seed=(seed,)).walk(pitch) for seed in range(400)]
    assert all(lag_at(0.0, pitch, walk) == 0.0 for walk in walks)
    spread = np.std([lag_at(100 * pitch, pitch, walk) for walk in walks])
    assert spread == pytest.approx(share * pitch * 10, rel=0.1)
    angles = np.linspace(-3.0, 3.0, 60001) * pitch
    lag = np.array([lag_at(angle, pitch, walks[0]) for angle in angles])
    rate = np.diff(lag) / np.diff(angles)
    assert abs(rate).max() < 5 * share
    assert abs(np.diff(rate)).max() < 1e-3 * share
    before, after = (lag_at(PITCHES * pitch + way, pitch, walks[0]) for way in (-1e-9, 1e-9))
    assert abs(after - before) < 1e-9


def test_the_same_seed_gives_the_same_cage_and_another_one_another():
    first, again, other = (CageSlip(share=0.01, seed=seed).walk(0.7) for seed in ((1, 5), (1, 5), (2, 5)))
    np.testing.assert_array_equal(first, again)
    assert abs(first - other).max() > 0.1


def test_slip_does_not_depend_on_the_time_step():
    """A cage drawn at every step would be elsewhere with every step."""
    found = []
    for step in (2.5e-5, 1.25e-5):
        _, change, _ = shaken(
            BALLS, (spall(depth=20e-6, angle=DOWN),), speed=60.0, end=0.2, rate=1e4, step=step,
            slip=CageSlip(share=0.03, seed=(1,)), tau=2e-4,
        )  # fmt: skip
        found.append(change)
    assert np.linalg.norm(found[0] - found[1]) < 0.01 * np.linalg.norm(found[1])


# what is refused


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: spall("cage"), "must be one of 'outer-ring'"),
        (lambda: spall(width=0.0), "width"),
        (lambda: spall(depth=-1e-6), "depth"),
        (lambda: FaultyContacts(contacts=RollingContacts(elements=BALLS), spalls=(spall(width=0.1),)), "a quarter"),
        (lambda: FaultyContacts(contacts=RollingContacts(elements=BALLS), spalls=(spall(depth=2e-3),)), "a tenth"),
        (lambda: FaultyContacts(contacts=RollingContacts(elements=BALLS), spalls=(spall(), spall(angle=0.01))), "over"),
        (lambda: with_faults(rigid_bearing("bearing_1", "shaft_1", 0.0), (spall(),)), 'model "hertz"'),
    ],
)
def test_impossible_spalls_are_refused(make, message):
    with pytest.raises(MachineError, match=message):
        make()
