"""Brent's root against SciPy's, bit for bit."""

import math

import numpy as np
import pytest
from scipy import optimize

from fem.numerics.root_finding import brentq

FUNCTIONS = (
    lambda x: math.cos(x) - x,
    lambda x: x**3 - 2.0 * x - 5.0,
    lambda x: math.exp(-50.0 * x) - 0.3,
    lambda x: math.tan(x) - x - 0.01,
    lambda x: math.copysign(abs(x - 0.3) ** (1 / 3), x - 0.3),
    lambda x: np.float64(x) ** 9 - 1e-9,
    lambda x: -1.0 if x < 0.7 else 1.0,
)


@pytest.mark.parametrize("number", range(len(FUNCTIONS)))
@pytest.mark.parametrize("xtol", [2e-12, 1e-15, 1e-4])
def test_the_root_is_scipys(number, xtol):
    function, tried = FUNCTIONS[number], 0
    for low, high in np.random.default_rng(number).uniform(-1.0, 3.0, (200, 2)):
        if number == 3 and max(low, high) > 1.5:
            continue
        if function(low) * function(high) < 0.0:
            assert brentq(function, low, high, xtol=xtol) == optimize.brentq(function, low, high, xtol=xtol)
            tried += 1
    assert tried > 20


def test_a_root_at_an_end_is_taken():
    assert brentq(lambda x: x - 1.0, 1.0, 2.0) == 1.0
    assert brentq(lambda x: x - 2.0, 1.0, 2.0) == 2.0


def test_equal_signs_and_no_numbers_are_refused():
    with pytest.raises(ValueError, match="must have different signs"):
        brentq(lambda x: x * x + 1.0, -1.0, 1.0)
    with pytest.raises(ValueError, match="must have different signs"):
        brentq(lambda x: math.nan, -1.0, 1.0)
