"""Mesh laws with coupling along the face: against a dense solution, one convex potential, limits, condensation."""

from types import SimpleNamespace

import numpy as np
import pytest
from mesh_laws import PLAIN, TERMS, TWO, gap_of_slice, line_loads, made_up_law, potential_errors, spared_approach
from scipy.optimize import root

from fem.contact.evaluation.evaluator import LawError, LawEvaluator
from fem.contact.models.solid_condensation import fit_terms

LAWS = {
    "usual": TWO.replaced(**TERMS),
    "three pairs": PLAIN.replaced(**TERMS),
    "body only": TWO.replaced(body_compliance=8e-10, tilt_compliance=4e-6),
    "spread only": TWO.replaced(spread_compliance=TERMS["spread_compliance"], spread_length=4e-3),
    "two blocks": made_up_law(slices=21, neighbours=1, helix=2.0).replaced(**TERMS),
}
EVERY_LAW = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())


def states(n=40, seed=3):
    draw = np.random.default_rng(seed)
    return draw.uniform(-30, 30, n), draw.uniform(-2e-6, 3e-5, n), draw.normal(0, 3e-4, n)


def influence(law):
    """N = inverse of w - a^2 d^2/dy^2 with free ends, from the equation in the module."""
    y, w = law.face_coordinate, law.slice_width
    n = np.diag(w).astype(float)
    for s in range(y.size - 1):
        n[s : s + 2, s : s + 2] += law.spread_length**2 / (y[s + 1] - y[s]) * np.array([[1, -1], [-1, 1]])
    return np.linalg.inv(n)


def dense(law, cycle, delta, psi):
    """F and M from all slices and pairs as one system, by an active set and a general root finder."""
    y, w = law.face_coordinate, law.slice_width
    grid = law.position_start + law.position_step * np.arange(law.gap.size)
    closed = np.isinf(law.gap)
    items = []
    for s in range(y.size):
        for p in range(int(np.floor(cycle)) - 4, int(np.floor(cycle)) + 5):
            xi = cycle - p + law.cycle_shift[s]
            cell = int((xi - grid[0]) / law.position_step) if grid[0] <= xi < grid[-1] else -1
            if cell >= 0 and not closed[cell : cell + 2].any() and np.interp(xi, grid, law.fraction) > 0:
                items.append((s, p, xi))
    s, p, xi = (np.array(v) for v in zip(*items, strict=True))

    def at(table):
        return np.interp(xi, grid, np.where(np.isinf(table), 0.0, table))

    g = np.sqrt(law.spread_compliance)
    g = np.interp(xi, grid, g)
    matrix = law.body_compliance + law.skew_compliance * np.add.outer(y[s], y[s])
    matrix = matrix + law.tilt_compliance * np.multiply.outer(y[s], y[s])
    matrix += (p[:, None] == p) * np.multiply.outer(g, g) * influence(law)[np.ix_(s, s)]
    ahead = np.where(p[:, None] < p, at(law.neighbour_compliance[0])[:, None], at(law.neighbour_compliance[0])[None, :])
    matrix += (s[:, None] == s) * (np.abs(p[:, None] - p) == 1) * ahead / w[s]
    phi, c, b, a = at(law.fraction), at(law.compliance), at(law.contact_offset), law.contact_slope
    gap, rise, even, whole = gap_of_slice(law, xi)
    x = delta + psi * y[s] - gap
    weight = phi * w[s]
    pairs, loads = line_loads(LawEvaluator(law), cycle, delta, psi)  # to start from: the conditions decide
    start = np.array([loads[pairs == q, t].sum() for q, t in zip(p, s, strict=True)]) / phi
    on, start = start > 0, np.where(start > 0, start, np.maximum(x + rise, 1e-7) / 3e-10)
    for _ in range(60):
        if not on.any():
            return 0.0, 0.0
        m = matrix[np.ix_(on, on)] * weight[on]

        def rest(log, on=on, m=m):
            f = np.exp(log)
            own = c[on] * f + a * f * (b[on] - log) - spared_approach(f, rise[on], even[on], whole[on])
            return (own + m @ f - x[on]) / 1e-6

        found = root(rest, np.log(start[on]), method="hybr", tol=1e-12)
        f = np.zeros(x.size)
        f[on] = np.exp(found.x)
        left = x + rise - matrix @ (weight * f)
        weak = on & (f < 1e-3 * f.max()) & (left <= 0)
        new = (on & ~weak) | (~on & (left > 1e-14))
        if np.abs(found.fun).max() < 1e-7 and (new == on).all():
            return float(weight @ f), float(weight @ (f * y[s]))
        on = new if (new != on).any() else on & (f > f[on].min())
    raise AssertionError("no set of contacts found")


@pytest.mark.parametrize("name", ["usual", "three pairs", "body only", "spread only"])
def test_coupled_slices_are_the_dense_solution(name):
    for state in ((0.1, 2e-5, 0.0), (0.62, 1.5e-5, 1e-4), (3.4, 2.5e-5, -2e-4)):
        r = LawEvaluator(LAWS[name]).evaluate(*state)
        force, moment = dense(LAWS[name], *state)
        assert float(r.force) == pytest.approx(force, rel=1e-6)
        assert float(r.moment) == pytest.approx(moment, rel=1e-5, abs=1e-6 * force * 0.03)


FIVE = np.linspace(-3.0, 3.0, 401)
FIVE_PAIRS = made_up_law(
    slices=7,
    neighbours=1,
    position_start=-3.0,
    position_step=0.015,
    compliance=6e-11 * (1 + 0.1 * FIVE**2),
    contact_offset=25 + 0.5 * np.sin(2 * FIVE),
    neighbour_compliance=np.array([1e-11 * (1 - 0.05 * FIVE)]),
    gap=np.where(np.abs(FIVE) < 2.4, 2e-7 * FIVE**2, np.inf),
    fraction=np.ones(FIVE.size),
    spread_compliance=np.zeros(FIVE.size),
)


@pytest.mark.slow
@pytest.mark.parametrize(
    "law",
    [FIVE_PAIRS, FIVE_PAIRS.replaced(body_compliance=8e-10, tilt_compliance=4e-6)],
    ids=["independent", "coupled"],
)
def test_five_pairs_in_a_slice_are_the_dense_solution(law):
    for state in ((0.1, 2e-5, 0.0), (0.62, 1.5e-5, 1e-4)):
        loads = line_loads(LawEvaluator(law), *state)[1]
        assert ((loads > 0.0).sum(axis=0) >= 4).all()
        r = LawEvaluator(law).evaluate(*state)
        force, moment = dense(law, *state)
        assert float(r.force) == pytest.approx(force, rel=1e-6)
        assert float(r.moment) == pytest.approx(moment, rel=1e-5, abs=1e-6 * force * 0.03)


def test_bodies_alone_are_the_plain_law_at_the_approach_they_leave():
    """Also where they tilt into contacts that the free approach leaves open."""
    law = TWO.replaced(body_compliance=8e-10, tilt_compliance=5e-4)
    c, delta, psi = states(60)
    r = LawEvaluator(law).evaluate(c, delta, psi)
    d, t = law.body_compliance * r.force, law.tilt_compliance * r.moment
    plain = LawEvaluator(TWO).evaluate(c, delta - d, psi - t)
    energy = plain.energy + (d * r.force + t * r.moment) / 2
    for found, exact in ((r.force, plain.force), (r.moment, plain.moment), (r.energy, energy)):
        assert found == pytest.approx(exact, rel=1e-9, abs=1e-10 * np.abs(exact).max())
    half = law.face_coordinate[-1]
    closed = (delta < np.abs(psi) * half) & (delta - d > np.abs(psi - t) * half)
    assert closed.sum() > 5


@EVERY_LAW
def test_every_derivative_is_that_of_one_potential(law):
    assert ((potential_errors(law, states()) <= 1e-5).mean(axis=1) >= 0.92).all()


@EVERY_LAW
def test_energy_is_convex_and_load_runs_from_nothing_to_absurd(law):
    c, delta, psi = states(60)
    _, other, tilt = states(60, seed=8)
    a, b = LawEvaluator(law).evaluate(c, delta, psi), LawEvaluator(law).evaluate(c, other, tilt)
    middle = LawEvaluator(law).evaluate(c, (delta + other) / 2, (psi + tilt) / 2)
    assert (middle.energy <= (a.energy + b.energy) / 2 * (1 + 1e-10)).all()
    assert (a.stiffness * a.tilt_stiffness >= a.cross_stiffness**2 * (1 - 1e-9)).all()
    rising = LawEvaluator(law).evaluate(0.2, np.logspace(-10, -2, 80), 1e-5)
    assert np.isfinite(rising.force).all()
    assert (np.diff(rising.force) > 0).all()


@EVERY_LAW
def test_shares_sum_to_the_force(law):
    for state in zip(*states(8), strict=True):
        assert LawEvaluator(law).shares(*state)[1].sum() == pytest.approx(
            float(LawEvaluator(law).evaluate(*state).force), rel=1e-9
        )


def test_a_stiff_face_and_a_short_length_are_the_limits():
    """a -> 0: the spread part is one more compliance of the slice; no helix, even load: any a is the same.

    A slice closes at a load that counts C without D: 1.04e-4 between both at first touch.
    """
    short = TWO.replaced(spread_compliance=np.full(201, 2e-11), spread_length=1e-7)
    local = TWO.replaced(compliance=TWO.compliance + 2e-11)
    assert LawEvaluator(short).evaluate(*states()).force == pytest.approx(
        LawEvaluator(local).evaluate(*states()).force, rel=2e-4
    )
    spur = made_up_law(slices=15, helix=0.0).replaced(spread_compliance=np.full(201, 2e-11))
    cycle = np.linspace(0, 1, 9)
    forces = [LawEvaluator(spur.replaced(spread_length=a)).evaluate(cycle, 1e-5).force for a in (1e-4, 5e-3, 1.0)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-9)
    assert forces[0] == pytest.approx(forces[2], rel=1e-6)


def synthetic(b=0.03, n=15):
    """A record that the law can hold exactly: body, spread bending with g(xi), an even local part."""
    y, w = (np.arange(n) + 0.5) / n * b - b / 2, np.full(n, b / n)
    shift = y / b * 0.8
    position, pair = np.arange(16) / 16, np.array([-1, 0, 1])
    xi = position[:, None, None] - pair[:, None] + shift
    law = SimpleNamespace(face_coordinate=y, slice_width=w, spread_length=4e-3)
    g = np.sqrt(3e-11) * (1 + 0.2 * xi + 0.1 * xi**2)
    compliance = np.zeros((16, 3, n, 3, n))
    compliance += (8e-10 + 1e-8 * np.add.outer(y, y) + 4e-6 * np.multiply.outer(y, y))[:, None, :]
    for p in range(3):
        own = compliance[:, p, :, p]  # a view
        own += g[:, p, :, None] * g[:, p, None, :] * influence(law)
        own += np.eye(n) * 5e-12 / w
    gap = np.where(np.abs(xi) < 0.9, 0.0, np.inf)
    record = {"position": position, "pair": pair, "face": y, "slice_width": w, "cycle_shift": shift, "gap": gap}
    return SimpleNamespace(compliance=compliance, contact_slope=3e-12, depth=4e-4, **record)


def test_condensation_finds_the_terms_it_is_made_of():
    xi = np.linspace(-0.85, 0.85, 60)
    found = fit_terms(synthetic(), xi)
    assert found["spread_length"] == pytest.approx(4e-3, rel=1e-6)
    assert found["spread_compliance"] == pytest.approx(3e-11 * (1 + 0.2 * xi + 0.1 * xi**2) ** 2, rel=1e-6)
    assert found["compliance"] == pytest.approx(np.full(60, 5e-12), rel=1e-4)
    assert found["body_compliance"] == pytest.approx(8e-10, rel=1e-6)
    assert found["skew_compliance"] == pytest.approx(1e-8, rel=1e-6)
    assert found["tilt_compliance"] == pytest.approx(4e-6, rel=1e-6)
    assert np.abs(found["neighbour_compliance"]).max() < 1e-15


def test_body_terms_that_are_not_positive_are_refused():
    with pytest.raises(LawError, match="skew_compliance"):
        LawEvaluator(TWO.replaced(body_compliance=1e-10, skew_compliance=1e-6, tilt_compliance=1e-6)).evaluate(
            0.0, 1e-6
        )
    with pytest.raises(LawError, match="negative"):
        LawEvaluator(TWO.replaced(body_compliance=-1e-10)).evaluate(0.0, 1e-6)
