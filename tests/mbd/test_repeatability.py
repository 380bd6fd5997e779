"""Motions that cannot be repeated sample by sample: rattle is told from regular motion."""

import numpy as np
import pytest
from mbd_rigs import rigid_casing, train

from mbd.integrators.base import LENGTH
from mbd.integrators.methods import make_integrator
from mbd.integrators.settings import MotionSettings
from mbd.output.repeatability import WATCHED, may_reach, other_start
from mbd.output.simulate import simulate
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.statics import equilibrium
from mbd.system.system import assemble
from pipelines.cli.main import main
from pipelines.engine.cache import Cache
from pipelines.engine.run_graph import run_graph
from pipelines.engine.step import Graph
from pipelines.io.text_table import Grid
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene
from pipelines.signals.motion_warnings import motion_warnings
from pipelines.steps.machine_steps import machine_steps
from pipelines.studies.trade.probes import Value
from pipelines.studies.trade.starts_table import spread_table

RATTLE = {
    "bearings": {"model": "hertz", "designation": "6205", "radial_clearance_um": 20.0},
    "load.container_kg": 2.0,
    "drive.speeds_rpm": [0.0, 3000.0, 3000.0],
}
ALONE = {"casing": {"model": "none"}, "sensors": [], "diagnosis.windows_s": {}}  # no casing: the cheapest
SHORT = {"simulation.end_s": 0.4}
JERK = SpeedProfile(times=np.array([0.01, 0.0105]), speeds=np.array([0.0, -94.25]))


def motion(name, settings):
    loaded = load_scene(name, settings)
    stages = Graph(machine_steps(make_machine(loaded.scene, loaded.source.shown)))
    return run_graph(stages, Cache(), ["simulate"], processes=1).value("simulate")


def test_rattle_is_told_with_what_to_do():
    """In 0.4 s of motion, with the rate at which neighbours part and the command that helps."""
    rattling = motion("minimal", RATTLE | ALONE | SHORT)
    assert rattling.diverged_at > 0.05
    assert 50 < rattling.parting_rate < 1000
    sentence = motion_warnings(rattling)["repeat"]
    assert "cannot be repeated sample by sample" in sentence
    assert f"doubles every {1000 * np.log(2.0) / rattling.parting_rate:.2g} ms" in sentence
    assert "gearcase starts" in sentence


@pytest.mark.slow
@pytest.mark.parametrize("settings", [{}, {"load.container_kg": 5.0}, {"bearings": RATTLE["bearings"]}])
def test_regular_motion_is_not_called_unrepeatable(settings):
    """Loaded; light, with contacts that open; loaded on bearings with clearance."""
    regular = motion("minimal", settings | ALONE | SHORT)
    assert regular.diverged_at == 0.0
    assert motion_warnings(regular) == {}


def test_slow_growth_that_scatters_is_followed_and_a_constant_distance_is_not():
    """Growth by e in three windows, after a decay of the change itself; each window scatters by a factor of 1.5."""
    scatter = np.exp(0.4 * np.random.default_rng(5).standard_normal(60))
    growing = 1e-5 * np.exp(np.arange(60) / 3.0) * scatter
    growing[0] *= 20.0
    constant = 1e-5 * scatter
    assert all(may_reach(1.0, growing[:count], 150 - count) for count in range(1, 36))
    assert may_reach(1.0, constant[:WATCHED], 100)
    assert not any(may_reach(1.0, constant[:count], 100) for count in range(WATCHED + 6, 60))


def test_a_neighbour_takes_the_cuts_of_the_motion():
    """With them the distance stays at that of the start through impacts; cuts of its own part the two far more."""
    machine = train(1, profile=JERK)
    system = assemble(machine, rigid_casing(machine), ())
    step = 2e-5
    integrator = make_integrator("exponential", system, step)
    block = integrator.start(equilibrium(system))
    before = integrator.advance(*JERK.motion(0, 520, step))
    alike, free = (integrator.branch(1e-9 * before.states[-1]) for _ in range(2))
    block = integrator.advance(*JERK.motion(520, 300, step))
    assert len(np.unique(block.clock[:, LENGTH])) > 2
    one = alike.advance(*JERK.motion(520, 300, step), like=block)
    other = free.advance(*JERK.motion(520, 300, step))
    np.testing.assert_array_equal(one.clock, block.clock)
    assert len(other.whole) == len(one.whole)
    size = np.linalg.norm(block.states[block.whole[-1]])
    assert np.linalg.norm(one.states[one.whole[-1]] - block.states[block.whole[-1]]) < 1e-5 * size


@pytest.mark.parametrize("integrator", ["trapezoidal", "generalised-alpha"])
def test_the_other_integrators_tell_rattle_as_well(integrator):
    """In 0.8 s: rounding, which differs from processor to processor, decides when in the first half neighbours part."""
    scene = RATTLE | ALONE | {"simulation.end_s": 0.8, "simulation.integrator": integrator, "simulation.step_us": 50.0}
    assert motion("minimal", scene).diverged_at > 0.0


def test_other_starts_lie_beside_the_rest():
    machine = train(1, profile=JERK)
    system = assemble(machine, rigid_casing(machine), ("stage_1:delta",))
    rest = equilibrium(system)
    starts = [other_start(system, rest, number).displacement for number in (1, 1, 2)]
    np.testing.assert_array_equal(starts[0], starts[1])
    moved = np.linalg.norm(starts[0] - rest.displacement) / np.linalg.norm(rest.displacement)
    assert 1e-6 < moved < 1e-3
    assert not np.array_equal(starts[0], starts[2])


def test_mean_and_spread_over_starts():
    """Of 1, 2, 3: mean 2, standard deviation 1, mean known to 4.303/sqrt(3)."""
    starts = [[Value(name="rms", unit="m/s2", value=value)] for value in (1.0, 2.0, 3.0)]
    table = spread_table(starts)
    assert isinstance(table, Grid)
    assert table.rows == (("rms, m/s2", "2", "2.484", "1", "1", "3"),)


def test_starts_prints_levels_with_their_spread(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    settings = ["--set=simulation.end_s=0.1", "--set=diagnosis.windows_s={}"]
    assert main(["starts", "minimal", "--starts", "2", "--quiet", *settings]) == 0
    out = capsys.readouterr().out
    assert "sensor_3 rms, whole run" in out
    assert "standard deviation" in out


@pytest.mark.slow
def test_no_warning_on_the_rig_over_twenty_seeds():
    for seed in range(1, 21):
        healthy = motion("rig-healthy", {"deviations.seed": seed})
        assert motion_warnings(healthy) == {}, seed


@pytest.mark.slow
def test_a_warning_in_twenty_of_twenty_rattling_starts():
    scene = RATTLE | {"shaft_model.model": "timoshenko", "simulation.end_s": 0.6, "diagnosis.windows_s": {}}
    found = [motion("minimal", scene | {"simulation.start": start}).diverged_at for start in range(1, 21)]
    assert all(found), found


def test_settings_of_the_library_measure_too():
    machine = train(1)
    system = assemble(machine, rigid_casing(machine), ("sensor_1:az",))
    assert simulate(system, MotionSettings(end=0.05, step=2e-5)).diverged_at == 0.0
