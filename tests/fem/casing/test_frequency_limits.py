"""Limits of natural frequencies from three meshes: what is known is found, and the truth lies in the bands."""

import numpy as np
import pytest

from fem.casing.uncertainty.cubic_limits import SHARES, cubic_limits
from fem.casing.uncertainty.frequency_limits import EDGE_ORDER, LimitError, frequency_limits
from fem.casing.uncertainty.limits_by_element import FAST, SLOW, WALLS, extrapolation_of, hexahedral_limits
from fem.casing.uncertainty.pairing import counterparts

SIZES = np.array([1.0, 1.3, 1.7])
EXACT = 300.0 * 1.06 ** np.arange(60)  # Hz


def on_meshes(order, amplitude, noise=0.0, seed=0):
    """Frequencies (3, mode) of known truth; noise is relative."""
    clean = EXACT * (1.0 + amplitude * SIZES[:, None] ** order)
    return clean * (1.0 + noise * np.random.default_rng(seed).standard_normal(clean.shape))


def amplitudes(seed=1):
    return 0.01 * np.random.default_rng(seed).lognormal(0.0, 0.4, len(EXACT))


@pytest.mark.parametrize("share", [0.2, 0.6, 0.95])
def test_an_edge_and_smooth_bodies_together_are_found_with_their_limits(share):
    law = share * SIZES**EDGE_ORDER + (1.0 - share) * SIZES**4.0
    found = frequency_limits(SIZES, EXACT * (1.0 + amplitudes() * law[:, None]))
    assert found.limits == pytest.approx(EXACT, rel=1e-3)  # changes are told from the finest mesh, not from the limit
    assert 1.1 < found.order < 4.0


@pytest.mark.parametrize("order", [1.2, 2.0, 3.4])
def test_the_band_reaches_to_the_limit_of_a_single_order_and_to_that_of_edges(order):
    f = on_meshes(order, amplitudes())
    found = frequency_limits(SIZES, f)
    assert found.order == pytest.approx(order, rel=1e-6)
    assert found.orders == pytest.approx(order, rel=1e-4)
    assert (found.limits < EXACT).all()
    least = np.median(amplitudes())  # modes with less than the median change have its band
    usual = amplitudes() >= least
    of_edges = f[0] - (f[2] - f[0]) / ((SIZES[2] / SIZES[0]) ** EDGE_ORDER - 1.0)
    ends = np.array([EXACT - found.limits, found.limits - of_edges])
    assert found.bands[usual] == pytest.approx(ends.max(axis=0)[usual], rel=1e-3)


@pytest.mark.parametrize("noise", [1e-4, 5e-4])
def test_limits_of_noisy_meshes_lie_in_their_bands(noise):
    inside = []
    for seed in range(20):
        found = frequency_limits(SIZES, on_meshes(2.2, amplitudes(seed), noise, seed))
        inside += (abs(found.limits - EXACT) < found.bands).tolist()
    assert np.mean(inside) > 0.9  # the true order is the end of the band


def test_limits_of_modes_with_shares_of_edges_of_their_own_lie_in_their_bands():
    inside, width = [], []
    for seed in range(20):
        shares = np.clip(0.85 + 0.08 * np.random.default_rng(seed).standard_normal(len(EXACT)), 0.0, 1.0)
        law = shares * SIZES[:, None] ** EDGE_ORDER + (1.0 - shares) * SIZES[:, None] ** 4.0
        found = frequency_limits(SIZES, EXACT * (1.0 + amplitudes(seed) * law))
        inside += (abs(found.limits - EXACT) < found.bands).tolist()
        width += (found.bands / EXACT).tolist()
    assert np.mean(inside) > 0.95
    assert np.median(width) < 0.02  # the correction itself is 0.01


def test_the_common_order_is_not_moved_by_a_few_modes_that_are_paired_wrongly():
    f = on_meshes(2.0, amplitudes())
    f[2, :5] *= 1.2
    assert frequency_limits(SIZES, f).order == pytest.approx(2.0, abs=0.01)


def test_a_mode_that_oscillates_has_at_least_its_spread_as_band_and_no_order():
    f = on_meshes(2.0, amplitudes())
    f[1, 7] = 0.99 * f[0, 7]
    found = frequency_limits(SIZES, f)
    assert np.isnan(found.orders[7])
    assert found.bands[7] >= np.ptp(f[:, 7])


def test_a_mode_without_counterpart_takes_the_mean_correction():
    f = on_meshes(2.0, np.full(len(EXACT), 0.01))
    f[1, 4] = np.nan
    found = frequency_limits(SIZES, f)
    assert found.limits[4] / EXACT[4] == pytest.approx(found.limits[5] / EXACT[5], rel=1e-6)
    assert np.isnan(found.orders[4])


def test_no_order_beyond_what_theory_allows_is_believed():
    assert frequency_limits(SIZES, on_meshes(7.0, amplitudes()), formal_order=4.0).order == 4.0
    assert frequency_limits(SIZES, on_meshes(0.3, amplitudes())).order == EDGE_ORDER


@pytest.mark.parametrize(
    ("element", "order"), [("tetrahedron-4", 2.0), ("tetrahedron-10", 4.0), ("tetrahedron-20", 6.0)]
)
def test_the_largest_order_that_is_believed_is_that_of_the_element(element, order):
    assert extrapolation_of(element)(SIZES, on_meshes(7.0, amplitudes())).order == order


def test_meshes_that_tell_nothing_are_refused():
    f = on_meshes(2.0, amplitudes())
    for sizes, frequencies, message in (
        (SIZES[:2], f[:2], "Set three"),
        (SIZES, np.where(np.arange(60) < 58, np.nan, f), "2 modes of the finest mesh"),
        (SIZES, np.stack([f[0]] * 3), "60 modes of the finest mesh"),
    ):
        with pytest.raises(LimitError, match=message):
            frequency_limits(sizes, frequencies)


@pytest.mark.parametrize(("degree", "order"), [(2, SLOW[2]), (2, FAST[2]), (3, SLOW[3]), (3, FAST[3])])
@pytest.mark.parametrize("end", [0, 1])
def test_limits_of_hexahedra_lie_in_their_bands_at_both_ends_of_what_they_are_taken_for(degree, order, end):
    """Bands are half as wide as what they cover: no wider than the ends ask for, no narrower."""
    clean = EXACT * (1.0 + WALLS[degree][end] + 0.002 * SIZES[:, None] ** order)
    found = hexahedral_limits(SIZES, clean, degree=degree)
    off = abs(found.limits - EXACT)
    assert (off <= found.bands * (1.0 + 0.02)).all()  # changes are told from the finest mesh
    at_a_corner = degree == 3 or (order == SLOW[degree]) == (end == 1)
    assert off.max() / found.bands.max() > 0.9 if at_a_corner else off.max() < 0.9 * found.bands.max()
    assert SLOW[degree] < found.order < FAST[degree]


@pytest.mark.parametrize("corners", SHARES)
@pytest.mark.parametrize("end", [0, 1])
def test_limits_of_cubic_elements_reach_to_both_ends_of_what_quadratic_ones_tell(corners, end):
    """f_3 = f_0 (1 + a), f_2 = f_3 (1 + e) with a = g e in parts of f_3."""
    excess = 5.0 * amplitudes()
    cubic = EXACT / (1.0 - SHARES[corners][end] * excess)
    found = cubic_limits(cubic, cubic * (1.0 + excess), corners=corners)
    off, usual = abs(found.limits - EXACT), excess >= np.median(excess)
    assert off[usual] == pytest.approx(found.bands[usual], rel=1e-9)
    assert (off <= found.bands * (1.0 + 1e-9)).all()


def test_modes_that_quadratic_elements_do_not_have_take_the_median_of_the_others():
    cubic, quadratic = EXACT, EXACT * 1.04
    found = cubic_limits(cubic, np.where(np.arange(60) == 5, np.nan, quadratic), corners=4)
    assert found.limits == pytest.approx(EXACT * (1.0 - 0.5 * sum(SHARES[4]) * 0.04))
    assert np.isfinite(cubic_limits(cubic, np.where(np.arange(60) < 57, np.nan, quadratic), corners=4).limits).all()
    with pytest.raises(LimitError, match="2 modes have counterparts"):
        cubic_limits(cubic, np.where(np.arange(60) < 58, np.nan, quadratic), corners=4)


def test_what_no_size_of_a_hexahedron_shows_stays_in_the_band_of_smaller_ones():
    found = hexahedral_limits(SIZES, on_meshes(2.6, amplitudes()), degree=2)
    assert found.median_band_at(0.01) == pytest.approx(0.5 * (WALLS[2][1] - WALLS[2][0]), rel=0.02)


def test_modes_that_cross_between_two_meshes_find_their_counterparts():
    """Sines on a line; another amplitude, another sign, another order, slightly moved places."""
    x, order = np.linspace(0.0, 1.0, 60)[:, None], np.array([2, 0, 1, 4, 3])
    numbers = np.arange(1, 6)
    shapes, others = np.sin(np.pi * numbers * x), -3.0 * np.sin(np.pi * (order + 1) * (x + 0.004))
    assert counterparts(shapes, others).tolist() == np.argsort(order).tolist()


def test_a_mode_that_the_other_mesh_does_not_have_stays_alone():
    x = np.linspace(0.0, 1.0, 60)[:, None]
    shapes = np.sin(np.pi * np.array([1, 2, 3]) * x)
    assert counterparts(shapes, shapes[:, [0, 2]]).tolist() == [0, -1, 1]
