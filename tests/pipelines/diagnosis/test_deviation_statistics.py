"""Probabilities of one recording against few healthy ones: right for heavy tails, and honest about few."""

import numpy as np
import pytest
from scipy import stats

from pipelines.diagnosis.deviation_statistics import (
    at_speed,
    clopper_pearson,
    deviations,
    limit,
    moderated,
    probability,
)

KINDS = ["rms", "fm4", "kurtosis"] * 5


def machines(random, count, channels=3):
    """Healthy levels (machine, channel, line) with heavy tails, and scales that differ by kind and by line."""
    scale = np.exp(0.3 * random.standard_normal((1, channels, len(KINDS)))) * ([1.0, 0.4, 2.0] * 5)
    return scale * random.standard_t(5, (count, channels, len(KINDS)))


def test_healthy_machines_with_heavy_tails_exceed_the_limit_as_often_as_stated():
    random, found, normal = np.random.default_rng(1), 0, 0
    for _ in range(600):
        new, healthy = np.split(machines(random, 9), [1])
        spread, prior = moderated(healthy, KINDS, 1e-3)
        deviation = deviations(new[0], healthy, spread)
        found += np.abs(deviation).max() >= limit(0.01 / 2 / deviation.size, 8, prior)
        plain = deviations(new[0], healthy, healthy.std(axis=0, ddof=1))
        normal += np.abs(plain).max() >= stats.t.isf(0.01 / 2 / deviation.size, 7)
    low, high = clopper_pearson(int(found), 600, 0.999)
    assert low < 0.01 < high
    assert normal > 3 * 0.01 * 600  # limits of normal levels alarm several times as often


def test_equal_scales_of_a_kind_are_pooled_and_unlike_ones_are_not():
    random = np.random.default_rng(2)
    levels = random.standard_normal((8, 6, 40))
    spread, prior = moderated(levels, ["rms"] * 40, 1e-3)
    own = levels.std(axis=0, ddof=1)
    assert prior == 7
    assert np.std(np.log(spread)) < 0.6 * np.std(np.log(own))
    spread, prior = moderated(levels * np.exp(2.0 * random.standard_normal((1, 6, 40))), ["rms"] * 40, 1e-3)
    assert prior == 1


def test_a_level_that_never_changes_has_the_least_spread():
    spread, _ = moderated(np.zeros((8, 2, 3)), ["rms"] * 3, 0.25)
    assert spread == pytest.approx(np.full((2, 3), 0.25), rel=0.3)


def test_the_mean_of_several_features_has_lighter_tails():
    assert limit(1e-5, 8, 7, 6) < 0.7 * limit(1e-5, 8, 7)


def test_a_limit_has_its_probability():
    for chance in (0.1, 1e-3, 1e-6):
        assert probability(np.array([limit(chance, 8, 4)]), 8, 4)[0] == pytest.approx(chance, rel=1e-6)


@pytest.mark.parametrize(
    ("count", "trials", "interval"),
    [(0, 8, (0.0, 0.36942)), (8, 8, (0.63058, 1.0)), (1, 300, (0.0000844, 0.018435)), (0, 0, (0.0, 1.0))],
)
def test_intervals_of_clopper_and_pearson(count, trials, interval):
    assert clopper_pearson(count, trials) == pytest.approx(interval, rel=1e-3)


SPEEDS = np.array([29.60, 29.61, 29.63, 29.64, 29.66, 29.69, 29.71, 29.72, 29.75, 29.76])  # Hz, of loads 9, 8, ... 0


def over_speed(random, lines, slope=100.0):
    """Healthy levels (recording, 1, line) on a line over the speed, dB, with normal scatter of 1 dB."""
    return slope * (SPEEDS - 29.7)[:, None, None] + random.standard_normal((len(SPEEDS), 1, lines))


def test_levels_on_a_line_over_the_speed_deviate_from_it_as_students_distribution_says():
    random, speed = np.random.default_rng(2), 29.62
    healthy = over_speed(random, 4000)
    found = at_speed(healthy, SPEEDS, speed)
    assert found.shape == (9, 1, 4000)
    line = np.polyfit(SPEEDS - speed, healthy[:, 0], 1)[1]
    assert np.allclose(found.mean(axis=0)[0], line)
    new = 100.0 * (speed - 29.7) + random.standard_normal((1, 4000))
    deviation = deviations(new, found, found.std(axis=0, ddof=1))
    assert stats.kstest(deviation[0], stats.t(len(SPEEDS) - 2).cdf).pvalue > 0.01


@pytest.mark.parametrize(
    ("speeds", "speed", "slope"),
    [
        (SPEEDS, 29.62, 0.0),
        (SPEEDS, 29.90, 100.0),
        (SPEEDS[:5], 29.62, 100.0),
        (29.62 + 0.01 * (SPEEDS - 29.7), 29.62, 100.0),
    ],
    ids=["no trend", "far outside", "too few", "one speed"],
)
def test_levels_stay_as_they_are_where_no_line_predicts_them(speeds, speed, slope):
    healthy = over_speed(np.random.default_rng(3), 200, slope)[: len(speeds)]
    assert at_speed(healthy, speeds, speed) is healthy
