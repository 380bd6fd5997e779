"""Shapes along the flank and single teeth in a mesh law: gaps, slopes, damaged forms, two states at one cycle."""

import numpy as np
import pytest
from mesh_laws import made_up_law, potential_errors

from fem.contact.evaluation.evaluator import LawError, LawEvaluator
from fem.contact.teeth import checked_terms, least_clearance, tooth_terms, with_variants

LAW, NARROW = made_up_law(), made_up_law(slices=28)
FACE = LAW.slice_width.sum()
XI = LAW.position_start + LAW.position_step * np.arange(LAW.gap.size)


def states(n=80, seed=3):
    draw = np.random.default_rng(seed)
    return draw.uniform(-30, 30, n), draw.uniform(2e-6, 3e-5, n), draw.normal(0, 3e-4, n)


def deviations(teeth, seed):
    """Every term of a tooth at the size of grade 5 to 8."""
    draw = np.random.default_rng(seed)
    sizes = {
        "clearance": 2e-6,
        "profile_slope": 2e-6,
        "profile_curvature": 1e-6,
        "lead_slope": 3e-6,
        "lead_curvature": 2e-6,
    }
    return tooth_terms(teeth, **{name: draw.normal(0, size, teeth) for name, size in sizes.items()})


def same(a, b, rel=1e-9):
    for x, y in zip(a, b, strict=True):
        assert x == pytest.approx(y, rel=rel, abs=rel * np.abs(y).max())


@pytest.mark.parametrize(
    ("terms", "gap", "lead"),
    [
        ({"clearance": 3e-6}, 3e-6, 0.0),
        ({"profile_slope": 4e-6}, 4e-6 * XI, 0.0),
        ({"profile_curvature": 5e-6}, 5e-6 * XI**2, 0.0),
        ({"lead_slope": 6e-6}, 0.0, 6e-6 * LAW.face_coordinate / FACE),
        ({"lead_curvature": 7e-6}, 0.0, 7e-6 * (LAW.face_coordinate / FACE) ** 2),
    ],
)
@pytest.mark.parametrize("gear", ["pinion", "wheel"])
def test_a_term_that_all_teeth_share_is_a_modification(terms, gap, lead, gear):
    """Equal teeth are the same as the shape in the law.

    A profile is so in the limit of narrow slices: inside a slice only the shape of the law is seen to rise (7 slices
    over a whole mesh cycle: 0.3 % of the force), and a parabola is read from a table with chords.
    """
    teeth = {gear: tooth_terms(20 if gear == "pinion" else 55, **terms)}
    apart = []
    for law in (LAW, NARROW):
        lead_gap = np.broadcast_to(lead, LAW.face_coordinate.shape) if law is LAW else 0.0 * law.face_coordinate
        modified = law.replaced(gap=law.gap + gap, lead_gap=lead_gap)
        a, b = LawEvaluator(law).evaluate(*states(), **teeth), LawEvaluator(modified).evaluate(*states())
        if not any(name.startswith("profile") for name in terms):
            same(a, b)
            return
        apart.append(np.abs(a.force / b.force - 1).max())
    assert apart[0] < 4e-3
    assert apart[1] < 0.1 * apart[0]


def test_lead_slope_is_a_tilt():
    slope = 2e-4
    tilted = LAW.replaced(lead_gap=slope * LAW.face_coordinate)
    c, delta, psi = states()
    same(LawEvaluator(tilted).evaluate(c, delta, psi), LawEvaluator(LAW).evaluate(c, delta, psi - slope))


def test_every_derivative_with_deviations_and_damage_is_that_of_one_potential():
    draw = np.random.default_rng(7)
    law = with_variants(LAW, "pinion", draw.uniform(0, 3e-11, (7, 201)), 2e-6 * np.linspace(0, 1, 7)[:, None] ** 2)
    law = with_variants(law, "wheel", 1e-11 * (2 + XI), 1e-6 * np.clip(XI, 0, None))
    law = law.replaced(lead_gap=4e-6 * (law.face_coordinate / FACE) ** 2)
    pinion, wheel = deviations(20, 1), deviations(55, 2)
    pinion[::2, 5], wheel[::3, 5], wheel[7, 0] = 1, 1, np.inf
    assert ((potential_errors(law, states(), pinion, wheel) <= 1e-5).mean(axis=1) >= 0.95).all()


def test_exchange_of_pinion_and_wheel():
    """The wheel as driving gear meets its mate backwards on the path: the same forces at -c."""
    fields = {
        name: np.flip(getattr(LAW, name), axis=-1) for name in ("compliance", "contact_offset", "gap", "fraction")
    }
    behind = [
        np.interp(n - XI, XI, row) for n, row in enumerate(LAW.neighbour_compliance, 1)
    ]  # read at the pair that was behind
    other = LAW.replaced(
        **fields,
        neighbour_compliance=np.array(behind),
        cycle_shift=-LAW.cycle_shift,
        pinion_teeth=55,
        wheel_teeth=20,
    )
    pinion, wheel = deviations(20, 1), deviations(55, 2)

    def turned(terms):
        """Tooth i becomes tooth -i, its profile is run through backwards."""
        result = terms[(-np.arange(len(terms))) % len(terms)].copy()
        result[:, 1] *= -1
        return result

    c, delta, psi = states()
    a = LawEvaluator(LAW).evaluate(c, delta, psi, pinion, wheel)
    b = LawEvaluator(other).evaluate(-c, delta, psi, turned(wheel), turned(pinion))
    assert a.force == pytest.approx(b.force, rel=1e-5)  # a pitch is no whole number of cells: chords of the coupling
    assert a.moment == pytest.approx(b.moment, rel=1e-4, abs=1e-5 * np.abs(b.moment).max())


def test_a_chipped_tooth_carries_only_where_it_is_whole():
    gap = np.where(LAW.face_coordinate > 0, np.inf, 0.0)[:, None]
    law = with_variants(LAW, "wheel", 0.0, gap)
    wheel = tooth_terms(55, variant=np.where(np.arange(55) == 4, 1, 0))
    alone = np.full(20, np.inf)
    alone[4] = 0.0
    sound, chipped = (
        LawEvaluator(law).evaluate(4.0, 1e-5, 0.0, alone),
        LawEvaluator(law).evaluate(4.0, 1e-5, 0.0, alone, wheel),
    )
    assert 0.3 < chipped.force / sound.force < 0.6
    assert chipped.moment / chipped.force < -0.2 * FACE
    assert LawEvaluator(law).no_load(4.0, 5e-4, alone, wheel) > LawEvaluator(law).no_load(4.0, 5e-4, alone)


def test_damage_of_both_gears_adds_up():
    """A law that is softer everywhere also closes its slices under less load; 0.5 % in the force of 7 wide slices."""
    pinion = with_variants(LAW, "pinion", 1e-11, 1e-6)
    both = with_variants(pinion, "wheel", 2e-11, 2e-6)
    together = with_variants(LAW, "pinion", 3e-11, 3e-6)
    softer = LAW.replaced(compliance=LAW.compliance + 3e-11, gap=LAW.gap + 3e-6)
    damaged = tooth_terms(20, variant=1)
    a = LawEvaluator(both).evaluate(*states(), damaged, tooth_terms(55, variant=1))
    same(a, LawEvaluator(together).evaluate(*states(), damaged))
    assert a.force == pytest.approx(LawEvaluator(softer).evaluate(*states()).force, rel=6e-3)
    same(
        LawEvaluator(both).evaluate(*states()), LawEvaluator(LAW).evaluate(*states()), rel=1e-13
    )  # sound teeth do not notice


def test_least_clearance_is_a_bound():
    pinion, wheel = deviations(20, 1), deviations(55, 2)
    law = LAW.replaced(lead_gap=5e-6 * LAW.face_coordinate / FACE)
    bound = least_clearance(law, pinion, wheel)
    c = np.linspace(0, 220, 3001)
    start = LawEvaluator(law).no_load(c, 0.0, pinion, wheel)
    assert bound <= start.min() < bound + 2e-5
    assert (LawEvaluator(law).evaluate(c, bound, 0.0, pinion, wheel).force == 0.0).all()


def test_absurd_states_stay_finite():
    pinion, wheel = deviations(20, 1), deviations(55, 2)
    for delta in (-1e6, 0.0, 1e-15, 1e-3, 1.0, 1e6):
        for psi in (-1e3, 0.0, 1e-9, 10.0):
            r = LawEvaluator(LAW).evaluate([0.2, 1e7], delta, psi, pinion, wheel)
            assert all(np.isfinite(v).all() for v in r)
            assert (r.force >= 0.0).all()


def test_shares_sum_to_the_force_with_three_pairs_in_a_slice():
    law = made_up_law(gap=np.where(np.isinf(LAW.gap), np.inf, 0.0), slices=20)
    number, force = LawEvaluator(law).shares(0.3, 1e-5, 1e-4)
    assert force.sum() == pytest.approx(float(LawEvaluator(law).evaluate(0.3, 1e-5, 1e-4).force), rel=1e-12)
    assert (force > 0).sum() >= 3
    assert number[np.argmax(force)] in (0, 1)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: checked_terms("wheel", 20, np.zeros((20, 5))), "20, 6"),
        (lambda: LawEvaluator(LAW).evaluate(0.0, 1e-6, 0.0, tooth_terms(20, variant=1)), "has 0"),
        (lambda: with_variants(LAW, "wheel", -1e-12, 0.0), "softer"),
    ],
)
def test_impossible_teeth_are_refused(call, message):
    with pytest.raises(LawError, match=message):
        call()
