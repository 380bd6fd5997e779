"""Oil between the flanks: the force of Reynolds' equation, what it takes from an impact, and what it leaves alone."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from mbd_rigs import no_casing, train
from scipy.integrate import quad, solve_ivp

from benchmarks.gear_pairs import gear_pair
from mbd.forces.film import film_rule
from mbd.forces.torque import Torque
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.oil_film import Film
from mbd.parts.part_checks import MachineError
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.statics import equilibrium
from mbd.system.system import assemble
from pipelines.machine.machine_conversion import film_spec
from pipelines.scene.load_scene import load_scene

FILM = Film(viscosity=0.05, roughness=1e-6, radius=8e-3, length=0.02)


def test_the_force_is_the_integral_of_the_pressure_of_a_cylinder_that_approaches_a_plane():
    """Reynolds: p = 6 eta v R/h(x)^2 with h = h_0 + x^2/2R, no suction where the film is closed."""
    for gap in (2e-6, 20e-6, 80e-6):
        pressure = quad(lambda s, h=gap: 6 * FILM.viscosity * FILM.radius / (h * (1 + s * s)) ** 2, -np.inf, np.inf)[0]
        by_hand = FILM.length * pressure * np.sqrt(2 * FILM.radius * gap)  # x = s sqrt(2 R h_0)
        assert FILM.strength / gap**1.5 == pytest.approx(by_hand, rel=1e-8)


@pytest.mark.parametrize("gap", [5e-6, -1e-6])
def test_the_force_fades_with_what_the_flanks_carry_and_its_slopes_are_those_of_the_force(gap):
    """C v h^-1.5 / (1 + F / F_0), F = k w with the displacements w of the flank."""
    fading, stiffness, speed = 30.0, np.array([[4e7, -3e5]]), 0.02

    def answered(u, v, w):
        motion = SimpleNamespace(u=[u], v=[v], read_force=stiffness @ w, read_stiffness=stiffness)
        answer = SimpleNamespace(lost=np.zeros(1), lost_by_u=np.zeros((1, 3)), lost_by_v=np.zeros((1, 1)))
        film_rule.function((FILM.strength, FILM.roughness, 0.0, fading), motion, answer)
        return answer

    state, step = np.array([-gap, speed, 2e-6, 1e-5]), np.diag([1e-10, 1e-6, 1e-10, 1e-8])
    found = answered(state[0], state[1], state[2:])
    carried = float(stiffness[0] @ state[2:])
    by_hand = FILM.strength * speed / (FILM.roughness + max(gap, 0.0)) ** 1.5 / (1 + carried / fading)
    assert found.lost[0] == pytest.approx(by_hand)
    ends = [[answered(x[0], x[1], x[2:]).lost[0] for x in (state + one, state - one)] for one in step]
    slopes = -np.diff(ends, axis=1).ravel() / (2 * np.diag(step))
    given = [found.lost_by_u[0, 0], found.lost_by_v[0, 0], *found.lost_by_u[0, 1:]]
    assert given == pytest.approx(slopes, rel=1e-5, abs=1e-9 * abs(slopes).max())


def test_the_film_of_a_scene_has_the_relative_curvature_and_the_lines_of_contact_of_its_pair():
    """At the pitch point of a helical pair: radii r_w sin(alpha_wt) over cos(beta_b), and eps_alpha b / cos(beta_b)."""
    pair = gear_pair((20, 55), 2, 12, 12)
    film = film_spec(load_scene("minimal", {"film.model": "squeeze"}).scene.film, pair)
    first, second = (radius * np.sin(pair.working_pressure_angle) for radius in pair.working_radii)
    assert 1 / film.radius == pytest.approx((1 / first + 1 / second) * np.cos(pair.base_helix_angle))
    assert film.length == pytest.approx(pair.transverse_contact_ratio * 12e-3 / np.cos(pair.base_helix_angle))


def free_gears(film):
    """Two rigid shafts that only turn, gears apart in their backlash, approaching on the drive flank."""
    machine = train(1, model="torsion", stage={"ripple": 0.0, "tau": 0.0, "backlash": 200e-6})
    idle = Torque(name="load", shaft="shaft_2", y=0.0, times=np.zeros(1), torques=np.zeros(1))
    meshes = tuple(replace(mesh, film=film) for mesh in machine.meshes)
    still = SpeedProfile(times=np.zeros(1), speeds=np.zeros(1))
    machine = replace(
        machine,
        couplings=(),
        input_shaft="shaft_1",
        load=None,
        forces=(idle,),
        meshes=meshes,
        gravity=0.0,
        profile=still,
    )
    return assemble(machine, no_casing(), ("stage_1:delta", "stage_1:drive_force"))


def approach(system, speed, gap):
    """A state with delta = -gap that closes at ``speed``: both gears turn rigidly, without momentum together."""
    row, turns = system.rows[system.at("stage_1:drive").start], []
    for shaft in ("shaft_1", "shaft_2"):
        own = np.zeros(system.layout.size)
        own[system.layout.index(shaft)] = system.rolling[system.layout.index(shaft)]
        turns.append(own)
    momentum = [system.rolling @ system.mass @ own for own in turns]
    relative = momentum[1] * turns[0] - momentum[0] * turns[1]
    relative /= row @ relative
    rest = equilibrium(system)
    table, rows = system.table, system.all_rows
    displacement = -gap * relative
    forces = np.zeros(len(system.rows))
    u = rows @ displacement
    forces[:] = table.stiffness * u[: len(forces)]  # open flanks: only the reference, which the residual takes back
    return replace(rest, displacement=displacement, velocity=speed * relative, forces=forces), relative


def test_a_lone_approach_loses_speed_as_the_closed_form_says():
    """m dv/dh = C h^-1.5: v(h) = v_0 - 2 C/m (h^-0.5 - h_0^-0.5)."""
    system = free_gears(FILM)
    start, relative = approach(system, 0.05, 80e-6)
    mass = float(relative @ system.mass @ relative)
    found = simulate(system, MotionSettings(end=1.2e-3, output_rate=200e3, step=5e-6), start=start)
    h0 = 80e-6 + FILM.roughness

    def rate(_, y):
        return [-y[1], -FILM.strength / max(y[0], FILM.roughness) ** 1.5 * y[1] / mass]

    exact = solve_ivp(rate, (0.0, 1.2e-3), [h0, 0.05], t_eval=found.time, rtol=1e-10, atol=1e-14)
    gap = -found.channel("stage_1:delta") + FILM.roughness
    middle = (found.time > 2e-4) & (exact.y[0] > 5e-6)
    np.testing.assert_allclose(gap[middle], exact.y[0][middle], rtol=0.02)


@pytest.fixture(scope="module")
def rattling():
    """An unloaded pair under a speed that swings: with and without oil."""
    times = np.linspace(0.0, 0.3, 601)
    profile = SpeedProfile(times=times, speeds=80.0 + 4.0 * np.sin(2 * np.pi * 40 * times))
    base = train(1, model="torsion", profile=profile, torque=0.0)
    found = {}
    for name, film in (("dry", None), ("oil", FILM)):
        machine = replace(base, meshes=tuple(replace(mesh, film=film) for mesh in base.meshes))
        system = assemble(machine, no_casing(), ("stage_1:drive_force", "stage_1:coast_force"))
        found[name] = simulate(system, MotionSettings(end=0.3, output_rate=10e3, step=1e-5))
    return found


@pytest.mark.slow
def test_oil_softens_the_blows_of_a_rattling_pair_and_its_losses_are_booked(rattling):
    dry, oil = rattling["dry"], rattling["oil"]
    assert oil.energy("stage_1 film", "dissipated") > 0.0
    assert abs(oil.energy("total", "residual")) < 1e-6 * oil.energy("total", "scale")
    assert oil.energy("stage_1", "dissipated") < 0.5 * dry.energy("stage_1", "dissipated")  # in the flanks, by blows


def test_a_loaded_mesh_hardly_feels_the_film():
    base = train(1)
    found = []
    for film in (None, FILM):
        machine = replace(base, meshes=tuple(replace(mesh, film=film) for mesh in base.meshes))
        system = assemble(machine, no_casing(), ("stage_1:drive_force",))
        assert equilibrium(system).mesh_force[0] == pytest.approx(equilibrium(system).mesh_force[0])
        found.append(simulate(system, MotionSettings(end=0.1, output_rate=10e3)).channel("stage_1:drive_force"))
    assert found[1].mean() == pytest.approx(found[0].mean(), rel=2e-3)


@pytest.mark.parametrize("name", ["viscosity", "roughness"])
def test_a_film_of_nothing_is_refused(name):
    with pytest.raises(MachineError, match=name):
        replace(FILM, **{name: 0.0})


def test_the_rule_is_one_element_per_flank():
    system = free_gears(FILM)
    films = [element for element in system.elements if element.kind == "film"]
    assert [element.rule for element in films] == [film_rule, film_rule]
