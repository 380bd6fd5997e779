"""Line loads: energy lost per gap opened; they sum to the pair forces, make the moment, and press as Hertz says."""

from __future__ import annotations

import numpy as np
import pytest
from mesh_laws import line_loads, made_up_law

from benchmarks.gear_pairs import gear_pair
from fem.contact.contact_pressure import contact_pressure
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.models.iso import Iso
from fem.contact.models.plane import Plane
from fem.contact.teeth import tooth_terms, with_variants


@pytest.fixture(scope="module")
def pair():
    return gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5))


@pytest.mark.parametrize("model", [Iso(), Plane(slices=9, refinement=0.6)], ids=["iso", "plane"])
@pytest.mark.parametrize("flank", ["drive", "coast"])
def test_loads_sum_to_the_forces_of_the_pairs_and_to_the_moment(pair, model, flank):
    law = model.law(pair, flank)
    cycle, delta, psi = 0.37, 8e-6, 4e-4
    pairs, loads = line_loads(LawEvaluator(law), cycle, delta, psi)
    numbers, force = LawEvaluator(law).shares(cycle, delta, psi)
    whole = LawEvaluator(law).evaluate(cycle, delta, psi)
    assert (loads * law.slice_width).sum(axis=1) == pytest.approx(force[np.isin(numbers, pairs)], rel=1e-6)
    assert (loads @ (law.slice_width * law.face_coordinate)).sum() == pytest.approx(float(whole.moment), rel=1e-6)


COUPLED = {
    "spread_compliance": np.full(201, 3e-11),
    "spread_length": 4e-3,
    "body_compliance": 8e-10,
    "skew_compliance": 1e-8,
    "tilt_compliance": 4e-6,
}


@pytest.mark.parametrize("coupling", [{}, COUPLED], ids=["independent slices", "coupled slices"])
@pytest.mark.parametrize("slices", [15, 33])
def test_a_line_load_is_what_the_energy_loses_per_gap_opened_there(coupling, slices):
    law, step, state = made_up_law(slices=slices, helix=1.0, neighbours=1, **coupling), 1e-9, (0.3, 1e-5, 1e-4)
    evaluator = LawEvaluator(law)
    pairs, loads = line_loads(evaluator, *state)
    assert pairs.size >= 3
    for s in (0, slices // 2, slices - 1):
        opened = np.where(np.arange(slices) == s, step, 0.0)[:, None]
        probe = LawEvaluator(with_variants(with_variants(law, "pinion", 0.0, opened), "pinion", 0.0, -opened))
        for pair, load in zip(pairs, loads[:, s], strict=True):
            tooth = np.arange(law.pinion_teeth) == pair % law.pinion_teeth
            energies = [
                probe.evaluate(*state, tooth_terms(law.pinion_teeth, variant=np.where(tooth, v, 0))).energy
                for v in (1, 2)
            ]
            lost = (energies[1] - energies[0]) / (2 * step * law.slice_width[s])
            assert load == pytest.approx(lost, rel=1e-6, abs=1e-6 * loads.max())


def test_a_missing_tooth_carries_nothing(pair):
    law = Iso().law(pair)
    gone = np.where(np.arange(pair.wheel.teeth) == 7, np.inf, 0.0)
    pairs, _ = line_loads(LawEvaluator(law), 7.1, 30e-6, 0.0, None, gone)
    assert 7 not in pairs
    assert pairs.size > 0


def test_pressure_at_the_pitch_point_is_that_of_two_cylinders(pair):
    law = Iso(slices=1).law(pair)
    load = 100e3 * pair.face_width
    curve = stiffness_curve(law, load, np.array([0.0]))
    pairs, loads = line_loads(LawEvaluator(law), 0.0, float(curve.transmission_error[0]))
    pressure = contact_pressure(pair, law, 0.0, pairs, loads)[list(pairs).index(0), 0]
    sine = np.sin(pair.working_pressure_angle)
    radii = [r * sine / np.cos(pair.base_helix_angle) for r in pair.working_radii]
    radius = radii[0] * radii[1] / (radii[0] + radii[1])
    steel = pair.pinion_material
    reduced = steel.elastic_modulus / (2 * (1 - steel.poisson_ratio**2))
    f = loads[list(pairs).index(0), 0]
    assert pressure == pytest.approx(np.sqrt(f * reduced / (np.pi * radius)), rel=1e-9)
