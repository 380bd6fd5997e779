"""Monotone cubic interpolation against SciPy's, bit for bit."""

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from fem.numerics.pchip import pchip


@pytest.mark.parametrize("number", range(60))
def test_the_values_are_scipys(number):
    random = np.random.default_rng(number)
    x = np.cumsum(random.uniform(0.1, 2.0, random.integers(3, 30)))
    y = random.normal(size=x.size) if number % 3 else np.round(random.normal(size=x.size))  # with equal neighbours
    if number % 4 == 0:
        y = np.cumsum(abs(y))
    at = np.append(random.uniform(x[0] - 1.0, x[-1] + 1.0, (40, 17)), [x[:1].repeat(17), x[-1:].repeat(17)], axis=0)
    at[0, : min(17, x.size)] = x[:17]
    assert np.array_equal(pchip(x, y, at), PchipInterpolator(x, y)(at))
