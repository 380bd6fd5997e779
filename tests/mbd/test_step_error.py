"""The error of the time step: the estimate against the true error, and what the user is told."""

import json
import re

import numpy as np
import pytest
from mbd_rigs import rigid_casing, train
from report_pages import body_of

from mbd.integrators.methods import make_integrator
from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.speed_drive import SpeedProfile
from mbd.system.statics import equilibrium
from mbd.system.system import assemble
from pipelines.cli.main import main
from pipelines.report.first_screen import screen_parts
from pipelines.signals.motion_warnings import gathered, motion_warnings

RAMP = SpeedProfile(times=np.array([0.0, 0.04]), speeds=np.array([0.0, 94.25]))
COARSE = {"simulation.integrator": "trapezoidal", "simulation.end_s": 0.3, "diagnosis.windows_s": {}}


def machine(**options):
    one_stage = train(1, profile=RAMP, **options)
    return assemble(one_stage, rigid_casing(one_stage, extra=4), ("sensor_1:ax", "sensor_1:az", "stage_1:delta"))


def true_error(system, method, step, end):
    """Of the accelerations of a run, RMS over the signal's, against an eighth of the step."""
    coarse = simulate(system, MotionSettings(end=end, step=step, integrator=method))
    fine = simulate(system, MotionSettings(end=end, step=step / 8))
    return coarse, np.sqrt(np.sum((coarse.values[:2] - fine.values[:2]) ** 2) / np.sum(fine.values[:2] ** 2))


@pytest.mark.parametrize(
    ("method", "step", "torque"),
    [("exponential", 5e-5, 30.0), ("exponential", 2.5e-5, 300.0), ("trapezoidal", 2e-5, 30.0)],
)
def test_the_estimate_is_true_within_a_factor_of_two(method, step, torque):
    coarse, error = true_error(machine(torque=torque), method, step, 0.1)
    assert error / 2 < coarse.step_error < 2 * error


def test_an_independent_integrator_is_measured_as_well():
    coarse, error = true_error(machine(), "generalised-alpha", 2e-5, 0.03)
    assert error / 3 < coarse.step_error < 3 * error


@pytest.mark.parametrize("method", ["exponential", "trapezoidal", "generalised-alpha"])
def test_what_follows_an_integrator_leaves_it_as_it_was(method):
    system, step = machine(), 2e-5
    alone, followed = make_integrator(method, system, step), make_integrator(method, system, step)
    for integrator in (alone, followed):
        integrator.start(equilibrium(system))
    first, second = (RAMP.motion(n, 40, step) for n in (0, 40))
    for integrator in (alone, followed):
        integrator.advance(*first)
    finer, neighbour = followed.halved(), followed.branch(1e-6 * np.ones(followed.displacement.shape[1]))
    finer_block = finer.advance(*RAMP.motion(80, 80, step / 2))
    block = followed.advance(*second)
    neighbour.advance(*second, like=block)
    np.testing.assert_array_equal(alone.advance(*second).states, block.states)
    assert len(finer_block.whole) == 80
    np.testing.assert_allclose(
        finer.displacement @ finer_block.states[-1], followed.displacement @ block.states[-1], rtol=0.05, atol=1e-8
    )


def simulated(capsys, folder, settings):
    """What `gearcase simulate minimal` writes to the terminal, and the attributes of its response."""
    import xarray

    texts = [f"--set={key}={json.dumps(value) if value != {} else '{}'}" for key, value in settings.items()]
    assert main(["simulate", "minimal", "--quiet", f"--out={folder}", *texts]) == 0
    with xarray.open_dataset(folder / "response.nc", engine="h5netcdf") as data:
        return capsys.readouterr(), dict(data.attrs)


def of_the_motion(caplog):
    """Warnings, without that of the scene on its light load."""
    said = [record.message for record in caplog.records if record.levelname == "WARNING"]
    return [message for message in said if not message.startswith("stages.1: the line load of ")]


def test_a_coarse_step_is_said_with_the_step_that_cures_it(tmp_path, capsys, caplog):
    """Built and from the cache, on the terminal and in the attributes; the cure works."""
    coarse = COARSE | {"simulation.step_us": 20.0}
    for number in range(2):
        _, attributes = simulated(capsys, tmp_path / f"coarse {number}", coarse)
        (sentence,) = json.loads(attributes["warnings"]).values()
        assert of_the_motion(caplog) == [sentence]
        caplog.clear()
    assert attributes["step_error"] > 0.05
    assert 'simulation.integrator = "exponential"' in sentence
    (step,) = re.findall(r"simulation\.step_us = ([0-9.]+)", sentence)
    _, cured = simulated(capsys, tmp_path / "cured", COARSE | {"simulation.step_us": float(step)})
    assert 0.01 < cured["step_error"] <= 0.06


def test_a_sound_run_says_nothing(tmp_path, capsys, caplog):
    printed, attributes = simulated(capsys, tmp_path / "sound", {"simulation.end_s": 0.3, "diagnosis.windows_s": {}})
    assert attributes["warnings"] == "{}"
    assert printed.err == ""
    assert of_the_motion(caplog) == []


def test_the_report_says_it_before_all_else(tmp_path):
    first = screen_parts(sentences=["A tooth is missing."])
    contents = {"title": "A machine", "cautions": ("The time step is too long.",), "first": first}
    text = body_of(**contents)
    assert text.index("Warning: The time step is too long.") < text.index("A tooth is missing.")


def test_several_motions_say_a_thing_once():
    every = [{"step": "Too long."}, {"step": "Too long too."}, {}]
    assert gathered(every) == ("Too long. (2 of 3 motions)",)
    assert gathered(every[:1]) == ("Too long.",)


def test_the_step_named_goes_whole_times_into_the_sample():
    system = machine()
    coarse = simulate(system, MotionSettings(end=0.05, step=2e-5, integrator="trapezoidal"))
    for error in (0.051, 0.16, 0.28, 1.43, 5.39):
        object.__setattr__(coarse, "step_error", error)
        (step,) = re.findall(r"step_us = ([0-9.]+)", motion_warnings(coarse)["step"])
        every = np.ceil(100.0 / float(step) - 1e-9)
        assert error * ((100.0 / every) / 20.0) ** 2 <= 0.05
        assert 100.0 / every == pytest.approx(float(step), rel=0.01)
