"""Microseconds per evaluation of mesh laws along a motion like that of the rig: `python -m benchmarks.law_evaluation`.

The cycle advances by 0.003 per call (300 Hz, steps of 10 us), delta swings by 15 % about the loaded approach, psi about
0.1 mrad, every tooth has clearance, slopes and curvatures of the size of grade 5.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numba import njit

from benchmarks.rig import plane_law, read
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.kernel import evaluate
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.law import MeshLaw
from fem.contact.teeth import tooth_terms

CALLS = 20_000
FORCE = 800.0  # N
GRADE_5 = {"clearance": 3e-6, "profile_slope": 2e-6, "profile_curvature": 1e-6, "lead_slope": 3e-6}  # m


@njit
def _once(tables, cycle, delta, psi, pinion, wheel):
    total = 0.0
    for i in range(1, len(cycle)):
        total += evaluate(tables, cycle[i], delta[i], psi[i], pinion, wheel)[0]
    return total


def motion(law: MeshLaw) -> tuple[np.ndarray, ...]:
    """Cycle, delta, psi (CALLS,) and the tooth terms of both gears."""
    draw, step = np.random.default_rng(1), np.arange(CALLS)
    curve = stiffness_curve(law, FORCE)
    cycle = 0.003 * step
    loaded = np.interp(cycle % 1.0, curve.cycle, curve.transmission_error, period=1.0)
    delta, psi = loaded * (1.0 + 0.15 * np.sin(0.57 * step)), 1e-4 + 3e-5 * np.sin(0.003 * step)
    teeth = [
        tooth_terms(z, **{name: draw.normal(0.0, size / 2, z) for name, size in GRADE_5.items()})
        for z in (law.pinion_teeth, law.wheel_teeth)
    ]
    return cycle, delta, psi, *teeth


def microseconds(law: MeshLaw) -> dict[str, float]:
    """CPU time per call (best of five runs)."""
    tables, states, taken = LawEvaluator(law).packed, motion(law), []
    _once(tables, *(v[:2] for v in states[:3]), *states[3:])
    for _ in range(5):
        start = time.process_time()
        _once(tables, *states)
        taken.append(time.process_time() - start)
    return {"one state": min(taken) / CALLS * 1e6}


def rows() -> list[dict[str, Any]]:
    """One row per stage of the rig and number of slices, uncoupled and coupled along the face."""
    machine = read()
    found = []
    for stage, slices in ((0, 7), (0, 15), (0, 31), (0, 61), (1, 15), (2, 15)):
        law = plane_law(machine.layout.pairs[stage], slices)[0]
        spread = {"spread_compliance": 0.7 * law.compliance, "spread_length": 1.1e-3 * 2}
        coupled = law.replaced(compliance=0.3 * law.compliance, body_compliance=2e-9, tilt_compliance=2e-4, **spread)
        for each, is_coupled in ((law, False), (coupled, True)):
            found.append({"stage": stage + 1, "slices": slices, "coupled": is_coupled, **microseconds(each)})
    return found


if __name__ == "__main__":
    import sys

    for row in rows():
        sys.stdout.write(
            "  ".join(f"{k} {v:.3g}" if isinstance(v, float) else f"{k} {v}" for k, v in row.items()) + "\n"
        )
