"""p-values of one recording against few healthy ones: uniform if the model holds, corrected, and honest about few."""

import numpy as np
import pytest
from scipy import stats

from pipelines.diagnosis.prediction import clopper_pearson, holm, p_values


def test_p_values_of_healthy_recordings_are_uniform_with_a_baseline_of_eight():
    draws = np.random.default_rng(1).normal(-20.0, 1.7, size=(2000, 9))
    p = np.array([p_values(row[:1], row[1:, None])[0] for row in draws])
    assert stats.kstest(p, "uniform").pvalue > 0.01
    for limit in (0.01, 0.05, 0.2):  # a deviation taken as known would alarm three times as often at 1 %
        low, high = clopper_pearson(int((p < limit).sum()), 2000, 0.999)
        assert low < limit < high


def test_the_prediction_interval_is_that_of_hahn_and_meeker():
    healthy = np.array([[1.0], [2.0], [3.0], [4.0], [5.0]])
    bound = 3.0 + stats.t.ppf(0.95, 4) * np.sqrt(2.5) * np.sqrt(1 + 1 / 5)
    assert p_values(np.array([bound]), healthy)[0] == pytest.approx(0.05)


def test_fewer_than_five_recordings_give_no_p_value():
    with pytest.raises(ValueError, match="4 healthy recordings"):
        p_values(np.zeros(1), np.zeros((4, 1)))


def test_holm_raises_the_least_most():
    assert holm(np.array([0.01, 0.04, 0.03])) == pytest.approx([0.03, 0.06, 0.06])
    assert holm(np.array([0.5, 0.9])) == pytest.approx([1.0, 1.0])


def test_holm_keeps_the_chance_of_any_alarm():
    p = np.random.default_rng(2).uniform(size=(4000, 30))
    alarms = int(sum(holm(row).min() <= 0.05 for row in p))
    low, high = clopper_pearson(alarms, 4000, 0.999)
    assert low < 0.05 < high
    assert (p.min(axis=1) <= 0.05).mean() > 0.7  # without correction most healthy recordings would be alarms


@pytest.mark.parametrize(
    ("count", "trials", "interval"),
    [(0, 8, (0.0, 0.36942)), (8, 8, (0.63058, 1.0)), (1, 300, (0.0000844, 0.018435)), (0, 0, (0.0, 1.0))],
)
def test_intervals_of_clopper_and_pearson(count, trials, interval):
    assert clopper_pearson(count, trials) == pytest.approx(interval, rel=1e-3)
