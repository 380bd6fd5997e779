"""Error bars of lines: casings that are changed in a known way change the lines as exact solutions and runs say."""

import dataclasses
import json
import math

import numpy as np
import pytest

from benchmarks.error_bars import drawn_body
from fem.casing.uncertainty.casing_samples import (
    near_modes,
    nominal_samples,
    sampled_damping,
    sampled_frequencies,
    single_errors,
)
from fem.casing.uncertainty.frequency_errors import FrequencyErrors, frequency_errors
from fem.casing.uncertainty.frequency_limits import FrequencyLimits
from fem.casing.uncertainty.modal_form import ModalForm, modal_form
from mbd.system.blocked_forces import MachineAtSeats
from pipelines.diagnosis.control_diagnosis import diagnose
from pipelines.diagnosis.uncertainty.bar_records import Band, LineBar, LineBars
from pipelines.diagnosis.uncertainty.bar_words import bars_words
from pipelines.diagnosis.uncertainty.casing_changes import CasingPath
from pipelines.diagnosis.uncertainty.sampled_bars import casing_errors, line_bars
from pipelines.engine.run_graph import Work
from pipelines.io.json_text import json_text
from pipelines.machine.system_assembly import assemble_machine, assemble_system
from pipelines.scene.load_scene import load_scene
from pipelines.signals.response import make_response
from pipelines.steps.motion import moved
from pipelines.steps.run_plan import plan_run
from pipelines.studies.trade.line_uncertainty import line_uncertainty, uncertainty_sentence

MASS, STIFFNESS, RATIO = 3.0, 4e6, 0.02  # of a casing that moves along one axis
BEARING, ROTOR = 2e7, 1.5  # N/m of the bearing, kg of the rotor in it


def one_mode(squares=STIFFNESS / MASS):
    shapes = np.full((1, 1), 1.0 / math.sqrt(MASS))
    return ModalForm(squares=np.array([squares]), ratios=np.array([RATIO]), shapes=shapes)


def rotor():
    """A rotor on its bearing, a force on it taken as that of a flank."""
    one = np.ones((1, 1))
    nothing = 0.0 * one
    return MachineAtSeats(
        seats=np.array([0]),
        own=(BEARING * one, nothing, nothing),
        across=(-BEARING * one, nothing, nothing),
        back=(-BEARING * one, nothing, nothing),
        rest=(BEARING * one, nothing, ROTOR * one),
        flanks=one,
    )


def exact(frequency, squares):
    """Force of the bearing on the casing, and acceleration of the casing, per newton on the rotor."""
    w, k = 2 * math.pi * frequency, MASS * squares
    casing = k + 2j * RATIO * math.sqrt(squares) * w * MASS - w * w * MASS
    matrix = np.array([[casing + BEARING, -BEARING], [-BEARING, BEARING - w * w * ROTOR]])
    moved_ = np.linalg.solve(matrix, [0.0, 1.0])
    return BEARING * (moved_[1] - moved_[0]), -w * w * moved_[0]


@pytest.mark.parametrize("frequency", [60.0, 150.0, 175.0, 420.0])
@pytest.mark.parametrize("known", [True, False])
def test_a_casing_of_one_mode_that_is_stiffened_changes_the_line_as_the_exact_solution(frequency, known):
    form, error = one_mode(), 0.03
    path = CasingPath(form=form, near=1, machine=rotor(), sensor=np.ones((1, 1)), forced=np.ones((1, 1)))
    force, acceleration = exact(frequency, form.squares[0])
    stiffer = form.squares[0] * (1 + error) ** 2
    draws = dataclasses.replace(nominal_samples(form, 1), squares=np.array([[stiffer]]))
    before, after = path.accelerations(frequency, np.array([force]), draws)
    assert before[0] == pytest.approx(acceleration, rel=1e-10)
    assert after[0, 0] == pytest.approx(exact(frequency, stiffer)[1], rel=1e-10)


def two_seats(seed=3):
    """A casing with two seats and five modes, and a machine between them; K, C, M of everything."""
    random = np.random.default_rng(seed)
    root = random.standard_normal((5, 5))
    shapes = np.linalg.qr(root)[0]
    form = ModalForm(squares=np.array([1.0, 1.1, 3.0, 5.0, 80.0]) * 1e6, ratios=np.full(5, 0.01), shapes=shapes)
    springs = random.uniform(1e6, 3e6, 2)
    own = np.diag(springs)
    rest = np.diag([springs[0] + 5e5, springs[1] + 5e5]) - 5e5 * (1 - np.eye(2))
    nothing, across = np.zeros((2, 2)), -np.diag(springs)
    machine = MachineAtSeats(
        seats=np.array([0, 1]),
        own=(own, nothing, nothing),
        across=(across, nothing, nothing),
        back=(across, nothing, nothing),
        rest=(rest, nothing, np.diag([0.7, 1.2])),
        flanks=np.array([[1.0], [-0.4]]),
    )
    return form, machine


def whole_response(form, machine, frequency):
    """Forces (seat,) on the casing and acceleration of its last coordinate per newton on the flank."""
    w = 2 * math.pi * frequency
    modal = form.squares - w * w + 2j * w * form.ratios * np.sqrt(form.squares)
    casing = (form.shapes * modal) @ form.shapes.T
    k, m = machine.rest[0], machine.rest[2]
    matrix = np.zeros((7, 7), dtype=complex)
    matrix[:5, :5] = casing
    matrix[:2, :2] += machine.own[0]
    matrix[:2, 5:], matrix[5:, :2] = machine.across[0], machine.back[0]
    matrix[5:, 5:] = k - w * w * m
    u = np.linalg.solve(matrix, np.r_[np.zeros(5), machine.flanks[:, 0]])
    return -(machine.own[0] @ u[:2] + machine.across[0] @ u[5:]), -w * w * u[4]


@pytest.mark.parametrize("recorded", [(0, 1), (0,)])
def test_forces_that_are_not_recorded_follow_from_the_flanks(recorded):
    """The second seat's force is left out: what the flank does to the first one gives it."""
    form, machine = two_seats()
    forced = np.eye(2, 5)[list(recorded)]
    path = CasingPath(form=form, near=5, machine=machine, sensor=np.eye(5)[4:], forced=forced)
    draws = sampled_frequencies(form, 5, errors_of(5, 0.02), 6, 1)
    for frequency in (90.0, 160.0, 165.0, 300.0):
        forces, acceleration = whole_response(form, machine, frequency)
        before, after = path.accelerations(frequency, forces[list(recorded)], draws)
        assert before[0] == pytest.approx(acceleration, rel=1e-8)
        for number in range(len(draws)):
            turned = dataclasses.replace(form, squares=draws.squares[number], shapes=form.shapes @ draws.turns[number])
            assert after[number, 0] == pytest.approx(whole_response(turned, machine, frequency)[1], rel=1e-8)


def errors_of(count, spread, mean=0.0, rest=0.0):
    same = np.full(count, 1.0)
    return FrequencyErrors(first=0, means=mean * same, spreads=spread * same, rest=rest, rest_spread=spread)


def test_the_flexibility_of_modes_above_is_taken_to_the_first_order():
    form, machine = two_seats()
    path = CasingPath(form=form, near=4, machine=machine, sensor=np.eye(5)[4:], forced=np.eye(2, 5))
    stiffer = dataclasses.replace(nominal_samples(form, 4), stiffening=np.array([0.01]))
    forces, _ = whole_response(form, machine, 150.0)
    _, after = path.accelerations(150.0, forces, stiffer)
    wanted = dataclasses.replace(form, squares=form.squares * np.array([1, 1, 1, 1, 1.01]))
    acceleration = whole_response(wanted, machine, 150.0)[1]
    assert after[0, 0] == pytest.approx(acceleration, rel=1e-4)


def form_of(frequencies):
    squares = (2 * math.pi * np.array(frequencies)) ** 2
    return ModalForm(squares=squares, ratios=np.full(len(squares), 0.01), shapes=np.eye(len(squares)))


def test_modes_far_apart_keep_the_mean_and_the_spread_of_their_errors():
    form = form_of([100.0, 150.0, 260.0])
    draws = sampled_frequencies(form, 3, errors_of(3, 0.01, mean=0.02), 4000, 1)
    change = np.sqrt(draws.squares / form.squares) - 1
    assert change.mean(axis=0) == pytest.approx(0.02, abs=1e-3)
    assert change.std(axis=0) == pytest.approx(0.01, rel=0.05)
    assert draws.turns @ draws.turns.transpose(0, 2, 1) == pytest.approx(np.tile(np.eye(3), (4000, 1, 1)), abs=1e-12)
    assert abs(draws.turns[:, 0, 1]).mean() < 0.05


def test_modes_of_one_frequency_turn_by_any_angle():
    """Which two combinations are called the modes must not matter: every direction is as likely as any other."""
    draws = sampled_frequencies(form_of([100.0, 100.0]), 2, errors_of(2, 0.01), 4000, 1)
    angle = np.arctan2(draws.turns[:, 1, 0], draws.turns[:, 0, 0]) % math.pi
    assert np.histogram(angle, bins=4, range=(0, math.pi))[0] == pytest.approx(1000, rel=0.12)


def test_errors_of_nothing_change_nothing():
    form = form_of([100.0, 101.0, 300.0])
    for draws in (sampled_frequencies(form, 2, errors_of(2, 0.0), 5, 1), single_errors(form, 2, errors_of(2, 0.0))):
        assert draws.squares == pytest.approx(np.tile(form.squares[:2], (len(draws), 1)), rel=1e-12)
        assert not draws.stiffening.any()
    assert sampled_damping(form, 2, 1e-12, 5, 1).damping == pytest.approx(1.0, abs=1e-10)


def test_five_to_95_per_cent_of_the_damping_lie_within_its_spread():
    factors = sampled_damping(form_of([100.0]), 1, 0.3, 4000, 1).damping
    assert np.percentile(factors, (5, 95)) == pytest.approx((1 / 1.3, 1.3), rel=0.02)


def test_errors_are_counted_from_the_corrected_frequency():
    limits = FrequencyLimits(
        frequencies=np.array([100.0, 200.0]),
        order=2.0,
        orders=np.array([2.0, 2.0]),
        limits=np.array([99.0, 196.0]),
        bands=np.array([1.0, 2.0]),
        fixed_bands=np.zeros(2),
        correction=0.02,
    )
    found = frequency_errors(limits)
    assert found.means == pytest.approx((99.0 / 98.0 - 1, 0.0))
    assert found.spreads == pytest.approx((0.5 / 98.0, 1.0 / 196.0))
    assert found.rest == pytest.approx(0.01)


SHORT = {
    "simulation.end_s": 1.0,
    "diagnosis": {
        "gear": "pinion",
        "axis": "resultant",
        "noise_m_s2": 0.0,
        "windows_s": {"lifting": [0.3, 1.0]},
        "envelope_band_Hz": [280.0, 370.0],
    },
}


@pytest.fixture(scope="module")
def diagnosed():
    """The scene `minimal`, whose pitch deviations make sidebands: its plant, system, run and diagnosis."""
    plan = plan_run(load_scene("minimal", SHORT), with_control=False, both_loads=False)
    model = plan.machine
    outcome = Work(processes=1).build(plan.graph, [*model.law_names, "casing", "simulate"])
    machine = assemble_machine(model.parts, [outcome.value(name) for name in model.law_names])
    system = assemble_system(machine, outcome.value("casing"), model.recorded, model.motion.band)
    run = make_response(outcome.value("simulate"), model.labels)
    return model, system, run, diagnose(run, run, model.diagnosis)


def test_bars_hold_the_lines_of_simulated_casings(diagnosed, monkeypatch):
    """One casing with modes 1.5 % higher is drawn and simulated: spectrum and envelope change as predicted."""
    model, system, run, found = diagnosed
    body = system.layout.casing
    form = modal_form(body)
    near = near_modes(form, max(found.band[1], found.settings.highest_line))

    def one_draw(*_):
        return dataclasses.replace(nominal_samples(form, near), squares=form.squares[None, :near] * 1.015**2)

    monkeypatch.setattr("pipelines.diagnosis.uncertainty.sampled_bars.SAMPLES", 1)
    monkeypatch.setattr("pipelines.diagnosis.uncertainty.sampled_bars.sampled_frequencies", one_draw)
    quiet = run.assign_attrs(step_error=0.0)
    bars = line_bars(quiet, found, system, errors_of(near, 0.0), 0.3, "").bars
    other = drawn_body(body, form, one_draw(), 0)
    again = moved(assemble_system(system.machine, other, model.recorded, model.motion.band), model.motion)
    changed = diagnose(make_response(again, model.labels), run, model.diagnosis).lines
    level = {(changed.kind[i], changed.label[i]): changed.faulty[i] for i in range(len(changed))}
    assert {bar.kind for bar in bars} >= {"envelope", "sideband", "mesh"}
    simulated = [20 * math.log10(level[bar.kind, bar.label] / bar.level) for bar in bars]
    predicted = [bar.numerical.low for bar in bars]
    assert max(map(abs, simulated)) > 0.5
    assert predicted == pytest.approx(simulated, rel=0.12, abs=0.1)  # a mode at 272 Hz is still ringing


def test_without_errors_of_the_mesh_the_inputs_are_shown_alone(diagnosed):
    model, system, run, found = diagnosed
    bars = line_bars(run, found, system, casing_errors(None, ()), model.monitored.damping_spread, model.casing.remedy)
    assert bars.bars
    assert all(bar.numerical is None and bar.inputs.low < bar.inputs.high for bar in bars.bars)
    words = bars_words(bars)
    assert 'set casing.model = "craig-bampton"' in words
    assert "numerical uncertainty dB" not in words
    assert "uncertain damping dB" in words
    assert json.loads(json_text(bars))["bars"][0]["numerical"] is None


def test_a_trade_says_how_well_lines_are_known_before_it_compares_them():
    def bar(half, *, detected=True):
        ends = Band(low=-half, high=half, source="mesh", share=1.0)
        return LineBar(
            window="lifting", kind="envelope", label="f_r", frequency=5.0, level=1.0, detected=detected,
            numerical=ends, inputs=ends,
        )  # fmt: skip

    told = uncertainty_sentence(LineBars(bars=(bar(0.2), bar(0.6), bar(0.4), bar(9.0, detected=False)), notes=()))
    assert "levels of the 3 detected lines of the fault uncertain by 0.4 dB in the median and 0.6 dB at most" in told
    missing = {"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 0}
    scene = load_scene("minimal", {"faults": [missing], "control": "without-faults", "diagnosis.gear": "pinion"})
    assert "Set casing.extrapolated = true" in line_uncertainty(scene, Work())
    assert line_uncertainty(load_scene("minimal"), Work()) == ""
