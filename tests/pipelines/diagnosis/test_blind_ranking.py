"""The blind verdict: whatever is damaged of a machine ranks first, and healthy machines raise no alarm."""

import dataclasses
import re

import numpy as np
import pytest
from turning import MACHINE, recording

from pipelines.diagnosis.baseline_checks import BaselineError
from pipelines.diagnosis.deviation_statistics import TAILS, clopper_pearson
from pipelines.diagnosis.evidence import GroupEvidence, HealthyReference
from pipelines.diagnosis.judge import alike, damage_p, judge
from pipelines.diagnosis.known_damage import Case, Damage, any_found, cases_grid, found
from pipelines.diagnosis.known_damage import sentences as case_sentences
from pipelines.diagnosis.simulated_features import FeatureSettings, run_features, window_features
from pipelines.diagnosis.verdict import ALARM, DIFFERENT
from pipelines.diagnosis.verdict_words import answer, headline, ranking_grid, sentences
from pipelines.signals.features.feature_table import WHOLE, _without, with_common_components
from pipelines.signals.features.recording_features import FeatureError, recording_features
from pipelines.signals.orders.kinematics import Bearing, Gear, Shaft
from pipelines.signals.orders.rotation import Rotation

SETTINGS = FeatureSettings(kinematics=MACHINE, windows={})


LOCAL = {"fault": "stage 1 pinion", "tooth": 7}
IN_ONE = FeatureSettings(kinematics=MACHINE, windows={"whole": (0.0, 6.0)})


def table(seed, settings=SETTINGS, **fault):
    return run_features(recording(seed, **fault), settings)


@pytest.fixture(scope="module")
def healthy():
    return [table(seed) for seed in range(8)]


@pytest.mark.parametrize("component", ["stage 1 pinion", "stage 1 wheel", "stage 2 pinion", "stage 2 wheel"])
def test_a_damaged_tooth_is_found_on_its_shaft_and_in_its_place(healthy, component):
    verdict = judge(table(100, fault=component, tooth=5), healthy, MACHINE)
    assert verdict.damaged
    assert component in (verdict.first.component, *verdict.first.alike)
    own = next(one for one in verdict.findings if one.component == component)
    assert abs(own.tooth - 5) <= 1
    damage, other = Damage(component=component, tooth=5, words="tooth"), Damage(component="x", tooth=None, words="x")
    case = Case(load="torque", deviations="off", window="whole", verdict=verdict)
    ranked = found(case, damage, [damage])
    assert (ranked is None) == (verdict.first.component != component)
    assert found(case, other, [other]) is None


@pytest.mark.parametrize(("fault", "component"), [("bearing_1", "bearing_1 BPFO"), ("shaft_2", "shaft_2")])
def test_a_spall_and_an_unbalanced_shaft_rank_first(healthy, fault, component):
    verdict = judge(table(101, fault=fault), healthy, MACHINE)
    assert verdict.damaged
    assert verdict.first.component == component


def test_two_bearings_of_one_size_on_a_shaft_are_both_found(healthy):
    verdict = judge(table(101, fault="bearing_1"), healthy, MACHINE)
    own, twin = "bearing_1 BPFO", "bearing_2 BPFO"
    first = (
        dataclasses.replace(verdict.first, component=twin, alike=(own,)),
        dataclasses.replace(verdict.first, component=own, alike=(twin,)),
    )
    both = dataclasses.replace(verdict, findings=(*first, *verdict.findings[1:]))
    case, damage = (
        Case(load="torque", deviations="off", window="up", verdict=both),
        Damage(component=own, tooth=None, words="spall"),
    )
    assert found(case, damage, [damage]).component == own
    assert f"{twin} has the same evidence." in " ".join(case_sentences([case], [damage]))


def test_other_healthy_machines_raise_no_alarm(healthy):
    assert [judge(table(seed), healthy, MACHINE).damaged for seed in range(200, 206)] == [False] * 6
    verdict = judge(table(200), healthy, MACHINE)
    assert headline(verdict).startswith("No damage")
    assert (verdict.tested, verdict.false_alarms) == (8, ())
    assert clopper_pearson(0, verdict.tested) == pytest.approx((0.0, 0.369), abs=1e-3)


def test_of_healthy_machines_whose_levels_have_the_assumed_tails_one_percent_are_called_different(healthy):
    reference = HealthyReference(healthy)
    random, weight = np.random.default_rng(0), np.ones(len(reference.groups))
    found = []
    for _ in range(1000):
        levels = random.standard_t(TAILS, (9, *reference.levels.shape[1:]))
        found.append(GroupEvidence(reference=reference, levels=levels[0], healthy=levels[1:], weight=weight))
    assert 4 <= sum(one.p_different <= DIFFERENT for one in found) <= 18
    assert sum(one.p_damaged <= ALARM for one in found) <= 4


def test_clear_impacts_of_a_bearing_rank_before_stronger_evidence_of_a_gear(healthy):
    """Impacts raise the features of gears, too. They are clear if no healthy recording has them."""
    one = table(330)
    passing = one.lines.index(("bearing_1 BPFO", "pass_order"))
    gear = [line == "stage 1 pinion" for line in one.component]
    value = np.where(gear, 10.0 * one.value, one.value)
    value[0, passing] = 10 ** (21.0 / 20)
    verdict = judge(one.replaced(value=value), healthy, MACHINE)
    assert [(found.component, found.damaged) for found in verdict.findings[:2]] == [
        ("bearing_1 BPFO", True), ("stage 1 pinion", True),
    ]  # fmt: skip
    assert "21 dB over the envelope spectrum around it (limit 20 dB)" in " ".join(sentences(verdict))
    for level, first in ((19.9, "stage 1 pinion"), (20.1, "bearing_1 BPFO")):
        value[0, passing] = 10 ** (level / 20)
        assert judge(one.replaced(value=value), healthy, MACHINE).first.component == first
    highest = max(other.value[0, passing] for other in healthy)
    lifted = [
        other.value * np.where(np.arange(len(gear)) == passing, 10 ** (15.0 / 20) / highest, 1.0) for other in healthy
    ]
    others = [other.replaced(value=more) for other, more in zip(healthy, lifted, strict=True)]
    assert judge(one.replaced(value=value), others, MACHINE).first.component == "stage 1 pinion"


def test_impacts_of_a_bearing_are_no_evidence_of_a_gear_although_they_are_in_its_average():
    """They do not repeat with a shaft, but few revolutions do not average them out. Here they are not clear."""
    short = FeatureSettings(kinematics=MACHINE, windows={"short": (0.5, 2.0)})
    few, one = [table(seed, short) for seed in range(8)], table(101, short, fault="bearing_1", depth=2.0)
    passing = np.array([feature == "pass_order" for feature in one.feature])
    value = np.where(passing, np.minimum(one.value, 10 ** (19.9 / 20)), one.value)
    verdict = judge(one.replaced(value=value), few, MACHINE)
    assert verdict.first.component == "bearing_1 BPFO"
    assert not any(found.damaged for found in verdict.findings if found.component.startswith("stage"))
    wheel = one.lines.index(("stage 1 wheel", "difference_rms"))
    increase = one.channel_levels[:, wheel] - np.mean([other.channel_levels[:, wheel] for other in few], axis=0)
    assert increase.min() > 6.0
    whole = judge(one.replaced(value=value, retained=np.zeros_like(one.value)), few, MACHINE)
    assert whole.damaged
    assert whole.first.component.startswith("stage")


@pytest.mark.parametrize("mean", [-46.0, -43.0, -40.0, -30.0])
def test_orders_of_a_shaft_that_are_noise_alone_raise_no_alarm(healthy, mean):
    """Their amplitudes have Rayleigh's distribution; the mean power is given in dB over that of the vibration."""
    random, one = np.random.default_rng(7), healthy[0]
    orders = np.isin(one.feature, ["order_1", "order_2"])
    rms = one.value[:, [one.lines.index((WHOLE, "rms"))]]

    def noisy():
        scattered = one.value * 10 ** (0.05 * random.standard_normal(one.value.shape))
        noise = rms * 10 ** (mean / 20) * np.sqrt(random.exponential(size=one.value.shape))
        return one.replaced(value=np.where(orders, noise, scattered))

    alarms = sum(damage_p(noisy(), [noisy() for _ in range(8)]) <= ALARM for _ in range(100))
    assert alarms <= 1  # the larger of line and LEAST_ORDER gave up to 10


def test_evidence_that_a_shaft_left_out_can_cause_is_not_stated_as_damage_of_another(healthy):
    """Damage of the wheel raises features of the pinion, but not the share of the vibration that repeats with it."""

    def alone(one):
        left_out = ("shaft_2 (stage 1 wheel, stage 2 pinion): too few turns",)
        others = {"shaft_1", "stage 1 pinion", WHOLE}
        return _without(one, {line for line in one.lines if line[0] not in others}, left_out)

    known = [alone(one) for one in healthy]
    own = judge(alone(table(110, fault="stage 1 pinion")), known, MACHINE)
    assert headline(own) == "Damaged: stage 1 pinion, tooth 5 (+- 1)."
    wheel = alone(table(110, fault="stage 1 wheel"))
    raised = np.where([name == "stage 1 pinion" for name in wheel.component], 10.0 * wheel.value, wheel.value)
    other = judge(wheel.replaced(value=raised, retained=np.zeros_like(raised)), known, MACHINE)
    assert headline(other).startswith("Damaged: stage 1 pinion, tooth ")
    assert headline(other).endswith(" or shaft_2 (stage 1 wheel, stage 2 pinion).")
    assert "a smaller share of the vibration repeats with stage 1 pinion than in some healthy" in sentences(other)[-1]
    assert not judge(table(110, fault="stage 1 wheel"), healthy, MACHINE).candidates


def test_a_level_that_falls_at_one_channel_is_a_difference_and_no_damage(healthy):
    one = table(300)
    lowered = one.value.copy()
    lowered[0, one.lines.index(("stage 1 wheel", "difference_rms"))] /= 10.0
    verdict = judge(one.replaced(value=lowered), healthy, MACHINE)
    assert (verdict.different, verdict.damaged) == (True, False)
    assert (verdict.changes[0].component, verdict.changes[0].sensor, verdict.changes[0].axis) == (
        "stage 1 wheel", "near", "x",
    )  # fmt: skip
    assert verdict.changes[0].increase == pytest.approx(-20.0, abs=3.0)
    assert headline(verdict).startswith("Different from the healthy recordings, but")


def test_faulty_recordings_in_a_baseline_of_ten_are_named_and_the_verdict_is_kept(healthy):
    others = [*healthy, table(301), table(302)]
    assert judge(table(303), others, MACHINE).outlying == ()
    for count in (1, 2, 3):
        faulty = [table(310 + number, fault="stage 1 wheel", tooth=number) for number in range(count)]
        baseline = [*faulty, *others[count:]]
        verdict = judge(table(320, fault="stage 1 wheel"), baseline, MACHINE)
        assert verdict.outlying == tuple(f"healthy recording {number + 1}" for number in range(count))
        assert verdict.damaged
        assert verdict.healthy == 10 - count
        assert "Left out because they differ" in " ".join(sentences(verdict))


@pytest.mark.parametrize("count", [4, 6, 7])
def test_a_faulty_recording_is_left_out_of_seven_and_named_among_six_and_fewer_ask_for_more(healthy, count):
    baseline = [table(310, fault="stage 1 wheel"), *healthy[: count - 1]]
    verdict = judge(table(320), baseline, MACHINE, [f"{number}.csv" for number in range(count)])
    assert verdict.outlying == (("0.csv",) if count == 7 else ())
    words = " ".join(sentences(verdict))
    assert ("Give 7 or more to find a damaged one among them." in words) == (count < 7)
    assert ("1 are called damaged (0.csv) and 1 different (0.csv)." in words) == (count == 6)


def test_a_recording_twice_or_in_its_own_baseline_is_refused_by_name(healthy):
    names = [f"{number}.csv" for number in range(9)]
    with pytest.raises(BaselineError, match=r"8\.csv is the same recording as 2\.csv"):
        judge(table(304), [*healthy, healthy[2]], MACHINE, names)
    with pytest.raises(BaselineError, match=r"8\.csv has the same signals as the recording to diagnose"):
        judge(table(305), [*healthy, table(305)], MACHINE, names)


def test_against_a_control_known_damage_is_found_with_its_evidence_and_tooth():
    """The control has the same deviations and noise of the same rms; an equal run is one of its samples."""
    runs = (recording(400, **fault).assign_attrs(sensor_noise_m_s2=0.02) for fault in (LOCAL, {}))
    faulty, control = (window_features(run, IN_ONE, 5)["whole"] for run in runs)
    damage = Damage(component="stage 1 pinion", tooth=7, words="missing tooth 7 of the stage 1 pinion")
    cases = [
        Case(load="torque", deviations="seed 1", window=name, verdict=judge(one, control, MACHINE, exact=True))
        for name, one in (("up", faulty[0]), ("down", control[0]))
    ]
    text = " ".join(case_sentences(cases, [damage]))
    assert text.startswith(
        "Missing tooth 7 of the stage 1 pinion: found in 1 of 2 cases. Evidence (up, torque load, deviations "
        "of seed 1): mean of 6 features at near "
    )
    assert "). The impact begins at tooth 7. The reference is" in text
    single = " ".join(case_sentences(cases[:1], [damage]))
    assert "). The impact begins at tooth 7. The reference is" in single
    alone = " ".join(case_sentences(cases[1:], [damage]))
    nearest = r"not found\. Nearest evidence of damage: .* \(down, torque load, deviations of seed 1\), .* is [+-]\d"
    assert re.search(nearest + r".*\(limit: \d.*stage 1 pinion.*\(limit: \d", alone)
    assert "`gearcase detect` finds the size" in alone
    elsewhere = " ".join(case_sentences(cases[:1], [dataclasses.replace(damage, tooth=3)]))
    assert "). The impact begins at tooth 7, not at tooth 3. The reference is" in elsewhere
    crack = dataclasses.replace(damage, tooth=3, words="cracked tooth 3 of the stage 1 pinion")
    assert "The impact begins" not in " ".join(case_sentences(cases[:1], [crack]))
    assert [row[4] for row in cases_grid(cases, [damage]).rows] == ["found", "not found"]
    assert cases[1].verdict.damaged is False
    assert any_found(cases, [damage]) is True
    assert any_found(cases[1:], [damage]) is False


def test_limits_against_a_control_follow_its_sensor_noise():
    """The more noise, the more its features scatter: two samples differ by 2 dB and more, which is no damage."""
    noisy = recording(401, noise=0.0).assign_attrs(sensor_noise_m_s2=3.0)
    *control, other = window_features(noisy, IN_ONE, 6)["whole"]
    verdict = judge(other, control, MACHINE, exact=True)
    assert max(one.evidence.increase for one in verdict.findings) > 2.0
    assert verdict.damaged is False
    assert verdict.different is False


def test_a_small_baseline_gives_an_order_and_no_p_value(healthy):
    verdict = judge(table(102, fault="stage 1 wheel"), healthy[:4], MACHINE)
    assert verdict.damaged is None
    assert all(finding.evidence.p is None for finding in verdict.findings)
    assert verdict.first.component == "stage 1 wheel"
    assert "Give 5 or more for limits" in " ".join(sentences(verdict))


def test_recordings_of_other_channels_cannot_be_compared(healthy):
    one = recording(103).sel(axis=["x"])
    with pytest.raises(BaselineError, match="1 has the channels near x, near z, the recording to diagnose has near x"):
        judge(run_features(one, SETTINGS), healthy, MACHINE)


def test_gears_whose_angle_is_not_known_are_not_examined_and_the_answer_is_no_all_clear():
    """The angle is known to 2 % of 120 turns. Only the pass orders of bearings allow for that."""
    one = recording(103)
    rotation = {"angle": 2 * np.pi * 20.0 * one.time.values, "source": "", "absolute": False}
    unsure, sure = Rotation(error=0.02, **rotation), Rotation(error=0.0, **rotation)
    own, *others = [recording_features(recording(seed), MACHINE, unsure) for seed in range(103, 110)]
    verdict = judge(own, others, MACHINE)
    names = [gear.name for gear in MACHINE.gears] + [shaft.name for shaft in MACHINE.shafts]
    assert headline(verdict) == f"Not examined: {', '.join(names)}; no other component exceeds its limit."
    assert answer(verdict) == "incomplete"
    assert {row[0] for row in ranking_grid(verdict).rows if "not examined" in row} == set(names)
    assert any_found([Case(load="", deviations="", window="", verdict=verdict)], []) is None
    assert all("record a tachometer, or set speed_rpm in place of speed if " in words for words in verdict.left_out)
    known, _ = with_common_components([recording_features(one, MACHINE, sure), own])
    assert [words.partition(":")[0] for words in known.left_out] == [w.partition(":")[0] for w in verdict.left_out]
    assert all("in another recording its angle is known to" in words for words in known.left_out)


def test_recordings_without_features_of_any_component_are_refused_with_the_reason():
    one = recording(103)
    unsure = Rotation(angle=2 * np.pi * 20.0 * one.time.values, source="", error=0.02, absolute=False)
    bare = dataclasses.replace(MACHINE, bearings=())
    tables = [recording_features(recording(seed), bare, unsure) for seed in range(103, 109)]
    with pytest.raises(
        BaselineError, match=r"no shaft, gear or bearing .* averages need 0\.25: record a .*set speed_rpm .*Set another"
    ):
        judge(tables[0], tables[1:], bare)


def test_without_tooth_counts_shafts_are_ranked_by_their_envelope():
    plain = dataclasses.replace(MACHINE, gears=(), bearings=())
    settings = FeatureSettings(kinematics=plain, windows={})
    healthy = [table(seed, settings) for seed in range(8)]
    for gear, shaft in (("stage 1 pinion", "shaft_1"), ("stage 2 wheel", "shaft_3")):
        verdict = judge(table(104, settings, fault=gear), healthy, plain)
        assert verdict.damaged
        assert verdict.first.component == shaft


def test_what_turns_too_seldom_is_named_with_the_time_it_takes(healthy):
    short = FeatureSettings(kinematics=MACHINE, windows={"short": (1.0, 1.8)})
    found = run_features(recording(105), short)
    assert "shaft_3" not in found.component
    (words,) = found.left_out
    assert words.startswith("shaft_3 (stage 2 wheel): 2.9 turns")
    known = r"no shaft makes 3 revolutions between 1 and 1.1 s\. Set a longer window or one at"
    with pytest.raises(FeatureError, match=known):
        run_features(recording(105), FeatureSettings(kinematics=MACHINE, windows={"none": (1.0, 1.1)}))
    one = recording(105)
    angle = 2 * np.pi * 20.0 * one.time.values
    unsure = Rotation(angle=angle, source="", error=0.0, absolute=False, conditional={"shaft_1": "no sidebands"})
    with pytest.raises(FeatureError, match=r"shaft_1: no sidebands\. .*, correct teeth, set speed with"):
        recording_features(one, MACHINE, unsure, {"none": (1.0, 1.1)})


def test_shafts_that_turn_alike_or_nest_cannot_be_told_apart():
    twice = dataclasses.replace(
        MACHINE,
        shafts=(*MACHINE.shafts, Shaft(name="shaft_4", ratio=2 * 17 / 40)),
        gears=(*MACHINE.gears, Gear(name="stage 3 pinion", shaft="shaft_4", stage=3, teeth=23)),
    )
    assert alike("shaft_2", twice) == ("shaft_4",)
    assert alike("stage 1 wheel", twice) == ("stage 2 pinion", "stage 3 pinion")
    assert alike("stage 1 pinion", twice) == ()
    assert alike("bearing_1 BPFO", twice) == ()


def test_the_table_of_the_verdict_lists_every_component(healthy):
    grid = ranking_grid(judge(table(106, fault="stage 1 wheel"), healthy, MACHINE))
    assert {row[0] for row in grid.rows} >= {one.name for one in (*MACHINE.shafts, *MACHINE.gears)}


def test_the_tooth_is_the_same_backwards(healthy):
    forwards = recording(107, fault="stage 2 wheel", tooth=20)
    backwards = forwards.assign(shaft_angle=-forwards.shaft_angle)  # the same knocks, counted down: tooth 45 - 20
    found = [run_features(one, SETTINGS).tooth_of("stage 2 wheel") for one in (forwards, backwards)]
    assert found == [20, 25]


BLIND = "bearing_9 BPFI"  # 17.05 Hz, twice the speed of shaft_2 is 17 Hz
HIDDEN = dataclasses.replace(
    MACHINE,
    bearings=(
        *MACHINE.bearings,
        Bearing(
            name="bearing_9", shaft="shaft_3", orders={"BPFO": 3.5, "BPFI": 17.05 / (20.0 * MACHINE.shafts[2].ratio)}
        ),
    ),
)


@pytest.fixture(scope="module")
def hidden():
    settings = FeatureSettings(kinematics=HIDDEN, windows={})
    baseline = [table(seed, settings) for seed in range(8)]
    return {
        fault: judge(table(100, settings, fault=fault, tooth=5), baseline, HIDDEN) for fault in ("", "stage 1 wheel")
    }


def test_a_race_whose_pass_order_coincides_with_a_multiple_of_a_shaft_is_not_examined(hidden):
    verdict = hidden[""]
    assert verdict.not_examined == (BLIND,)
    assert headline(verdict) == f"Not examined: {BLIND}; no other component exceeds its limit."
    assert answer(verdict) == "incomplete"
    words = " ".join(sentences(verdict))
    assert f"Not examined: {BLIND}: its pass frequency (17.05 Hz) is not separated from 2 x shaft_2 (17 Hz)" in words
    assert [row[0] for row in ranking_grid(verdict).rows if "not examined" in row] == [BLIND]


def test_a_gear_is_not_named_alone_if_a_race_that_is_not_examined_has_its_orders(hidden):
    verdict = hidden["stage 1 wheel"]
    assert BLIND in verdict.first.alike
    assert headline(verdict).endswith(f"(+- 1) or {BLIND}.")
    other = next(one for one in verdict.findings if one.component == "stage 2 wheel")
    assert BLIND not in other.alike


def test_known_damage_that_is_not_examined_is_not_called_not_found(hidden):
    damage, verdict = Damage(component=BLIND, tooth=None, words="spall"), hidden["stage 1 wheel"]
    case = Case(load="torque", deviations="off", window="up", verdict=verdict)
    words = " ".join(case_sentences([case], [damage]))
    assert words.startswith(f"Spall: not examined. {BLIND}: its pass frequency ")
    assert f"{BLIND} has the same orders as the {verdict.first.component} and can be the cause." in words
    assert any_found([case], [damage]) is None
    assert cases_grid([case], [damage]).rows[0][4] == "not examined"
    assert "found in 0 of 2 cases, not examined in 2." in case_sentences([case, case], [damage])[0]
