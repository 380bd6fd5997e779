"""Extreme gear pairs on every model: finite, convex, converged laws of one potential, or a refusal in words.

z 12 (undercut) to 250, beta 0 to 35 degrees, b / m_n 2 to 40, rims down to 1.2 m_n; loads from nothing to 100 times the
nominal one; a tilt that unloads half of the face; spur limit, exchange of pinion and wheel, mirror image.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.gear_pairs import gear_pair
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.models.energy import Energy
from fem.contact.models.iso import Iso
from fem.contact.models.plane import Plane
from fem.contact.models.solid import Solid
from fem.contact.slice_frame import ModelError
from fem.gears.geometry import GearPair

NOMINAL = 100e3  # N/m
PAIRS = {
    "z 12, undercut, rim 1.2": gear_pair((12, 30), 2, 0, 12, bores_mm=(6.35, 15)),
    "z 12 and 250": gear_pair((12, 250), 2, 15, 12, bores_mm=(6.5, 230)),
    "beta 35, b / m_n 40": gear_pair((12, 55), 2, 35, 80, bores_mm=(8, 20)),
    "b / m_n 2": gear_pair((12, 55), 2, 35, 4, bores_mm=(8, 20)),
    "spur, b / m_n 2": gear_pair((20, 55), 2, 0, 4, bores_mm=(12.5, 17.5)),
    "z 250": gear_pair((250, 250), 2, 0, 12, bores_mm=(200, 200)),
    "rims of 1.2 and 4 m_n": gear_pair((20, 250), 2, 20, 30, bores_mm=(16.3, 240)),
    "usual": gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5)),
}
MODELS = {
    "iso": Iso(slices=5, line_load=NOMINAL),
    "energy": Energy(slices=5),
    "plane": Plane(refinement=0.5, slices=5, patch=0.08),
    "solid": Solid(refinement=0.6, slices=5, positions=16),
}
FAST = ("iso", "energy", "plane")
EVERY_RUNG = pytest.mark.parametrize("model", [*FAST, pytest.param("solid", marks=pytest.mark.slow)])
EVERY_PAIR = pytest.mark.parametrize("name", PAIRS)


@cache
def laws(model: str, pair: GearPair):
    """Both flanks; the refusal where the model does not take the pair."""
    chosen = MODELS[model]
    try:
        return chosen.laws(pair) if hasattr(chosen, "laws") else (chosen.law(pair, "drive"), chosen.law(pair, "coast"))
    except ModelError as error:
        return error


def law_of(model: str, pair: GearPair, flank: str = "drive"):
    """The law of a flank; a refusal ends the test once it is seen to give its reason."""
    found = laws(model, pair)
    if isinstance(found, ModelError):
        assert len(str(found)) > 40
        pytest.skip(f"refused: {found}")
    return found[flank == "coast"]


def states(law, count: int, seed: int = 3):
    """Cycles, approaches from apart to heavily pressed, and tilts of up to a whole approach over the face."""
    draw = np.random.default_rng(seed)
    load = 100.0 * NOMINAL * law.slice_width.sum()
    heavy = stiffness_curve(law, load, np.linspace(0, 1, 5)).transmission_error.max()
    delta = heavy * draw.uniform(-0.1, 1.0, count) ** 3
    return draw.uniform(-3, 3, count), delta, draw.uniform(-1, 1, count) * delta / law.slice_width.sum()


@EVERY_RUNG
@EVERY_PAIR
def test_every_force_and_moment_is_that_of_one_convex_potential(model, name):
    law = law_of(model, PAIRS[name])
    c, delta, psi = states(law, 200)
    _, other, tilt = states(law, 200, seed=8)
    here, there = LawEvaluator(law).evaluate(c, delta, psi), LawEvaluator(law).evaluate(c, other, tilt)
    middle = LawEvaluator(law).evaluate(c, (delta + other) / 2, (psi + tilt) / 2)
    for found in (here, there, middle):
        assert np.isfinite(np.stack(found)).all()
        assert (found.force >= 0).all()
        assert (found.stiffness >= 0).all()
    assert (middle.energy <= (here.energy + there.energy) / 2 * (1 + 1e-12)).all()
    assert (here.stiffness * here.tilt_stiffness >= here.cross_stiffness**2 * (1 - 1e-9)).all()
    apart = 1e-4 * np.maximum(np.abs(delta), 1e-7)
    face = law.slice_width.sum()
    for exact, field, dd, dp in (
        (here.force, "energy", apart, 0.0),
        (here.moment, "energy", 0.0, apart / face),
        (here.cross_stiffness, "moment", apart, 0.0),
        (here.cross_stiffness, "force", 0.0, apart / face),
    ):
        ahead, behind = (LawEvaluator(law).evaluate(c, delta + s * dd, psi + s * dp) for s in (1, -1))
        numeric = (getattr(ahead, field) - getattr(behind, field)) / (2 * (dd + dp))
        close = np.abs(exact - numeric) <= 1e-4 * np.abs(exact) + 1e-6 * np.abs(exact).max()
        assert close.mean() >= 0.95, field  # the rest stand where a slice of a pair is just touching
    print(f"{model}, {name}: {3 * c.size} states")


@EVERY_RUNG
@EVERY_PAIR
def test_from_no_load_to_a_hundred_times_the_nominal_one(model, name):
    law = law_of(model, PAIRS[name])
    face = law.slice_width.sum()
    cycle = np.linspace(0, 1, 9)
    light, usual, heavy = (stiffness_curve(law, load * NOMINAL * face, cycle) for load in (1e-6, 1.0, 100.0))
    assert (light.transmission_error - light.no_load_error).max() < 1e-3 * usual.transmission_error.max()
    assert np.abs(light.no_load_error).max() < 1e-9  # on the path of contact a sound pair without error has no gap
    assert light.secant.mean() <= usual.secant.mean() * (1 + 1e-12)
    assert usual.secant.mean() <= heavy.secant.mean() * (1 + 1e-12)
    least = 0.5e9 if face < 5e-3 else 5e9  # in space a helical wheel as thin as 4 mm also bends out of its plane
    assert least < usual.secant.mean() / face < 30e9
    for curve in (usual, heavy):
        assert np.abs(curve.share.sum(axis=1) - 1).max() < 1e-9


@EVERY_RUNG
@EVERY_PAIR
def test_a_tilt_that_unloads_half_of_the_face_moves_the_load(model, name):
    law = law_of(model, PAIRS[name])
    y, face = law.face_coordinate, law.slice_width.sum()
    curve = stiffness_curve(law, NOMINAL * face, np.linspace(0, 1, 9), psi=0.0)
    psi = 10 * curve.transmission_error.max() / face  # an even line of stiffness is half unloaded at 8 e / b
    tilted = stiffness_curve(law, NOMINAL * face, curve.cycle, psi=psi)
    apart = tilted.transmission_error[:, None] + psi * y <= 0
    assert (apart.mean(axis=1) >= 0.4).all()  # two of five slices
    assert (tilted.centroid > curve.centroid).all()
    assert (tilted.centroid > 0.1 * face).all()
    assert (tilted.secant < curve.secant).all()
    for c, delta in zip(tilted.cycle, tilted.transmission_error, strict=True):
        assert LawEvaluator(law).shares(c, delta, psi)[1].sum() == pytest.approx(NOMINAL * face, rel=1e-9)


@EVERY_RUNG
@EVERY_PAIR
def test_a_left_hand_pair_is_the_mirror_image(model, name):
    """Mirror in the plane of the axes: the coast flank at -c. Tilting a pair the other way is its own other flank."""
    pair = PAIRS[name]
    drive, coast = law_of(model, pair), law_of(model, pair, "coast")
    hands = [replace(gear, hand=hand) for gear, hand in ((pair.pinion, "left"), (pair.wheel, "right"))]
    left = law_of(model, replace(pair, pinion=hands[0], wheel=hands[1]), "coast")
    c, delta, psi = states(drive, 60)
    there = pair.thickness_cycle - c  # cycle of the coast flank, which trails by the thickness of a tooth
    one = LawEvaluator(drive).evaluate(c, delta, psi)
    for law, sign in ((left, 1), (coast, -1)):
        other = LawEvaluator(law).evaluate(there, delta, sign * psi)
        for a, b in ((one.force, other.force), (one.moment, sign * other.moment), (one.energy, other.energy)):
            assert b == pytest.approx(a, rel=1e-7, abs=1e-9 * np.abs(a).max())


@pytest.mark.parametrize("model", ["energy", "plane", pytest.param("solid", marks=pytest.mark.slow)])
@EVERY_PAIR
def test_exchange_of_pinion_and_wheel_runs_the_law_backwards(model, name):
    """Seen turned by half a turn about the shafts: equal at -c on the path of contact.

    The gap of a tip edge is measured by turning the wheel, so beyond the path only to second order: light loads, which
    hardly reach it. Not for `iso`: the series of the standard weighs the teeth of pinion and wheel differently.
    """
    pair = PAIRS[name]
    law, other = law_of(model, pair), law_of(model, GearPair(pinion=pair.wheel, wheel=pair.pinion))
    cycle = np.linspace(0, 1, 17)[:-1] + 1 / 64
    load = NOMINAL * pair.face_width / 10
    for psi in (0.0, 2e-6 / pair.face_width):
        ahead = stiffness_curve(law, load, cycle, psi=psi)
        back = stiffness_curve(other, load, -cycle, psi=psi)
        scale = ahead.transmission_error.mean()
        assert back.transmission_error.mean() == pytest.approx(scale, rel=0.01)
        assert back.transmission_error == pytest.approx(ahead.transmission_error, abs=0.05 * scale)


@EVERY_RUNG
def test_no_helix_gives_the_spur_law(model):
    shape = ((20, 55), 2), (12,), {"bores_mm": (12.5, 17.5)}
    spur, nearly = (law_of(model, gear_pair(*shape[0], beta, *shape[1], **shape[2])) for beta in (0.0, 0.02))
    load, cycle = NOMINAL * 12e-3, np.linspace(0, 1, 17)
    one, other = (stiffness_curve(law, load, cycle).transmission_error for law in (spur, nearly))
    assert other.mean() == pytest.approx(one.mean(), rel=5e-3)
    assert np.median(np.abs(other / one - 1)) < 5e-3
