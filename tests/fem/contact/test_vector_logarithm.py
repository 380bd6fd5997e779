"""The vectorised logarithm of the mesh law against that of NumPy, over the whole range of positive numbers."""

import numpy as np
import pytest
from numba import njit

from fem.contact.evaluation.law_tables import LANES
from fem.contact.evaluation.line_contact import SERIES, log_of_growth, logarithm, rough_log


@njit
def logarithms(rows):
    for k in range(len(rows)):
        logarithm(rows[k], rows[k].view(np.int64), 0, 1, 2)


def found(values):
    """ln of numbers (n,), n a multiple of LANES."""
    rows = np.stack([values.reshape(-1, LANES)] * 3, axis=1)
    logarithms(rows)
    return rows[:, 1].ravel()


@pytest.mark.parametrize(("low", "high"), [(-708.0, 709.7), (-1.0, 1.0), (-1e-6, 1e-6)])
def test_logarithm_is_exact_to_the_last_digit(low, high):
    values = np.exp(np.random.default_rng(0).uniform(low, high, 2 * LANES * 2000))
    exact = np.log(values)
    assert (abs(found(values) - exact) <= np.spacing(abs(exact))).all()


def test_logarithm_at_powers_of_two_and_at_the_ends():
    values = np.concatenate([2.0 ** np.arange(-32, 30), [np.finfo(float).tiny, np.finfo(float).max]])
    assert found(values) == pytest.approx(np.log(values), rel=3e-16)
    assert found(np.ones(2 * LANES)).tolist() == [0.0] * 2 * LANES


def test_series_and_rough_logarithm_keep_their_bounds():
    growth = np.linspace(-SERIES, SERIES, 401)
    assert log_of_growth(growth) == pytest.approx(np.log1p(growth), rel=1e-14)
    values = np.exp(np.random.default_rng(1).uniform(-300, 300, 4000))
    assert abs(rough_log(values.view(np.int64)) - np.log(values)).max() < 0.03
