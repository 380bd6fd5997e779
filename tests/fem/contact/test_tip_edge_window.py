"""Where the table of tip-edge contact ends: up to the force of the warning no tooth pair comes into contact loaded."""

import logging

import numpy as np
import pytest

from benchmarks.gear_pairs import gear_pair
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.faults.changed_law import modified_law
from fem.contact.models.plane import Plane
from fem.gears.modifications import FlankModifications, PairModifications, Relief

PAIR = gear_pair((20, 55), 2, 0, 12, bores_mm=(12.5, 17.5))
SHAPES = {
    "involute": FlankModifications(),
    "misaligned": FlankModifications(helix_slope=40e-6),
    "relieved": FlankModifications(tip_relief=Relief(amount=30e-6, length=2e-3)),
}


@pytest.fixture(scope="module")
def law():
    return Plane(slices=7, refinement=0.5).laws(PAIR)[0]


def named_force(law, caplog, force, **options):
    """Force (N) that the warning about `force` gives; None without one."""
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        stiffness_curve(law, force, np.linspace(0.0, 1.0, 100, endpoint=False), **options)
    return caplog.records[-1].args[-1] if caplog.records else None


@pytest.mark.parametrize("shape", SHAPES)
def test_pairs_come_into_contact_without_load_up_to_the_force_of_the_warning(law, caplog, shape):
    """Pair 0 enters and leaves at the ends of the table: free there below the force, loaded well above it."""
    law = modified_law(law, PAIR, PairModifications(pinion=SHAPES[shape]))
    force = named_force(law, caplog, 100e3)
    assert named_force(law, caplog, 0.99 * force) is None
    assert named_force(law, caplog, 1.01 * force) == pytest.approx(force, rel=1e-3)
    ends = law.position_start + law.position_step * np.flatnonzero(np.isfinite(law.gap))[[1, -2]]
    evaluator, loaded = LawEvaluator(law), []
    for factor in (0.99, 3.0):
        delta = evaluator.approach_at(factor * force, ends)
        shares = [dict(zip(*evaluator.shares(c, d), strict=True)) for c, d in zip(ends, delta, strict=True)]
        loaded.append(max(share.get(0, 0.0) for share in shares) / force)
    assert loaded[0] == 0.0
    assert loaded[1] > 1e-3


def test_usual_loads_give_no_warning(law, caplog):
    """1000 N/mm on a module of 2 mm break the teeth; deviations of 20 um and a missing tooth stay in the table."""
    deviations = np.random.default_rng(1).uniform(-20e-6, 20e-6, 20)
    deviations[3] = np.inf
    assert named_force(law, caplog, 12e3) is None
    assert named_force(law, caplog, 2e3, clearance_pinion=deviations, psi=2e-3) is None
