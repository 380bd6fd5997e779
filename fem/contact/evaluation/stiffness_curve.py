"""Curves of a MeshLaw at one load: transmission error, no-load error, secant and tangent stiffness, load sharing.

With the approach (delta, psi) and the force F = T1 / r_b1 on the transverse line of action:

    e(c, F)     delta at F                        quasi-static transmission error
    delta_0(c)  delta where the first pair touches, see `fem.contact.evaluation.first_touch`
    k_s         F / (e - delta_0)                 secant
    k_t         dF/d delta at fixed psi           tangent

The tilt psi is either given, or balanced: psi such that M = 0, the force centroid at mid face.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np

from fem.contact.evaluation.evaluator import LawError, LawEvaluator
from fem.contact.evaluation.first_touch import first_touch
from fem.contact.law import MeshLaw
from fem.contact.teeth import least_clearance
from fem.storage.records import Record, array, scalar, text

logger = logging.getLogger(__name__)

_ROUNDS = 200
_WARNED_POSITIONS = 40  # in one mesh cycle, whatever positions a curve has, so that equal warnings are printed once


@dataclass(frozen=True, eq=False, kw_only=True)
class StiffnessCurve(Record):
    """The cut of a MeshLaw at one load, along the transverse line of action."""

    plotted = ("cycle", "secant", "tangent")
    model: str = text()
    flank: str = text()
    tilt_mode: str = text()  # "given" | "balanced"
    force: float = scalar(units="N")  # F
    cycle: np.ndarray = array("position", units="1")
    transmission_error: np.ndarray = array("position", units="m")  # e
    no_load_error: np.ndarray = array("position", units="m")  # delta_0
    tilt: np.ndarray = array("position", units="rad")  # psi
    secant: np.ndarray = array("position", units="N/m")
    tangent: np.ndarray = array("position", units="N/m")
    centroid: np.ndarray = array("position", units="m")  # M / F, from mid face
    pair: np.ndarray = array("pair", units="1", dtype=int)  # pair numbers p
    share: np.ndarray = array("position", "pair", units="1")  # force of the pair / F


def stiffness_curve(
    law: MeshLaw,
    load: float,
    cycle: np.ndarray | None = None,
    *,
    psi: float | None = 0.0,
    clearance_pinion: np.ndarray | None = None,
    clearance_wheel: np.ndarray | None = None,
) -> StiffnessCurve:
    """Curves at one force.

    Parameters
    ----------
    law : of the flank
    load : N, > 0
    cycle : (n,) mesh cycles; None for 200 points of one cycle
    psi : tilt (rad), or None for the balanced tilt M = 0
    clearance_pinion, clearance_wheel : see `evaluator.Teeth`

    Raises
    ------
    LawError : load not positive, or the force is not reached within the gaps that the law knows

    A warning names the force above which the table of the law ends too early.
    """
    if not (np.isfinite(load) and load > 0.0):
        raise LawError(f"stiffness curve of law {law.model!r}: load is {load!r} N; give a finite force > 0")
    c = np.linspace(0.0, 1.0, 200, endpoint=False) if cycle is None else np.atleast_1d(np.asarray(cycle, dtype=float))
    evaluator = LawEvaluator(law)
    h = evaluator.teeth(clearance_pinion, clearance_wheel)
    delta, tilt = loaded_approach(evaluator, load, c, psi, *h)
    no_load = first_touch(law, c, psi, *h)
    response = evaluator.evaluate(c, delta, tilt, *h)
    _warn_beyond_window(evaluator, delta, tilt, load, *h)
    pair, share = _sharing(evaluator, c, delta, tilt, *h)
    return StiffnessCurve(
        model=law.model,
        flank=law.flank,
        tilt_mode="balanced" if psi is None else "given",
        force=load,
        cycle=c,
        transmission_error=delta,
        no_load_error=no_load,
        tilt=tilt,
        secant=load / (delta - no_load),
        tangent=response.stiffness,
        centroid=response.moment / response.force,
        pair=pair,
        share=share / response.force[:, None],
    )


def loaded_approach(
    evaluator: LawEvaluator, load: float, cycle: np.ndarray, psi: float | None, h1: np.ndarray, h2: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Transmission error (n,), m, and tilt (n,), rad, at a force `load` (N) and the positions `cycle` (n,).

    Parameters
    ----------
    evaluator : of the law
    load, cycle, psi : as in `stiffness_curve`
    h1, h2 : terms of the teeth, see `evaluator.Teeth`
    """
    if psi is None:
        return _balanced(evaluator, cycle, load, h1, h2)
    return evaluator.approach_at(load, cycle, psi, h1, h2), np.full(cycle.size, float(psi))


def _warn_beyond_window(
    evaluator: LawEvaluator,
    delta: np.ndarray,
    tilt: np.ndarray,
    load: float,
    h1: np.ndarray,
    h2: np.ndarray,
) -> None:
    """Warn where the flanks approach by more than the tip-edge gaps at the ends of the law's table."""
    law = evaluator.law
    known = law.gap[np.isfinite(law.gap)]
    half = float(np.abs(law.face_coordinate).max())
    largest = min(known[0], known[-1]) - known.min() + least_clearance(law, h1, h2) - half * np.abs(tilt)
    if (delta > largest).any():
        cycle = np.linspace(0.0, 1.0, _WARNED_POSITIONS, endpoint=False)
        reached = evaluator.evaluate(cycle, float(largest.min()), float(tilt.mean()), h1, h2).force.min()
        logger.warning(
            "mesh law %r (%s): at F = %.4g N the next tooth pair makes contact outside the tables of the law, and the "
            "stiffness jumps there by a few per cent. Reduce the load to about %.2g N",
            law.model, law.flank, load, reached,
        )  # fmt: skip


def _balanced(
    evaluator: LawEvaluator, c: np.ndarray, load: float, h1: np.ndarray, h2: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(delta, psi) with F = load and M = 0: damped Newton on the convex function U - load * delta, cycle by cycle.

    A step is halved until that function rises no steeper at its end than half as steeply as it falls at its start.
    """
    half = float(np.abs(evaluator.law.face_coordinate).max()) or 1.0
    start = evaluator.approach_at(load, c, 0.0, h1, h2)
    delta, tilt = start.copy(), np.zeros(c.size)
    for i in range(c.size):
        state = np.array([delta[i], 0.0])  # psi times half the face: both in m
        r = evaluator.evaluate(c[i], state[0], state[1] / half, h1, h2)
        for _ in range(_ROUNDS):
            slope = np.array([r.force - load, r.moment / half])
            round_off = 1e-14 * r.stiffness * abs(state[0])
            if np.abs(slope).max() <= 1e-10 * load + round_off:
                break
            mixed, turning = r.cross_stiffness / half, r.tilt_stiffness / half**2
            floor = 1e-9 * max(r.stiffness, 1.0)  # one loaded slice alone leaves the tilt free
            step = -np.linalg.solve([[r.stiffness + floor, mixed], [mixed, turning + floor]], slope)
            scale = 1.0
            for _ in range(60):
                trial = state + scale * step
                r_trial = evaluator.evaluate(c[i], trial[0], trial[1] / half, h1, h2)
                if (r_trial.force - load) * step[0] + r_trial.moment / half * step[1] <= -0.5 * (slope @ step):
                    break
                scale *= 0.5
            state, r = trial, r_trial
        else:
            raise LawError(
                f"mesh law {evaluator.law.model!r}: no tilt centres the load at cycle {c[i]:.6g}, F = {load:.6g} N "
                f"(rest {slope} N): only one slice off mid face touches, or the deflection is beyond the tip-edge gaps "
                "of the law. Give the tilt as a number"
            )
        delta[i], tilt[i] = state[0], state[1] / half
    return delta, tilt


def _sharing(
    evaluator: LawEvaluator, c: np.ndarray, delta: np.ndarray, tilt: np.ndarray, h1: np.ndarray, h2: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pair numbers (m,) loaded anywhere, and their forces (n, m) in N."""
    pairs, loads = evaluator.line_loads(c, delta, tilt, h1, h2)
    known = np.arange(pairs.min(), pairs.max() + 1)
    force = np.zeros((c.size, known.size))
    np.put_along_axis(force, pairs - known[0], loads @ evaluator.law.slice_width, axis=1)
    used = np.flatnonzero(force.any(axis=0))
    keep = slice(used[0], used[-1] + 1)
    return known[keep], force[:, keep]
