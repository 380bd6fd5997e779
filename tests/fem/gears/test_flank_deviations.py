"""Profile and helix deviations: ISO 1328-1 tolerances by hand, samples inside them on the flank, no table, no shift."""

import numpy as np
import pytest

from benchmarks.gear_pairs import gear_pair
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.models.iso import Iso
from fem.contact.teeth import tooth_terms
from fem.gears.flank_deviations import flank_tolerance, sample_flank_deviations
from fem.gears.gear_checks import GeometryError

PAIR = gear_pair((20, 55), 2, 12, 12)


@pytest.mark.parametrize(
    ("gear", "grade", "profile", "helix"),
    [
        # d 40.894, b 12 mm: 0.8 + 0.041 + 4 = 4.84; 1.1 + 5 = 6.1; 0.320 + 1.212 + 4 = 5.53; 0.448 + 1.559 + 4 = 6.01
        (PAIR.pinion, 5, (4.8, 6.0, 8.0), (5.5, 6.0, 8.0)),
        (PAIR.pinion, 7, (9.5, 12.0, 16.0), (11.0, 12.0, 16.0)),
        # d 112.46 mm: 4.912; 6.1; 0.530 + 1.212 + 4 = 5.74; 0.742 + 1.559 + 4 = 6.30
        (PAIR.wheel, 5, (4.9, 6.0, 8.0), (5.5, 6.5, 8.5)),
        (PAIR.wheel, 1, (1.2, 1.5, 2.0), (1.4, 1.6, 2.1)),
    ],
)
def test_tolerances_by_hand(gear, grade, profile, helix):
    found = flank_tolerance(gear, grade)
    um = [1e6 * value for value in (found.profile_slope, found.profile_form, found.profile)]
    assert um == pytest.approx(profile)
    assert [1e6 * v for v in (found.helix_slope, found.helix_form, found.helix)] == pytest.approx(helix)


def shape(terms, tooth, xi, part):
    """Gap of one tooth over position and part y / b of the face."""
    h, a1, a2, b1, b2 = (term[tooth] for term in terms.values())
    return h + a1 * xi + a2 * xi**2 + b1 * part + b2 * part**2


@pytest.mark.parametrize("gear", ["pinion", "wheel"])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_measured_on_the_flank_a_sample_is_within_its_grade(gear, seed):
    """Slope from the chord, form from the bow of every trace over the active profile and over the face."""
    tolerance = flank_tolerance(getattr(PAIR, gear), 6)
    ends = np.array([PAIR.xi_start, (PAIR.xi_start + PAIR.xi_end) / 2, PAIR.xi_end])
    used = {"profile_slope": 0.0, "profile_form": 0.0, "helix_slope": 0.0, "helix_form": 0.0}
    for terms in sample_flank_deviations(PAIR, gear, 6, seed, use=1.0).values():
        for tooth in range(getattr(PAIR, gear).teeth):
            traces = (
                ("profile", shape(terms, tooth, ends, 0.0), tolerance.profile),
                ("helix", shape(terms, tooth, ends[1], np.array([-0.5, 0.0, 0.5])), tolerance.helix),
            )
            for name, (low, middle, high), total in traces:
                assert middle == pytest.approx(0.0, abs=1e-18)  # where pitch is measured
                slope, form = abs(high - low), abs((low + high) / 2 - middle)
                assert np.hypot(slope, form) <= total * (1 + 1e-9)
                used[f"{name}_slope"] = max(used[f"{name}_slope"], slope)
                used[f"{name}_form"] = max(used[f"{name}_form"], form)
    for name, most in used.items():
        assert 0.6 * getattr(tolerance, name) < most <= getattr(tolerance, name) * (1 + 1e-9)


@pytest.mark.parametrize("seed", [30, 54, 104])
def test_slope_and_form_of_a_tooth_stay_within_the_total_tolerance_of_the_helix(seed):
    """With these seeds one tooth has nearly the largest slope and the largest form; both together exceed the total."""
    tolerance = flank_tolerance(PAIR.pinion, 5)
    assert np.hypot(tolerance.helix_slope, tolerance.helix_form) > 1.015 * tolerance.helix
    for terms in sample_flank_deviations(PAIR, "pinion", 5, seed, use=1.0).values():
        assert np.hypot(terms["lead_slope"], terms["lead_curvature"] / 4).max() <= tolerance.helix * (1 + 1e-9)


def test_seeds_grades_and_what_is_left_out():
    first, again = (sample_flank_deviations(PAIR, "wheel", 5, 11)["drive"] for _ in range(2))
    assert np.array_equal(first["lead_slope"], again["lead_slope"])
    assert not np.allclose(first["lead_slope"], sample_flank_deviations(PAIR, "wheel", 5, 12)["drive"]["lead_slope"])
    worse = sample_flank_deviations(PAIR, "wheel", 9, 11)["drive"]
    assert np.ptp(worse["profile_slope"]) > 2.5 * np.ptp(first["profile_slope"])
    without = sample_flank_deviations(PAIR, "wheel", 5, 11, profile=False)["drive"]
    assert not np.any([without["profile_slope"], without["profile_curvature"]])
    assert np.array_equal(without["lead_slope"], first["lead_slope"])


def test_a_law_takes_the_deviations_of_every_tooth():
    law = Iso().law(PAIR)
    cycle = np.linspace(0, 20, 161)
    teeth = tooth_terms(20, **sample_flank_deviations(PAIR, "pinion", 7, 1)["drive"])
    found = LawEvaluator(law).evaluate(cycle, 8e-6, 0.0, teeth)
    plain = LawEvaluator(law).evaluate(cycle, 8e-6)
    assert np.isfinite(found.force).all()
    assert 0.01 < np.abs(found.force / plain.force - 1).max() < 1.0
    assert np.abs(found.moment).max() > 2 * np.abs(plain.moment).max()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((gear_pair((20, 55), 2, 12, 3), "pinion", 5, 1), "4 to 1200 mm"),
        ((PAIR, "pinion", 12, 1), "1 to 11"),
    ],
)
def test_outside_the_standard_is_refused(arguments, message):
    with pytest.raises(GeometryError, match=message):
        sample_flank_deviations(*arguments)
