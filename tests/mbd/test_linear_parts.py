"""What every kind of linear part must meet, whatever it is. A kind is tested once a machine of `MACHINES` has it, and
`test_every_kind_is_in_a_machine` fails until one has."""

import dataclasses
import importlib
import pkgutil

import numpy as np
import pytest
from mbd_rigs import hoisting, rigid_casing, swinging

import mbd
from mbd.elements.component import Component
from mbd.elements.linear_part import part_on_rows, springs
from mbd.elements.mode_words import ModeWords
from mbd.excitations.misaligned_coupling import MisalignedCoupling
from mbd.excitations.unbalance import Unbalance
from mbd.forces.speed_controller import SpeedController
from mbd.forces.torque import Torque
from mbd.forces.torque_source import Rotor
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.couplings import ShaftCoupling
from mbd.parts.load import OutsideForce
from mbd.parts.part_checks import MachineError
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.linearised import linear_modes
from mbd.system.system import assemble

ROUND_OFF = 1e-12


def coupled():
    """The first shaft in two, motors at the outer one; its bearings have cross terms and dampers of their own."""
    machine = hoisting()
    outer = dataclasses.replace(machine.shafts[0], name="shaft_0", disks=())
    dampers = np.diag([2e3, 1e3, 3e3, 0.0, 0.0])
    dampers[0, 2] = dampers[2, 0] = 1e3
    bearings = tuple(
        dataclasses.replace(
            bearing,
            name=f"bearing_{9 + i}",
            shaft="shaft_0",
            cross=(("ux", "uz", 2e6),),
            damping=tuple(map(tuple, dampers)),
        )
        for i, bearing in enumerate(machine.bearings[:2])
    )
    coupling = ShaftCoupling(
        name="coupling_1", shafts=("shaft_0", "shaft_1"), y=(0.2, 0.2), torsional_stiffness=3e4, radial_stiffness=1e6,
        axial_stiffness=2e6, tilt_stiffness=2e3, damping_time=1e-5,
    )  # fmt: skip
    motors = tuple(dataclasses.replace(motor, shaft="shaft_0") for motor in machine.couplings)
    return dataclasses.replace(
        machine, shafts=(outer, *machine.shafts), bearings=(*bearings, *machine.bearings), couplings=motors,
        shaft_couplings=(coupling,),
    )  # fmt: skip


def misaligned():
    """`coupled` by a coupling with rotating stiffness axes."""
    machine = coupled()
    (plain,) = machine.shaft_couplings
    turning = MisalignedCoupling(**vars(plain), offset=(1e-4, -5e-5), radial_stiffness_across=4e5)
    return dataclasses.replace(machine, shaft_couplings=(turning,))


def unbalanced():
    return dataclasses.replace(hoisting(), forces=(Unbalance(name="heavy", shaft="shaft_2", y=0.0, size=1e-4),))


def with_rotor():
    """A further torque on a rotor of its own behind a coupling."""
    rotor = Rotor(inertia=2e-3, stiffness=1e4, damping=0.3)
    one = Torque(name="fan", shaft="shaft_2", y=0.1, rotor=rotor, times=np.zeros(1), torques=np.array([-2.0]))
    return dataclasses.replace(hoisting(), forces=(one,))


def controlled():
    """A motor with a speed controller, whose anti-windup has a mass, a spring and a damper."""
    motor = SpeedController(
        name="motor", shaft="shaft_1", y=0.0, rotor=Rotor(inertia=2e-3), times=np.zeros(1), speeds=np.array([94.0]),
        proportional=2.0, integral=40.0, limit=60.0,
    )  # fmt: skip
    return dataclasses.replace(hoisting(), forces=(motor,))


MACHINES = {
    "beams": hoisting,
    "torsion": lambda: hoisting("torsion"),
    "pendulum": swinging,
    "coupling": coupled,
    "misaligned coupling": misaligned,
    "gyroscopic": lambda: dataclasses.replace(hoisting(), gyroscopic=True),
    "unbalance": unbalanced,
    "rotor": with_rotor,
    "controller": controlled,
}


def assembled(name, channels=()):
    machine = MACHINES[name]()
    return assemble(machine, rigid_casing(machine, extra=2), channels)


@pytest.fixture(params=MACHINES)
def system(request):
    return assembled(request.param)


def subclasses(kind):
    for sub in kind.__subclasses__():
        yield sub
        yield from subclasses(sub)


def test_every_kind_is_in_a_machine():
    for module in pkgutil.walk_packages(mbd.__path__, "mbd."):
        importlib.import_module(module.name)
    own = [kind for kind in subclasses(Component) if kind.__module__.startswith("mbd.") and "parts" in vars(kind)]
    used = {type(one).parts for name in MACHINES for one in assembled(name).layout.components}
    assert {kind.parts for kind in own} == used - {Component.parts}


def assert_semidefinite(matrix):
    size = np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
    scaled = matrix / np.outer(size, size)
    assert abs(scaled - scaled.T).max(initial=0.0) < ROUND_OFF
    assert np.linalg.eigvalsh(scaled).min(initial=0.0) > -1e-9


def test_matrices_are_symmetric_and_store_or_lose_energy_and_gyroscopic_ones_do_no_work(system):
    for part in system.parts:
        d = len(part.shape)
        for name in ("mass", "damping", "stiffness"):
            assert part.own(name).shape == (d, d)
            assert_semidefinite(part.own(name))
        skew = part.own("gyroscopic")
        assert abs(skew + skew.T).max() <= ROUND_OFF * abs(skew).max()
        for matrix in (part.mass, part.damping, part.stiffness):
            assert_semidefinite(matrix)


def test_every_part_does_something(system):
    for part in system.parts:
        assert part.mass.any() or part.damping.any() or part.stiffness.any(), part.name


def test_the_energies_of_all_parts_are_those_of_the_assembled_matrices(system):
    """What the parts store and lose is x^T K x/2, v^T M v/2 and v^T C v without the references of the elements."""
    random = np.random.default_rng(0)
    x, v = random.standard_normal((2, system.layout.size)) * 1e-5
    stiffness, damping = system.stiffness.copy(), system.damping.copy()
    for row, k, c in zip(system.rows, system.table.stiffness, system.table.damping, strict=True):
        stiffness -= k * np.outer(row, row)
        damping -= c * np.outer(row, row)
    at_rest = sum(part.stored(x[part.index], 0.0 * v[part.index]) for part in system.parts)
    moving = sum(part.stored(0.0 * x[part.index], v[part.index]) for part in system.parts)
    lost = sum(part.dissipated(np.outer(v[part.index], v[part.index])) for part in system.parts)
    assert at_rest == pytest.approx(0.5 * x @ stiffness @ x, rel=1e-9)
    assert moving == pytest.approx(0.5 * v @ system.mass @ v, rel=1e-9)
    assert lost == pytest.approx(v @ damping @ v, rel=1e-9)


def test_rolling_costs_no_elastic_energy_but_against_standing_motors(system):
    """Without the motors every part rolls freely, and the couplings of the motors give back their angles."""
    rolling = 1e-3 * system.rolling
    for part in system.parts:
        own = rolling[part.index]
        stored = part.stored(own, 0.0 * own)
        if len(part.driven):
            assert np.allclose(part.shape @ own, 1e-3 * part.driven)
            assert stored > 0.0
        else:
            assert stored <= ROUND_OFF * 0.5 * abs(own) @ abs(part.stiffness) @ abs(own)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class GroundSpring(OutsideForce):
    """A spring to ground on one displacement (axis 0..5 = ux uy uz rx ry rz) of a shaft."""

    axis: int

    def parts(self, lay):
        yield part_on_rows(
            lay.axis_row(self.shaft, self.y, self.axis)[None], name=self.name,
            words=ModeWords("ground spring", "ground springs"), matrices=springs(np.array([1e4]), 1e-5),
        )  # fmt: skip


def test_an_outside_part_that_nothing_else_knows_runs_and_its_energy_is_balanced():
    profile = SpeedProfile(times=np.array([0.002, 0.01]), speeds=np.array([0.0, 94.0]))
    springs = tuple(GroundSpring(name=f"spring_{a}", shaft="shaft_1", y=0.0, axis=a) for a in (2, 3))
    machine = dataclasses.replace(hoisting(), forces=springs, profile=profile)
    run = simulate(assemble(machine, rigid_casing(machine), ()), MotionSettings(end=0.02, output_rate=5e3, step=1e-5))
    assert not run.open_parts()
    assert run.energy("spring_2", "dissipated") > 0.0
    assert "spring_3" in linear_modes(assemble(machine, rigid_casing(machine), ())).part_names


def test_a_spring_to_ground_that_rolling_would_wind_up_is_refused():
    spring = GroundSpring(name="spring", shaft="shaft_1", y=0.0, axis=4)
    machine = dataclasses.replace(hoisting(), forces=(spring,))
    with pytest.raises(MachineError, match="spring: the rolling of the train strains it"):
        assemble(machine, rigid_casing(machine), ())


@pytest.mark.parametrize("axis", range(6))
def test_a_rigid_motion_of_everything_strains_only_what_stands_on_the_ground(axis):
    """Shafts, casing and what joins them move as one body: only the casing's mounts and the motors are strained."""
    machine = MACHINES["coupling"]()
    system = assemble(machine, rigid_casing(machine), ())
    lay, turn = system.layout, np.zeros((3, 3))
    if axis >= 3:
        i, j = [(1, 2), (2, 0), (0, 1)][axis - 3]
        turn[j, i], turn[i, j] = 1.0, -1.0
    motion = np.zeros(lay.size)
    for shaft in machine.shafts:
        places = np.array([(shaft.x, y, shaft.z) for y in lay.shaft_nodes[shaft.name]])
        shift = places @ turn.T + (np.eye(3)[axis] if axis < 3 else 0.0)
        spin = np.tile(np.eye(3)[axis - 3] if axis >= 3 else np.zeros(3), (len(places), 1))
        motion[lay.index(shaft.name)] = np.hstack([shift, spin]).ravel()
    motion[lay.index("casing")] = np.eye(6)[axis]
    for part in system.parts:
        own = motion[part.index]
        if not len(part.driven) and part.name != "casing":
            assert part.stored(own, 0.0 * own) <= 1e-9 * 0.5 * abs(own) @ abs(part.stiffness) @ abs(own), part.name


@pytest.mark.parametrize("method", ["exponential", "generalised-alpha"])
def test_the_energy_of_every_part_is_balanced(method):
    profile = SpeedProfile(times=np.array([0.002, 0.01]), speeds=np.array([0.0, 94.0]))
    machine = dataclasses.replace(MACHINES["coupling"](), profile=profile)
    system = assemble(machine, rigid_casing(machine), ())
    run = simulate(system, MotionSettings(end=0.02, output_rate=5e3, step=1e-5, integrator=method))
    assert not run.open_parts()
    assert {part.name for part in system.parts} < set(run.energy_parts)
    assert run.energy("coupling_1", "dissipated") > 0.0


def test_modes_are_called_by_the_words_of_the_kinds(system):
    modes = linear_modes(system, up_to=2e3)
    own = {part.words.kind for part in system.parts} | {e.words.kind for e in system.elements if e.words}
    assert set(modes.part_kinds) == own
    assert all(modes.dominant)
    np.testing.assert_allclose(modes.shares.sum(axis=1), 1.0, atol=1e-6)
