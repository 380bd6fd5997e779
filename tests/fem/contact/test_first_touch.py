"""Where flanks touch without load: the geometry of the whole face, whatever the number of slices."""

import numpy as np
import pytest

from benchmarks.gear_pairs import gear_pair
from fem.contact.evaluation.first_touch import first_touch
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.faults.changed_law import modified_law
from fem.contact.models.iso import Iso
from fem.contact.models.plane import Plane
from fem.contact.teeth import checked_terms, tooth_terms, with_variants
from fem.gears.modifications import EndRelief, FlankModifications, PairModifications, Relief, lead_gap, profile_gap
from fem.gears.path import path_points

HELICAL = gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5))
SPUR = gear_pair((20, 55), 2, 0, 12, bores_mm=(12.5, 17.5))
WIDE = gear_pair((20, 55), 2, 25, 60, bores_mm=(12.5, 17.5))
CYCLES = np.linspace(0.0, 1.0, 24, endpoint=False)
SLICES = 7
FORCE = 1200.0  # N: 100 N/mm, which closes half the face or less at the larger slope
NEAR = 1e-8  # m: chords of the tables of the law
SHAPES = {
    "slope": FlankModifications(helix_slope=100e-6),
    "hollow": FlankModifications(helix_slope=10e-6, lead_crowning=-20e-6),
    "crowned": FlankModifications(helix_slope=100e-6, lead_crowning=60e-6),
    "relieved": FlankModifications(helix_slope=40e-6, end_relief_low=EndRelief(amount=60e-6, length=2.2e-3)),
    "rounded": FlankModifications(
        helix_slope=-60e-6, end_relief_high=EndRelief(amount=80e-6, length=3.1e-3, shape="parabolic")
    ),
}


def law_of(pair, shape, slices=SLICES):
    model = Plane(slices=slices, refinement=0.5)
    return modified_law(model.laws(pair)[0], pair, PairModifications(pinion=shape))


def touch(law, psi=0.0, cycles=CYCLES, pinion=None, wheel=None):
    return first_touch(law, cycles, psi, checked_terms("pinion", 20, pinion), checked_terms("wheel", 55, wheel))


def alone(teeth):
    """All teeth but 0 are missing."""
    return np.where(np.arange(teeth) == 0, 0.0, np.inf)


@pytest.mark.parametrize("pair", [SPUR, HELICAL], ids=["spur", "helical"])
@pytest.mark.parametrize("slope", [20e-6, 100e-6])
def test_a_misaligned_pair_touches_at_the_end_of_the_face(pair, slope):
    shape = FlankModifications(helix_slope=slope)
    found, fine = (stiffness_curve(law_of(pair, shape, slices), FORCE, CYCLES) for slices in (SLICES, 101))
    assert found.no_load_error == pytest.approx(np.full(CYCLES.size, -slope / 2), abs=1e-12)
    assert found.secant == pytest.approx(FORCE / (fine.transmission_error + slope / 2), rel=0.02)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("psi", [0.0, 2e-3])
def test_first_touch_is_the_least_gap_over_the_face(name, psi):
    face = np.linspace(-6e-3, 6e-3, 100_001)
    exact = (lead_gap(HELICAL, PairModifications(pinion=SHAPES[name]), "drive", face) - psi * face).min()
    assert touch(law_of(HELICAL, SHAPES[name]), psi) == pytest.approx(np.full(CYCLES.size, exact), abs=NEAR)


@pytest.mark.parametrize("name", SHAPES)
def test_the_tilt_without_moment_is_the_one_that_touches_last(name):
    """Two points on both sides of mid face touch at once: every other tilt lets one of them touch earlier."""
    law = law_of(HELICAL, SHAPES[name])

    def at(tilt):
        return float(touch(law, tilt, CYCLES[:1])[0])

    near = max(np.linspace(-0.02, 0.02, 81), key=at)  # a least gap of points is concave in the tilt
    level = max(map(at, near + np.linspace(-5e-4, 5e-4, 101)))
    assert touch(law, None) == pytest.approx(np.full(CYCLES.size, level), abs=2e-8)


@pytest.mark.parametrize("pair", [HELICAL, WIDE], ids=["narrow", "wide"])
def test_one_pair_touches_on_its_own_line_of_contact(pair):
    """The line ends at the tip edges within the face; a tip relief and a slope put first touch anywhere on it."""
    shape = FlankModifications(helix_slope=70e-6, tip_relief=Relief(amount=40e-6, length=2e-3))
    law, given = law_of(pair, shape), PairModifications(pinion=shape)
    lead, half = law.cycle_shift[-1] / law.face_coordinate[-1], pair.face_width / 2
    face, reach = np.linspace(-half, half, 20_001), half * abs(lead) + 0.6
    cycles = np.linspace(-reach, reach, 31)
    exact = []
    for cycle in cycles:
        points = path_points(pair, cycle + lead * face, 100e-6)
        exact.append((points.gap + profile_gap(pair, given, points) + lead_gap(pair, given, "drive", face)).min())
    assert touch(law, 0.0, cycles, alone(20)) == pytest.approx(exact, abs=0.1e-6)


def test_a_line_of_the_standard_ends_with_the_path_of_contact():
    """`iso` takes slices that lie on the path in part into contact; first touch is on the path."""
    law = modified_law(Iso(slices=SLICES).law(HELICAL), HELICAL, PairModifications(pinion=SHAPES["slope"]))
    lead = law.cycle_shift[-1] / law.face_coordinate[-1]
    cycles = np.linspace(HELICAL.xi_start, HELICAL.xi_end, 13)
    ends = np.sort([(end - cycles) / lead for end in (HELICAL.xi_start, HELICAL.xi_end)], axis=0)
    on_path = 100e-6 * ends[0].clip(-6e-3, 6e-3) / 12e-3
    edge_at_the_end_of_the_face = -50e-6 + 2e-3 * Iso().edge_onset
    found = touch(law, 0.0, cycles, alone(20))
    early = on_path < edge_at_the_end_of_the_face
    assert early.sum() > 5
    assert found[early] == pytest.approx(on_path[early], abs=1e-12)
    assert (found <= on_path + 1e-12).all()


def test_what_single_teeth_bring_counts_as_in_the_law():
    """A lead slope of all teeth is a slope of the law; a chipped half of a tooth touches on the other half alone."""
    sound = law_of(SPUR, FlankModifications())
    sloped = touch(sound, pinion=tooth_terms(20, lead_slope=20e-6))
    assert sloped == pytest.approx(np.full(CYCLES.size, -10e-6), abs=1e-12)
    half = with_variants(sound, "wheel", 0.0, np.where(sound.face_coordinate > -1e-4, np.inf, 0.0)[:, None])
    chipped = touch(half, 1e-3, np.zeros(1), alone(20), tooth_terms(55, variant=1))
    assert chipped == pytest.approx(1e-3 * sound.slice_width[0] / 2, rel=1e-9)  # the end of the third of seven slices
    assert touch(half, 1e-3, np.zeros(1), alone(20)) == pytest.approx(-6e-6, rel=1e-9)
    assert touch(sound, pinion=np.full(20, np.inf)).min() > 1.0
