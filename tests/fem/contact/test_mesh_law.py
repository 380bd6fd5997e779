"""Evaluation of a mesh law: contact conditions, one convex potential, exact derivatives, clearances, limits."""

import itertools
import math

import numpy as np
import pytest
from mesh_laws import gap_of_slice, made_up_law, missing_tooth, potential_errors, spared_approach
from scipy.integrate import trapezoid
from scipy.optimize import root

from fem.contact.evaluation.evaluator import LawError, LawEvaluator
from fem.contact.evaluation.kernel import evaluate
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.teeth import tooth_terms

LAWS = {
    "linear": made_up_law(hertz=0.0, neighbours=0),
    "coupled": made_up_law(hertz=0.0),
    "hertz": made_up_law(neighbours=0),
    "hertz coupled": made_up_law(),
    "coast": made_up_law(flank="coast", cycle_sign=-1, cycle_offset=0.48, wheel_tooth_offset=1),
    "pulling neighbours": made_up_law(neighbour_compliance=-0.1 * made_up_law().neighbour_compliance),
}
EVERY_LAW = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())


def random_states(n=60, seed=3):
    draw = np.random.default_rng(seed)
    return draw.uniform(-30, 30, n), draw.uniform(-2e-6, 3e-5, n), draw.normal(0, 3e-4, n)


def clearances(seed=5):
    draw = np.random.default_rng(seed)
    return draw.normal(0, 2e-6, 20), missing_tooth(draw.normal(0, 2e-6, 55), 7)


def reference_force(law, cycle, delta, psi, h1, h2):
    """F by trying every set of loaded pairs in every slice with a general root finder."""
    grid = law.position_start + law.position_step * np.arange(law.gap.size)
    total = 0.0
    for y, width, shift in zip(law.face_coordinate, law.slice_width, law.cycle_shift, strict=True):
        place = law.cycle_sign * cycle + law.cycle_offset + shift
        pairs, data = [], []
        for p in range(math.ceil(place - grid[-1]), math.floor(place - grid[0]) + 1):
            xi = place - p

            def at(table, xi=xi):
                return np.interp(xi, grid, table)

            h = h1[(law.cycle_sign * p) % 20] + h2[(law.cycle_sign * p + law.wheel_tooth_offset) % 55]
            with np.errstate(invalid="ignore"):
                gap, rise, even, whole = gap_of_slice(law, xi)
                x = delta + psi * y - (gap if np.isfinite(at(law.gap)) else np.inf) - h
            if np.isfinite(x) and at(law.fraction) > 0:
                pairs.append(p)
                data.append(
                    [
                        x,
                        at(law.compliance),
                        at(law.contact_offset),
                        at(law.fraction),
                        rise,
                        even,
                        whole,
                        *map(at, law.neighbour_compliance),
                    ]
                )
        total += width * solve_by_enumeration(law, pairs, data)
    return total


def solve_by_enumeration(law, pairs, data):
    n, slope = len(pairs), law.contact_slope
    coupling = np.zeros((n, n))
    for a, b in itertools.combinations(range(n), 2):
        apart = pairs[b] - pairs[a]
        if len(data[a]) > 6 + apart:
            coupling[a, b] = coupling[b, a] = data[a][6 + apart]
    x, compliance, offset, phi, rise, even, whole = np.array([d[:7] for d in data]).reshape(n, 7).T
    for size in range(n, -1, -1):
        for chosen in map(list, itertools.combinations(range(n), size)):
            if size and (x + rise)[chosen].max() <= 0 and coupling.min() >= 0:
                continue

            def rest(log_f, chosen=chosen):
                f = np.exp(log_f)
                own = compliance[chosen] * f + slope * f * (offset[chosen] - log_f)
                own = own - spared_approach(f, rise[chosen], even[chosen], whole[chosen])
                return (own + coupling[np.ix_(chosen, chosen)] @ (phi[chosen] * f) - x[chosen]) * 1e6

            f = np.zeros(n)
            if size:
                with np.errstate(over="ignore", invalid="ignore"):
                    found = root(rest, np.full(size, 11.0), tol=1e-13)
                if np.abs(found.fun).max() > 1e-7:
                    continue
                f[chosen] = np.exp(found.x)
            idle = [p for p in range(n) if p not in chosen]
            if ((x + rise)[idle] - coupling[idle] @ (phi * f) <= 1e-12).all():
                return float(phi @ f)
    raise AssertionError("no set of pairs satisfies the contact conditions")


@EVERY_LAW
def test_force_satisfies_the_contact_conditions(law):
    h1, h2 = clearances()
    for state in zip(*random_states(6), strict=True):
        found = float(LawEvaluator(law).evaluate(*state, h1, h2).force)
        assert found == pytest.approx(reference_force(law, *state, h1, h2), rel=1e-6, abs=1e-3)


@EVERY_LAW
def test_every_derivative_is_that_of_one_potential(law):
    errors = potential_errors(law, random_states(), *clearances())
    assert ((errors <= 1e-5).mean(axis=1) >= 0.95).all()  # the rest stand on a kink
    assert errors.max() <= 0.05


@EVERY_LAW
def test_energy_is_convex_and_force_never_negative(law):
    c, delta, psi = random_states(200)
    _, other, tilt = random_states(200, seed=8)
    h = clearances()
    a, b = LawEvaluator(law).evaluate(c, delta, psi, *h), LawEvaluator(law).evaluate(c, other, tilt, *h)
    middle = LawEvaluator(law).evaluate(c, (delta + other) / 2, (psi + tilt) / 2, *h)
    assert (middle.energy <= (a.energy + b.energy) / 2 * (1 + 1e-12)).all()
    assert (a.force >= 0).all()
    assert (a.stiffness >= 0).all()
    assert (a.stiffness * a.tilt_stiffness >= a.cross_stiffness**2 * (1 - 1e-9)).all()


@EVERY_LAW
def test_shares_sum_to_the_force(law):
    h = clearances()
    for c, delta, psi in zip(*random_states(20), strict=True):
        _, force = LawEvaluator(law).shares(c, delta, psi, *h)
        assert force.sum() == pytest.approx(float(LawEvaluator(law).evaluate(c, delta, psi, *h).force), rel=1e-12)
        assert (force >= 0).all()


@EVERY_LAW
def test_period_is_one_cycle_without_deviations(law):
    c, delta, psi = random_states()
    here, there = LawEvaluator(law).evaluate(c, delta, psi), LawEvaluator(law).evaluate(c + 7, delta, psi)
    for a, b in zip(here, there, strict=True):
        assert a == pytest.approx(b, rel=1e-9, abs=1e-9 * np.abs(a).max())


def test_no_contact_gives_zeros():
    response = LawEvaluator(LAWS["hertz coupled"]).evaluate(0.3, -1e-3)
    assert all(value == 0.0 for value in response)
    every_tooth_missing = LawEvaluator(LAWS["hertz coupled"]).evaluate(
        0.3, 1e-5, 0.0, np.full(20, np.inf), np.zeros(55)
    )
    assert every_tooth_missing.force == 0.0


def test_hertz_line_contact_of_a_single_pair():
    """One slice, one pair: x = C f + A f (B - ln f) and its energy, integrated numerically."""
    law = made_up_law(slices=1, helix=0.0, n=301)
    only = missing_all_but(20, 3)
    middle = round(-law.position_start / law.position_step)
    compliance, offset = law.compliance[middle], law.contact_offset[middle]
    f = 2e5
    x = compliance * f + law.contact_slope * f * (offset - math.log(f))
    response = LawEvaluator(law).evaluate(3.0, x, 0.0, only, np.zeros(55))
    assert float(response.force) == pytest.approx(0.03 * f, rel=1e-13)
    load = np.linspace(0.0, f, 200001)[1:]
    approach = compliance * load + law.contact_slope * load * (offset - np.log(load))
    energy = trapezoid(x - approach, load) * 0.03
    assert float(response.energy) == pytest.approx(energy, rel=1e-4)


def missing_all_but(teeth, kept):
    h = np.full(teeth, np.inf)
    h[kept] = 0.0
    return h


def test_a_missing_tooth_acts_in_its_window_only():
    law = LAWS["hertz coupled"]
    cycle = np.linspace(-4, 4, 401)
    whole = LawEvaluator(law).evaluate(cycle, 1e-5).force
    broken = LawEvaluator(law).evaluate(cycle, 1e-5, 0.0, None, missing_tooth(np.zeros(55), 0)).force
    reach = 1.5 + 0.5  # half the grid and half the overlap
    assert np.array_equal(whole[np.abs(cycle) > reach], broken[np.abs(cycle) > reach])
    assert (broken[np.abs(cycle) < 0.7] < 0.8 * whole[np.abs(cycle) < 0.7]).all()
    assert (broken <= whole * (1 + 1e-12)).all()
    # pinion tooth 3 meets wheel tooth 3 in cycle 3, wheel tooth 23 in cycle 23
    again = LawEvaluator(law).evaluate(23.0, 1e-5, 0.0, missing_tooth(np.zeros(20), 3), None).force
    assert again == pytest.approx(
        LawEvaluator(law).evaluate(23.0, 1e-5, 0.0, None, missing_tooth(np.zeros(55), 23)).force
    )


def test_coast_is_the_mirror_image_of_drive():
    drive = LAWS["hertz coupled"]
    coast = drive.replaced(
        flank="coast", cycle_sign=-1, cycle_offset=0.48, wheel_tooth_offset=1, cycle_shift=-drive.cycle_shift
    )
    c, delta, psi = random_states()
    a, b = LawEvaluator(coast).evaluate(c, delta, psi), LawEvaluator(drive).evaluate(0.48 - c, delta, -psi)
    assert a.force == pytest.approx(b.force, rel=1e-12)
    assert a.moment == pytest.approx(-b.moment, rel=1e-9, abs=1e-9)
    assert a.energy == pytest.approx(b.energy, rel=1e-9)


def test_the_force_keeps_rising_at_absurd_loads():
    delta = np.logspace(-9, 1, 200)
    r = LawEvaluator(LAWS["hertz coupled"]).evaluate(0.2, delta, 0.0)
    assert np.isfinite(r.force).all()
    assert (np.diff(r.force) > 0).all()
    assert (np.diff(r.energy) > 0).all()


def test_compiled_call_and_array_call_agree():
    law = LAWS["hertz coupled"]
    direct = evaluate(LawEvaluator(law).packed, 12.3, 1.1e-5, 2e-4, tooth_terms(20), tooth_terms(55))
    whole = LawEvaluator(law).evaluate(12.3, 1.1e-5, 2e-4)
    assert direct == pytest.approx([float(v) for v in whole[:6]], rel=1e-15)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"compliance": np.full(201, -1e-11)}, "compliance"),
        ({"contact_slope": -1e-12}, "contact_slope"),
        ({"position_step": 0.1}, "span"),
        ({"cycle_sign": 2}, "cycle_sign"),
        ({"fraction": np.full(201, 1.5)}, "fraction"),
    ],
)
def test_impossible_laws_are_refused(changes, message):
    with pytest.raises(LawError, match=message):
        LawEvaluator(made_up_law(**changes)).evaluate(0.0, 1e-6)


def test_bad_clearances_and_states_are_refused():
    law = LAWS["linear"]
    with pytest.raises(LawError, match="20 teeth"):
        LawEvaluator(law).evaluate(0.0, 1e-6, 0.0, np.zeros(7))
    with pytest.raises(LawError, match="delta is not finite"):
        LawEvaluator(law).evaluate(0.0, np.nan)


# curves


@pytest.mark.parametrize("psi", [0.0, 2e-4, None])
def test_curve_solves_for_the_load(psi):
    law, h = LAWS["hertz coupled"], clearances()
    curve = stiffness_curve(law, 3000.0, np.linspace(5, 9, 41), psi=psi, clearance_pinion=h[0], clearance_wheel=h[1])
    r = LawEvaluator(law).evaluate(curve.cycle, curve.transmission_error, curve.tilt, *h)
    assert r.force == pytest.approx(np.full(41, 3000.0), rel=1e-9)
    assert curve.tangent == pytest.approx(r.stiffness, rel=1e-12)
    assert curve.secant * (curve.transmission_error - curve.no_load_error) == pytest.approx(np.full(41, 3000.0))
    assert curve.share.sum(axis=1) == pytest.approx(np.ones(41), rel=1e-9)
    if psi is None:
        assert np.abs(curve.centroid).max() < 1e-9
    else:
        assert (curve.tilt == psi).all()


def test_no_load_error_is_where_contact_begins():
    law, h = LAWS["hertz coupled"], clearances()
    cycle = np.linspace(3, 12, 91)
    for psi in (0.0, -3e-4):
        start = LawEvaluator(law).no_load(cycle, psi, *h)
        assert (LawEvaluator(law).evaluate(cycle, start - 1e-12, psi, *h).force == 0.0).all()
        assert (LawEvaluator(law).evaluate(cycle, start + 1e-9, psi, *h).force > 0.0).all()


@EVERY_LAW
def test_approach_at_a_load_carries_it(law):
    evaluator, cycle = LawEvaluator(law), np.linspace(3, 12, 31)
    for force in (1e-3, 3e3, 1e6):
        delta = evaluator.approach_at(force, cycle, 1e-4, *clearances())
        assert evaluator.evaluate(cycle, delta, 1e-4, *clearances()).force == pytest.approx(force, rel=1e-9)


def test_no_tooth_in_reach_is_an_error():
    h2 = np.zeros(55)
    h2[:5] = np.inf
    with pytest.raises(LawError, match="no tooth pair can touch at cycle 2"):
        stiffness_curve(LAWS["linear"], 100.0, np.array([2.0]), clearance_wheel=h2)
    with pytest.raises(LawError, match="finite force"):
        stiffness_curve(LAWS["linear"], 0.0)
