"""Detectability: shares are those of known distributions, no machine serves twice, channels rank by what they show."""

import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pytest
from datasets import make_dataset
from scipy.stats import norm
from serial_executor import InOrder

from pipelines.cli.main import main
from pipelines.datasets.campaign_scenes import sampled_scenes, scene_of
from pipelines.datasets.feature_tables import dataset_rows, stored_table
from pipelines.diagnosis.deviation_statistics import LEAST_SPREAD, limit, moderated
from pipelines.diagnosis.judge import judge
from pipelines.diagnosis.verdict import ALARM
from pipelines.diagnosis.verdict_words import sentences
from pipelines.io.errors import InputError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.scene.load_scene import load_scene
from pipelines.signals.features.feature_table import WHOLE, FeatureTable
from pipelines.signals.orders.kinematics import Gear, Kinematics, Shaft
from pipelines.studies.detect.channel_detectability import channels
from pipelines.studies.detect.detectability_output import headline, words
from pipelines.studies.detect.detection_axis import Over, parse_over
from pipelines.studies.detect.detection_campaign import DAMAGED, HEALTHY, Design, detection_plan
from pipelines.studies.detect.probability import Machines, Share, detection

KINEMATICS = Kinematics(
    shafts=(Shaft(name="shaft_1", ratio=1.0), Shaft(name="shaft_2", ratio=20 / 55)),
    gears=(
        Gear(name="stage 1 pinion", shaft="shaft_1", stage=1, teeth=20),
        Gear(name="stage 1 wheel", shaft="shaft_2", stage=1, teeth=55),
    ),
)
COMPONENTS = (WHOLE, "stage 1 pinion", "stage 1 wheel")


def table(levels, tooth=0):
    """A recording with one feature per component; levels (channel, component) in dB."""
    levels = np.atleast_2d(levels)
    return FeatureTable(
        sensor=tuple(f"sensor_{number}" for number in range(1, len(levels) + 1)),
        axis=("z",) * len(levels),
        component=COMPONENTS,
        feature=("rms", "difference_rms", "difference_rms"),
        value=10 ** (levels / 20),
        retained=np.zeros_like(levels),
        of_average=np.ones_like(levels),
        repeating=np.ones_like(levels),
        conditional=("",) * len(COMPONENTS),
        gear=COMPONENTS[1:],
        tooth=np.array([0, tooth]),
        window=("steady",),
        band_low=np.array([100.0]),
        band_high=np.array([1000.0]),
        speed=np.array([10.0]),
        left_out=(),
    )


def drawn(count, rises, seed, tooth=0):
    """Recordings whose levels (channel, component) are normal about their rises, standard deviation 1 dB."""
    noise = np.random.default_rng(seed).standard_normal((count, *np.atleast_2d(rises).shape))
    return [table(rises + one, tooth) for one in noise]


def test_a_baseline_of_many_loads_finds_damage_that_its_scatter_would_hide():
    speeds, noise = np.linspace(29.6, 29.8, 11), 0.3 * np.random.default_rng(4).standard_normal((11, 1, 3))
    levels = 50.0 * (speeds - 29.7)[:, None, None] + noise  # 10 dB from the lowest to the highest load
    one = [table(level).replaced(speed=[speed]) for level, speed in zip(levels, speeds, strict=True)]
    damaged, healthy = table(levels[5] + [[0.0, 0.0, 4.0]]).replaced(speed=[speeds[5]]), one[:5] + one[6:]
    found = judge(damaged, healthy, KINEMATICS)
    assert found.damaged
    assert found.first.component == "stage 1 wheel"
    assert "depend on the speed" in " ".join(sentences(found))
    alike = judge(damaged.replaced(speed=[29.7]), [other.replaced(speed=[29.7]) for other in healthy], KINEMATICS)
    assert not alike.damaged
    assert "depend on the speed" not in " ".join(sentences(alike))


def machines(rises, damage=("stage 1 wheel", 7), tooth=7, damaged=150, healthy=150, seed=0):
    """Machines whose damaged ones rise so far (channel, component)."""
    rises = np.atleast_2d(np.asarray(rises, dtype=float))
    return Machines(
        kinematics=KINEMATICS,
        baseline=drawn(8, 0.0 * rises, seed=[seed, 1]),
        healthy=drawn(healthy, 0.0 * rises, seed=[seed, 2]),
        damaged=[(one, [damage]) for one in drawn(damaged, rises, seed=[seed, 3], tooth=tooth)],
    )


def alarm_probability(given, rises):
    """That one evidence of two exceeds its limit over the 8 healthy ones; levels are normal, spread 1 dB."""
    healthy = np.array([one.channel_levels for one in given.baseline])
    spread, _ = moderated(healthy, given.baseline[0].feature, LEAST_SPREAD)
    centred = ((healthy - healthy.mean(axis=0)) / spread)[:, :, 1:]
    together, prior = moderated(centred, ["difference_rms"] * 2, 1.0)
    bound = limit(ALARM / 2, 8, prior) * np.sqrt(1 + 1 / 8) * (together * spread[:, 1:])[0]
    return 1.0 - np.prod(norm.cdf(healthy.mean(axis=0)[0, 1:] + bound - rises[1:]))


# the slow ones: the integral of 6.0 at other places
@pytest.mark.parametrize(
    "rise", [pytest.param(4.0, marks=pytest.mark.slow), 6.0, pytest.param(8.0, marks=pytest.mark.slow)]
)
def test_the_probability_of_detection_is_the_normal_integral_beyond_the_limit_of_the_baseline(rise):
    rises = np.array([0.0, 0.0, rise])
    given = machines(rises)
    found = detection(given)
    low, high = found.detected.interval
    assert low < alarm_probability(given, rises) < high
    low, high = found.false_alarms.interval
    assert low <= alarm_probability(given, 0.0 * rises) < high


def test_a_baseline_that_lies_close_together_gives_false_alarms_and_others_do_not():
    given = machines([0.0, 0.0, 0.0], damaged=1)
    middle = [table(0.02 * one.channel_levels) for one in given.baseline]
    found = detection(dataclasses.replace(given, baseline=middle))
    assert found.false_alarms.value > 0.02
    assert found.other_baselines.value < 0.02


def test_above_n_healthy_machines_is_a_healthy_one_once_in_n_plus_1():
    found = [detection(machines([0.0, 0.0, 0.0], damaged=1, healthy=9, seed=seed)) for seed in range(60)]
    low, high = Share(count=sum(one.above_healthy.count for one in found), trials=60).interval
    assert low < 0.1 < high
    assert high - low < 0.2


def test_the_damaged_shaft_ranks_first_where_it_alone_rises_and_not_where_another_does():
    assert detection(machines([0.0, 0.0, 12.0], damaged=20)).shaft_first.value == 1.0
    assert detection(machines([0.0, 12.0, 0.0], damaged=20)).shaft_first.value == 0.0


@pytest.mark.parametrize(("found", "near"), [(54, True), (0, True), (1, True), (53, False), (2, False)])
def test_a_tooth_is_found_within_one_around_the_gear(found, near):
    share = detection(machines([0.0, 0.0, 9.0], ("stage 1 wheel", 0), tooth=found, damaged=4)).tooth_found
    assert share == Share(count=4 * near, trials=4)


def test_damage_without_a_tooth_has_no_share_of_teeth():
    assert detection(machines([0.0, 0.0, 9.0], ("shaft_2", None), damaged=4)).tooth_found is None


def test_channels_rank_by_the_rise_of_the_damaged_component_in_healthy_standard_deviations():
    rises = np.array([[0, 0, 2], [0, 0, 8], [30, 30, 0]])  # the third shows much, but not of the wheel
    best, middle, last = channels([machines(rises, damaged=150, healthy=150)])
    assert [one.sensor for one in (best, middle, last)] == ["sensor_2", "sensor_1", "sensor_3"]
    assert best.index == pytest.approx(8.0, abs=0.5)
    assert middle.index == pytest.approx(2.0, abs=0.3)
    assert last.index == pytest.approx(0.0, abs=0.3)
    assert best.component == "stage 1 wheel"
    assert best.detected.value > middle.detected.value


def test_a_share_is_said_with_its_interval():
    assert words(Share(count=0, trials=300)) == "0 of 300 (0 to 1.2 %)"
    assert words(Share(count=40, trials=40)) == "40 of 40 (91 to 100 %)"
    assert words(Share(count=0, trials=0)) == "0 of 0 (0 to 100 %)"


def test_the_headline_gives_count_and_interval_of_what_is_detected():
    points = [
        SimpleNamespace(noise=0.01, values={"depth_mm": depth}, detection=SimpleNamespace(detected=share))
        for depth, share in ((1, Share(count=1, trials=4)), (5, Share(count=4, trials=4)))
    ]
    said = headline(SimpleNamespace(noises=(0.01,), points=points))
    assert said.endswith("90 % of the simulated machines or more are detected at depth_mm 5: 4 of 4 (40 to 100 %).")


def test_ranges_are_exact_and_hold_their_end():
    assert parse_over("faults.1.depth_mm=0.2:2:0.2").values == tuple(n / 5 for n in range(1, 11))
    assert parse_over("stages.1.pinion_teeth=19:25:3").values == (19, 22, 25)
    assert parse_over("load.torque_N_m=100:50:-25").values == (100, 75, 50)
    assert parse_over("load.torque_N_m=50.0, 100.0").values == (50.0, 100.0)
    assert parse_over("stages.1.mesh.model=iso,plane").values == ("iso", "plane")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("faults.1.depth_mm", "is not a key"),
        ("=1,2", "is not a key"),
        ("a..b=1", "is not a key"),
        ("a=1:2:0", "must be numbers"),
        ("a=1:2:x", "must be numbers"),
        ("a=nan:2:1", "must be numbers"),
        ("a=0:1:inf", "must be numbers"),
        ("a=1:2:-1", "leads away"),
        ("a=0:1:0.001", "more than 100"),
        ("a=1,,2", "1 to 100 values"),
        ("a=1,1", "given twice"),
    ],
)
def test_values_that_are_none_are_refused_in_a_sentence(text, why):
    with pytest.raises(InputError, match=why):
        parse_over(text)


def plan_of(settings, **design):
    loaded = load_scene("bench", settings)
    return detection_plan(loaded, checked_machine(loaded.scene, "bench"), Design(**design))


def test_no_pair_of_gears_serves_twice_and_the_damaged_tooth_moves_on():
    over = (Over(key="faults.1.depth_mm", values=(1.0, 2.0)),)
    plan = plan_of({"deviations.seed": 101}, over=over, baseline=5, healthy=3, damaged=2)
    sampled = sampled_scenes(plan)
    seeds = {state: {sample.values["specimen"] for sample in sampled if sample.values["state"] == state} for state in
             (HEALTHY, DAMAGED)}  # fmt: skip
    assert seeds == {HEALTHY: set(range(1, 9)), DAMAGED: {9, 10}}
    assert len(sampled) == 8 + 2 * 2
    scenes = [scene_of(plan, sample.values).scene for sample in sampled]
    assert [scene.deviations.seed for scene in scenes] == [100 + sample.values["specimen"] for sample in sampled]
    faults = [scene.faults[0] for scene in scenes if scene.faults]
    assert [(fault.depth_mm, fault.tooth) for fault in faults] == [(1.0, 19), (1.0, 20), (2.0, 19), (2.0, 20)]


def test_a_load_is_that_of_healthy_and_damaged_machines():
    over = (Over(key="load.torque_N_m", values=(50.0, 100.0)),)
    plan = plan_of({}, over=over, baseline=5, healthy=3, damaged=2)
    loads = [scene_of(plan, sample.values).scene.load.torque_N_m for sample in sampled_scenes(plan)]
    assert loads.count(50.0) == loads.count(100.0) == 5 + 3 + 2


def test_shaft_faults_are_gone_from_healthy_machines():
    unbalance = {"model": "unbalance", "shaft": 1, "position_mm": 0.0, "unbalance_g_mm": 100.0}
    over = (Over(key="forces.1.unbalance_g_mm", values=(50.0, 100.0)),)
    plan = plan_of({"faults": [], "forces": [unbalance]}, over=over, baseline=5, healthy=1, damaged=1)
    forces = [
        [force.unbalance_g_mm for force in scene_of(plan, sample.values).scene.forces]
        for sample in sampled_scenes(plan)
    ]
    assert forces == 6 * [[]] + [[50.0], [100.0]]


@pytest.mark.parametrize(
    ("settings", "design", "why"),
    [
        ({"faults": []}, {}, "no fault"),
        ({"deviations.enabled": False}, {}, "all healthy machines equal"),
        ({}, {"baseline": 4}, "need 5 healthy machines or more"),
        ({}, {"over": (Over(key="deviations.seed", values=(1,)),)}, "differs between all machines"),
        ({}, {"over": 2 * (Over(key="load.torque_N_m", values=(1.0,)),)}, "given twice"),
    ],
)
def test_a_study_that_would_show_nothing_is_refused(settings, design, why):
    with pytest.raises(InputError, match=why):
        plan_of(settings, **design)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A data set whose run 2 alone is there."""
    return make_dataset(tmp_path_factory.mktemp("detect") / "known", left_out=(0, 1, 3, 4, 5, 6, 7))


def rows_of(folder, windows, noise, made):
    place = f"feature_tables/{noise:g}"
    found = dataset_rows(
        folder, windows, noise, InOrder(), lambda done, left: made.append(left), rows=place, complete=False
    )
    return next(found)


def test_features_of_runs_are_made_once_per_noise(folder):
    made = []
    clean, again, noisy = (stored_table(rows_of(folder, {}, noise, made)["table"]) for noise in (0.0, 0.0, 0.3))
    assert made == [1, 1]
    assert clean.lines == again.lines == noisy.lines
    assert np.array_equal(clean.value, again.value)
    rms = clean.feature.index("rms")
    assert noisy.value[0, rms] ** 2 == pytest.approx(clean.value[0, rms] ** 2 + 0.3**2, rel=0.02)


def test_runs_without_features_say_why(folder):
    row = rows_of(folder, {"short": (0.1, 0.12)}, 0.0, [])
    assert row["table"] is None
    assert "no shaft makes" in row["failure"]


@pytest.mark.slow
def test_a_missing_tooth_is_found_on_machines_that_the_baseline_does_not_know(tmp_path, capsys):
    fault = '--set=faults=[{kind="missing-tooth",stage=1,gear="wheel",tooth=3}]'
    asked = ["detect", "minimal", fault, "--seeds", "3", "--baseline", "6", "--healthy", "6", "--noise", "0.01", "0.3"]
    asked += ["--over", "load.container_kg=80,114", "--out", str(tmp_path / "found"), "-q"]
    assert main(asked) == 0
    found = json.loads((tmp_path / "found" / "detectability.json").read_text())
    assert len(found["points"]) == 4
    for point in found["points"]:
        assert point["detected"]["count"] == point["shaft_first"]["count"] == point["tooth_found"]["count"] == 3
        assert point["false_alarms"]["count"] == 0
    assert {(one["sensor"], one["axis"]) for one in found["channels"]} == {("sensor_3", axis) for axis in "xyz"}
    assert (tmp_path / "found" / "detectability.png").stat().st_size > 10_000
    assert "3 of 3" in capsys.readouterr().out
    assert main(asked) == 0
    assert "0 simulated now" in capsys.readouterr().out
