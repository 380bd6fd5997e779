"""Damage that adds compliance by modes: one convex potential, the bodies as a special case, sound teeth untouched."""

import numpy as np
import pytest
from mesh_laws import PLAIN, TERMS, TWO, XI, line_loads, made_up_law, potential_errors
from numba import njit

from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.law_tables import pack, unpacked
from fem.contact.teeth import tooth_terms, with_variants

LAWS = {
    "usual": TWO.replaced(**TERMS),
    "three pairs": PLAIN.replaced(**TERMS),
    "modes alone": TWO,
    "two blocks": made_up_law(slices=21, neighbours=1, helix=2.0).replaced(**TERMS),
    "neighbours that pull": TWO.replaced(**TERMS, neighbour_compliance=-0.1 * TWO.neighbour_compliance),
}
EVERY_LAW = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
TOOTH = 3


def cracked(law, strength=1.0, gear="pinion"):
    """The law with a tooth form whose three modes differ along face and path and change sign."""
    y = law.face_coordinate / law.slice_width.sum()
    along, side = np.meshgrid(y, XI, indexing="ij"), np.array([0.15, 1.0, -0.1])
    shapes = [1 + along[0] + 0.4 * along[1], along[0] * (1 - 0.3 * along[1]), 0.3 * np.sin(3 * along[0] + along[1])]
    modes = strength * 2.5e-5 * side[:, None, None] * np.array(shapes)[:, None]
    return with_variants(law, gear, 0.0, 0.0, modes)


def teeth(law, gear="pinion", tooth=TOOTH):
    count = getattr(law, f"{gear}_teeth")
    return tooth_terms(count, variant=np.eye(count)[tooth])


def states(n=40, seed=3):
    draw = np.random.default_rng(seed)
    return draw.uniform(TOOTH - 3, TOOTH + 3, n), draw.uniform(-2e-6, 3e-5, n), draw.normal(0, 3e-4, n)


@EVERY_LAW
def test_force_moment_and_slopes_are_derivatives_of_one_energy(law):
    law = cracked(law)
    errors = potential_errors(law, states(), teeth(law))
    assert np.median(errors, axis=1).max() < 2e-6
    assert (errors < 1e-3).mean() > 0.9


@pytest.mark.slow
@EVERY_LAW
def test_the_energy_is_convex_in_approach_and_tilt(law):
    law = cracked(law, 2.0)
    r = LawEvaluator(law).evaluate(*states(80, 5), teeth(law))
    scale = r.stiffness.max()
    assert (r.force >= 0).all()
    assert (r.stiffness >= -1e-12 * scale).all()
    assert (r.stiffness * r.tilt_stiffness - r.cross_stiffness**2 >= -1e-9 * scale**2 * 1e-4).all()


def test_a_mode_that_is_one_everywhere_is_a_body():
    """While no pair beyond the neighbours of the damaged tooth is near."""
    law, softer = LAWS["usual"], LAWS["usual"].replaced(body_compliance=8e-10 + 5e-10)
    with_mode = with_variants(law, "pinion", 0.0, 0.0, np.full((1, 3, 15, XI.size), np.sqrt(5e-10)))
    _, delta, psi = states(30)
    cycle = np.random.default_rng(7).uniform(TOOTH - 0.05, TOOTH + 0.05, 30)
    found = LawEvaluator(with_mode).evaluate(cycle, delta, psi, teeth(law))
    exact = LawEvaluator(softer).evaluate(cycle, delta, psi)
    for one, other in zip(found, exact, strict=True):
        assert one == pytest.approx(other, rel=1e-7, abs=1e-9 * np.abs(other).max())


@EVERY_LAW
def test_modes_soften_and_vanish_with_their_strength(law):
    cycle, delta, psi = states(40)
    sound = LawEvaluator(law).evaluate(cycle, delta, psi)
    energies = [
        LawEvaluator(cracked(law, strength)).evaluate(cycle, delta, psi, teeth(law)).energy
        for strength in (2.0, 1.0, 0.3, 1e-4)
    ]
    for softer, stiffer in zip(energies, [*energies[1:], sound.energy], strict=True):
        assert (softer <= stiffer * (1 + 1e-9) + 1e-12).all()
    assert energies[-1] == pytest.approx(sound.energy, rel=1e-6)


def test_away_from_the_damaged_tooth_the_law_is_the_sound_one_bit_for_bit():
    law = LAWS["usual"]
    cycle = np.linspace(8.0, 15.0, 50)
    found = LawEvaluator(cracked(law)).evaluate(cycle, 2e-5, 1e-4, teeth(law))
    sound = LawEvaluator(law).evaluate(cycle, 2e-5, 1e-4)
    for one, other in zip(found, sound, strict=True):
        assert (one == other).all()


def test_line_loads_carry_the_force():
    law = cracked(LAWS["usual"], 2.0, "wheel")
    terms = teeth(law, "wheel")
    evaluator = LawEvaluator(law)
    for state in ((TOOTH - 0.3, 2e-5, 0.0), (TOOTH + 0.6, 1.5e-5, 2e-4)):
        loads = line_loads(evaluator, *state, wheel=terms)[1]
        assert (loads @ law.slice_width).sum() == pytest.approx(float(evaluator.evaluate(*state, wheel=terms).force))


@pytest.mark.slow
def test_a_mode_that_tips_the_tooth_finds_the_contacts_that_it_closes():
    """Pressed at one end, the other end comes out by more than the approach there was: the load returns to it."""
    law = LAWS["modes alone"]
    y = law.face_coordinate / law.slice_width.sum()
    tipping = with_variants(law, "pinion", 0.0, 0.0, np.broadcast_to((6e-4 * y)[:, None], (1, 3, 15, XI.size)))
    state = (float(TOOTH), 1e-6, 2e-3)
    free = state[1] + state[2] * law.face_coordinate
    found = line_loads(LawEvaluator(tipping), *state, teeth(law))[1].sum(axis=0)
    assert ((found > 0) & (free < 0)).any()
    exact = potential_errors(tipping, tuple(np.array([v]) for v in state), teeth(law))
    assert exact[:2].max() < 1e-5


def test_the_compiled_code_finds_the_tables_of_both_gears():
    @njit
    def last_tables(packed):
        law = unpacked(packed)
        return law.wheel_gap.copy(), law.pinion_mode.copy(), law.wheel_mode.copy()

    law = cracked(cracked(PLAIN, 1.0), 2.0, "wheel")
    gap, *modes = last_tables(pack(law))
    np.testing.assert_array_equal(gap, law.wheel_variant_gap)
    for found, table in zip(modes, (law.pinion_variant_modes, law.wheel_variant_modes), strict=True):
        np.testing.assert_array_equal(found, np.moveaxis(table, 1, -1))
