"""Curves of a MeshLaw at one load: transmission error, no-load error, secant and tangent stiffness, load sharing.

With the approach (delta, psi) and the force F = T1 / r_b1 on the transverse line of action:

    e(c, F)     delta at F                        quasi-static transmission error
    delta_0(c)  delta where the first pair touches
    k_s         F / (e - delta_0)                 secant
    k_t         dF/d delta at fixed psi           tangent

The tilt psi is either given, or balanced: psi such that M = 0, the force centroid at mid face.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem.contact.evaluation.evaluator import LawError, checked_teeth, evaluate_law, share_reach, shares
from fem.contact.law import MeshLaw
from fem.storage.records import Record, array, scalar, text

_ROUNDS = 200


@dataclass(frozen=True, eq=False, kw_only=True)
class StiffnessCurve(Record):
    """The cut of a MeshLaw at one load, along the transverse line of action."""

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
    """Curves at the force `load` (N, > 0) over the mesh cycles `cycle` (default: 200 points of one cycle).

    psi : tilt (rad), or None for the balanced tilt M = 0; clearances as for `evaluate_law`

    Raises
    ------
    LawError : load not positive, or the force is not reached within the gaps that the law knows
    """
    if not (np.isfinite(load) and load > 0.0):
        raise LawError(f"stiffness curve of law {law.model!r}: load is {load!r} N; give a finite force > 0")
    c = np.linspace(0.0, 1.0, 200, endpoint=False) if cycle is None else np.atleast_1d(np.asarray(cycle, dtype=float))
    h = checked_teeth(law, clearance_pinion, clearance_wheel)
    if psi is None:
        delta, tilt = _balanced(law, c, load, *h)
        no_load, _ = _balanced(law, c, 1e-6 * load, *h)
    else:
        tilt = np.full(c.size, float(psi))
        no_load = no_load_error(law, c, psi, *h)
        delta = _approach_at(law, c, tilt, load, no_load, *h)
    response = evaluate_law(law, c, delta, tilt, *h)
    pair, share = _sharing(law, c, delta, tilt, *h)
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


def no_load_error(
    law: MeshLaw,
    cycle: np.ndarray,
    psi: float = 0.0,
    clearance_pinion: np.ndarray | None = None,
    clearance_wheel: np.ndarray | None = None,
) -> np.ndarray:
    """delta_0 (n,) in m: the least gap + h - psi y over the slices and pairs.

    Raises
    ------
    LawError : no pair can touch at some cycle
    """
    h1, h2 = checked_teeth(law, clearance_pinion, clearance_wheel)
    cycle = np.atleast_1d(np.asarray(cycle, dtype=float))
    reach = share_reach(law)
    own = law.cycle_sign * cycle + law.cycle_offset
    part = law.face_coordinate / law.slice_width.sum()
    lowest = np.full(cycle.size, np.inf)
    for p in np.arange(-reach, reach + 1):
        number = (np.floor(own) + p).astype(int)
        first = h1[(law.cycle_sign * number) % len(h1)]
        second = h2[(law.cycle_sign * number + law.wheel_tooth_offset) % len(h2)]
        h, a1, a2, b1, b2, _ = (first + second).T[:, :, None]
        xi = (own - number)[:, None] + law.cycle_shift[None, :]
        gap = _gap_at(law, xi, law.gap[None, :], np.zeros((1, law.face_coordinate.size), dtype=int))
        for terms, variants in ((first, law.pinion_variant_gap), (second, law.wheel_variant_gap)):
            damaged = np.flatnonzero(terms[:, 5])
            if damaged.size:
                tables = variants.reshape(-1, law.gap.size)
                row = (terms[damaged, 5, None].astype(int) - 1) * law.face_coordinate.size
                gap[damaged] += _gap_at(law, xi[damaged], tables, row + np.arange(law.face_coordinate.size))
        gap = gap + law.lead_gap - psi * law.face_coordinate + xi * (a1 + xi * a2) + part * (b1 + part * b2)
        lowest = np.minimum(lowest, gap.min(axis=1) + h[:, 0])
    if not np.isfinite(lowest).all():
        raise LawError(
            f"mesh law {law.model!r}: no tooth pair can touch at cycle {cycle[~np.isfinite(lowest)][0]:.6g}; too many "
            "teeth are missing side by side, or the law was built with too small a largest gap"
        )
    return lowest


def _gap_at(law: MeshLaw, xi: np.ndarray, tables: np.ndarray, row: np.ndarray) -> np.ndarray:
    """tables[row] at xi, linear in each cell; inf where a cell has an infinite end or nothing can touch."""
    place = (xi - law.position_start) / law.position_step
    cell = np.clip(place.astype(int), 0, law.gap.size - 2)
    weight = np.clip(place - cell, 0.0, 1.0)
    low, high = tables[row, cell], tables[row, cell + 1]
    phi = law.fraction[cell] + weight * (law.fraction[cell + 1] - law.fraction[cell])
    closed = np.isinf(low) | np.isinf(high) | (place < 0.0) | (place > law.gap.size - 1) | (phi <= 0.0)
    low, high = np.where(closed, 0.0, low), np.where(closed, 0.0, high)
    return np.where(closed, np.inf, low + weight * (high - low))


def _approach_at(
    law: MeshLaw, c: np.ndarray, tilt: np.ndarray, load: float, start: np.ndarray, h1: np.ndarray, h2: np.ndarray
) -> np.ndarray:
    """delta with F = load at fixed tilt: safeguarded Newton on the rising function F(delta), all cycles at once."""
    low = start.copy()
    high = start + 1e-6
    for _ in range(60):
        short = evaluate_law(law, c, high, tilt, h1, h2).force < load
        if not short.any():
            break
        low, high = np.where(short, high, low), np.where(short, start + 2.0 * (high - start), high)
    delta = high.copy()
    for _ in range(_ROUNDS):
        r = evaluate_law(law, c, delta, tilt, h1, h2)
        rest = load - r.force
        if np.all(np.abs(rest) <= 1e-12 * load):
            return delta
        low, high = np.where(rest > 0.0, delta, low), np.where(rest < 0.0, delta, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            trial = delta + rest / r.stiffness
        trial = np.where(np.isfinite(trial) & (trial > low) & (trial < high), trial, 0.5 * (low + high))
        if np.all(np.abs(trial - delta) <= 4e-16 * np.abs(delta)):
            return trial
        delta = trial
    worst = int(np.argmax(np.abs(rest)))
    raise LawError(
        f"mesh law {law.model!r}: F = {load:.6g} N is not reached at cycle {c[worst]:.6g} (off by {rest[worst]:.3g} N "
        f"at delta {delta[worst]:.4g} m): the tip-edge gaps of the law end before; build it with a larger largest gap"
    )


def _balanced(
    law: MeshLaw, c: np.ndarray, load: float, h1: np.ndarray, h2: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(delta, psi) with F = load and M = 0: damped Newton on the convex function U - load * delta, cycle by cycle."""
    half = float(np.abs(law.face_coordinate).max()) or 1.0
    start = _approach_at(law, c, np.zeros(c.size), load, no_load_error(law, c, 0.0, h1, h2), h1, h2)
    delta, tilt = start.copy(), np.zeros(c.size)
    for i in range(c.size):
        state = np.array([delta[i], 0.0])  # psi times half the face: both in m
        r = evaluate_law(law, c[i], state[0], state[1] / half, h1, h2)
        value = r.energy - load * state[0]
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
                r_trial = evaluate_law(law, c[i], trial[0], trial[1] / half, h1, h2)
                value_trial = r_trial.energy - load * trial[0]
                if value_trial <= value + 1e-4 * scale * float(slope @ step) + 1e-15 * abs(value):
                    break
                scale *= 0.5
            state, r, value = trial, r_trial, value_trial
        else:
            raise LawError(
                f"mesh law {law.model!r}: no balanced tilt at cycle {c[i]:.6g}, F = {load:.6g} N (rest {slope} N): the "
                "clearances leave a single line of contact off mid face, or the tip-edge gaps end too early"
            )
        delta[i], tilt[i] = state[0], state[1] / half
    return delta, tilt


def _sharing(
    law: MeshLaw, c: np.ndarray, delta: np.ndarray, tilt: np.ndarray, h1: np.ndarray, h2: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pair numbers (m,) loaded anywhere, and their forces (n, m) in N."""
    found = [shares(law, *state, h1, h2) for state in zip(c, delta, tilt, strict=True)]
    first = min(int(p[0]) for p, _ in found)
    last = max(int(p[-1]) for p, _ in found)
    force = np.zeros((c.size, last - first + 1))
    for row, (p, f) in zip(force, found, strict=True):
        row[p[0] - first : p[-1] - first + 1] = f
    used = np.flatnonzero(force.any(axis=0))
    keep = slice(used[0], used[-1] + 1)
    return np.arange(first, last + 1)[keep], force[:, keep]
