"""Line loads by virtual work: they sum to the pair forces, make the moment, and press as Hertz says."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.gear_pairs import gear_pair
from fem.contact.evaluation.curves import stiffness_curve
from fem.contact.evaluation.evaluator import evaluate_law, shares
from fem.contact.evaluation.line_loads import contact_pressure, line_loads
from fem.contact.models.iso import Iso
from fem.contact.models.plane import Plane


@pytest.fixture(scope="module")
def pair():
    return gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5))


@pytest.mark.parametrize("model", [Iso(), Plane(slices=9, refinement=0.6)], ids=["iso", "plane"])
@pytest.mark.parametrize("flank", ["drive", "coast"])
def test_loads_sum_to_the_forces_of_the_pairs_and_to_the_moment(pair, model, flank):
    law = model.law(pair, flank)
    cycle, delta, psi = 0.37, 8e-6, 4e-4
    pairs, loads = line_loads(law, cycle, delta, psi)
    numbers, force = shares(law, cycle, delta, psi)
    whole = evaluate_law(law, cycle, delta, psi)
    assert (loads * law.slice_width).sum(axis=1) == pytest.approx(force[np.isin(numbers, pairs)], rel=1e-6)
    assert (loads @ (law.slice_width * law.face_coordinate)).sum() == pytest.approx(float(whole.moment), rel=1e-6)


def test_a_missing_tooth_carries_nothing(pair):
    law = Iso().law(pair)
    gone = np.where(np.arange(pair.wheel.teeth) == 7, np.inf, 0.0)
    pairs, _ = line_loads(law, 7.1, 30e-6, 0.0, None, gone)
    assert 7 not in pairs
    assert pairs.size > 0


def test_pressure_at_the_pitch_point_is_that_of_two_cylinders(pair):
    law = Iso(slices=1).law(pair)
    load = 100e3 * pair.face_width
    curve = stiffness_curve(law, load, np.array([0.0]))
    pairs, loads = line_loads(law, 0.0, float(curve.transmission_error[0]))
    pressure = contact_pressure(pair, law, 0.0, pairs, loads)[list(pairs).index(0), 0]
    sine = np.sin(pair.working_pressure_angle)
    radii = [r * sine / np.cos(pair.base_helix_angle) for r in pair.working_radii]
    radius = radii[0] * radii[1] / (radii[0] + radii[1])
    steel = pair.pinion_material
    reduced = steel.elastic_modulus / (2 * (1 - steel.poisson_ratio**2))
    f = loads[list(pairs).index(0), 0]
    assert pressure == pytest.approx(np.sqrt(f * reduced / (np.pi * radius)), rel=1e-9)
