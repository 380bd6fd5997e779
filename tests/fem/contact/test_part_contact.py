"""Slices that hold the end of a line of contact: no tone, one potential, first touch at the least gap."""

import numpy as np
import pytest
from mesh_laws import made_up_law

from benchmarks.gear_pairs import gear_pair
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.models.plane import Plane
from fem.contact.part_contact import part_of, reduction_of, touch

SLICES = 15


@pytest.fixture(scope="module")
def pair():
    return gear_pair((22, 65), 3, 11, 28, bores_mm=(22.5, 30))


def law_of(pair, slices):
    return Plane(slices=slices, refinement=0.6).law(pair, "drive")


def test_fifteen_slices_are_as_good_as_three_times_as_many_were(pair):
    """Transmission error at 4,500 N: .0112 um rms and a tone of .0123 um at n / eps_beta, slices in and out as a whole.

    31 of those were .0017 and .0013 um off.
    """
    cycle, force = np.arange(128) / 128, 4500.0
    error, exact = (stiffness_curve(law_of(pair, n), force, cycle).transmission_error for n in (SLICES, 101))
    lines = 2.0 * np.abs(np.fft.rfft(error - exact)) / cycle.size
    passing = SLICES / pair.overlap_ratio
    assert (error - exact).std() < 1.7e-9
    assert lines[round(0.8 * passing) : round(1.2 * passing)].max() < 1.0e-9


def test_a_slice_that_enters_an_even_slope_carries_what_many_narrow_ones_do():
    """A linear law on a flank whose gap rises evenly: the mean over the slice is exact from first touch to closing."""
    xi = np.linspace(-1.5, 1.5, 201)
    gap = np.where(np.abs(xi) < 1.2, 4e-5 * np.abs(xi), np.inf)
    even = {"gap": gap, "fraction": np.ones(201), "compliance": np.full(201, 6e-11), "hertz": 0.0, "neighbours": 0}
    cycle, delta = np.linspace(0.0, 1.0, 23), 3e-5
    coarse, fine = (LawEvaluator(made_up_law(slices=n, **even)).evaluate(cycle, delta) for n in (6, 36))
    assert coarse.force == pytest.approx(fine.force, rel=1e-4)
    assert coarse.stiffness == pytest.approx(fine.stiffness, rel=1e-9)


@pytest.mark.parametrize("even", [0.0, 0.3, 0.8])
@pytest.mark.parametrize("share", [1e-3, 0.2, 0.9, 1.5])
def test_without_a_hertz_term_the_first_guess_is_the_solution(even, share):
    """C f of the approach x = C f - a r to that a load f = u f_a gives; C f_a = a (1 + p) / (1 - p)."""
    rise, carried = 2e-6, share * 2e-6 * (1 + even) / (1 - even)
    approach = carried - rise * reduction_of(even, part_of(share, 1.0, even))
    assert touch(approach, rise, even) == pytest.approx(carried, rel=1e-9)


@pytest.mark.parametrize("slices", [3, SLICES])
def test_contact_begins_at_the_least_gap_anywhere_on_the_face(pair, slices):
    """eps_beta and eps_alpha leave no position without a line of contact: the no-load error is 0 and never below."""
    start = LawEvaluator(law_of(pair, slices)).no_load(np.linspace(0.0, 1.0, 97))
    assert start == pytest.approx(np.zeros(97), abs=1e-12)
