"""Pitch deviations: ISO 1328-1 tolerances by hand, samples inside them, seeds, eccentricity."""

import math

import numpy as np
import pytest

from benchmarks.gear_pairs import gear_pair
from fem.gears.deviations import pitch_tolerance, sample_pitch_deviations
from fem.gears.gear_checks import GeometryError

PAIR = gear_pair((20, 55), 2, 12, 12)


@pytest.mark.parametrize(
    ("gear", "grade", "single", "cumulative"),
    [
        # d = 40.894 mm: 0.0409 + 0.8 + 5 = 5.84; 0.0818 + 3.517 + 1.4 + 12 = 17.0
        (PAIR.pinion, 5, 6.0, 17.0),
        (PAIR.pinion, 7, 12.0, 34.0),
        (PAIR.pinion, 1, 1.5, 4.2),
        # d = 112.457 mm: 5.912; 0.225 + 5.833 + 1.4 + 12 = 19.46
        (PAIR.wheel, 5, 6.0, 19.0),
        (PAIR.wheel, 6, 8.5, 28.0),
    ],
)
def test_tolerances_by_hand(gear, grade, single, cumulative):
    found = pitch_tolerance(gear, grade)
    assert found.single * 1e6 == pytest.approx(single)
    assert found.cumulative * 1e6 == pytest.approx(cumulative)
    assert found.runout < found.cumulative


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("grade", [3, 5, 8])
def test_samples_stay_within_their_grade(seed, grade):
    for gear in (PAIR.pinion, PAIR.wheel):
        tolerance = pitch_tolerance(gear, grade)
        sample = sample_pitch_deviations(gear, grade, seed, use=1.0)
        used = []
        for clearance in sample.values():
            arc = -clearance / math.cos(gear.transverse_pressure_angle)
            assert arc.shape == (gear.teeth,)
            assert arc.mean() == pytest.approx(0.0, abs=1e-18)
            single = np.abs(np.diff(arc, append=arc[0])).max()
            used += [single / tolerance.single, np.ptp(arc) / tolerance.cumulative]
        assert max(used) == pytest.approx(1.0, rel=1e-9)


def test_equal_seeds_give_equal_gears_and_grades_scale_them():
    first, again = (sample_pitch_deviations(PAIR.wheel, 5, 11) for _ in range(2))
    assert np.array_equal(first["drive"], again["drive"])
    assert not np.allclose(first["drive"], sample_pitch_deviations(PAIR.wheel, 5, 12)["drive"])
    assert np.ptp(sample_pitch_deviations(PAIR.wheel, 9, 11)["drive"]) > 2.5 * np.ptp(first["drive"])


def test_eccentricity_runs_once_per_revolution_and_both_flanks_see_it():
    """The first harmonics of drive and coast lie 180 deg - 2 alpha_t apart: one flank comes as the other goes."""
    phases = []
    for seed in range(40):
        sample = sample_pitch_deviations(PAIR.wheel, 5, seed)
        drive, coast = np.fft.rfft(sample["drive"]), np.fft.rfft(sample["coast"])
        assert np.abs(drive[1]) > 3 * np.median(np.abs(drive[2:]))
        phases.append(np.angle(coast[1] / drive[1]))
    expected = math.pi - 2 * PAIR.wheel.transverse_pressure_angle
    assert np.abs(np.abs(np.mean(np.exp(1j * np.array(phases)))) - 1) < 0.05
    assert abs(np.angle(np.mean(np.exp(1j * np.array(phases))))) == pytest.approx(expected, abs=0.1)


@pytest.mark.parametrize("grade", [0, 12])
def test_outside_the_standard_is_refused(grade):
    with pytest.raises(GeometryError, match="1 to 11"):
        sample_pitch_deviations(PAIR.pinion, grade, 1)
