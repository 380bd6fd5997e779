"""Parts `laws` and `evaluation`: seconds to build a mesh law, microseconds to evaluate it in compiled code."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

from benchmarks.clock import timed
from benchmarks.gear_pairs import gear_pair
from benchmarks.rig import Laws, keep, plane_law, read, stage_law
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.kernel import evaluate
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.models.solid import Solid
from fem.contact.wheels.crack_surface import crack_surface

CALLS = 20_000
CRACK = math.radians(70.0)  # to the centre line of the tooth


@njit
def _many(tables, cycle, delta, psi, pinion, wheel):
    total = 0.0
    for i in range(len(cycle)):
        total += evaluate(tables, cycle[i], delta[i], psi, pinion, wheel)[0]
    return total


def laws(folder: Path) -> list[dict[str, Any]]:
    """Seconds of the models iso, plane and solid and of a crack surface for every stage of the rig, and of a wide pair.

    Keeps the laws of the rig as shipped.
    """
    rows, found, machine = [], [], read()
    cheap = read(**{f"stages__{n}__mesh__model": "iso" for n in (1, 2, 3)})
    small, wide = gear_pair((17, 23), 2, 15, 10), gear_pair((100, 150), 2, 20, 80, bores_mm=(40, 60))
    plane_law(small, 1, 0.5)  # imports, compiled code and first calls are not the law's
    Solid(refinement=0.6, positions=8).laws(small)
    for stage, (pair, spec) in enumerate(zip(machine.layout.pairs, machine.laws, strict=True)):
        surface = spec.mesh.crack_surface(pair, "pinion", CRACK)
        works: dict[str, Callable[[], Any]] = {
            "iso": partial(stage_law, cheap, stage),
            "plane": partial(plane_law, pair),
            "solid": spec.laws,
            "flexibility of a cracked tooth": partial(crack_surface, surface),
        }
        for model, work in works.items():
            taken, made = timed(work, 1 if model == "solid" else 3)
            rows.append({"stage": str(stage + 1), "pair": pair.label.split()[-1], "model": model, **taken})
            if model == "solid":
                found.append(made)
    taken, _ = timed(partial(Solid(refinement=0.7).laws, wide), 1)
    rows.append({"stage": "b 40 m_n", "pair": wide.label.split()[-1], "model": "solid", **taken})
    keep(folder, "laws", found)
    return rows


def evaluation(folder: Path) -> list[dict[str, Any]]:
    """Microseconds per call of the compiled law at the load of the rig, stage 1, by model and number of slices."""
    machine = read()
    force = machine.facts.stages[0].mesh_force
    rows = []
    for model, slices in (("iso", 15), ("plane", 7), ("plane", 15), ("plane", 31)):
        settings = {"stages__1__mesh__model": model, "stages__1__mesh__slices": slices}
        drive, _ = stage_law(read(**settings), 0)
        rows.append({"model": model, "slices": slices, "force_N": force, **per_call((drive, drive), force)})
    return rows


def per_call(pair_laws: Laws, force: float) -> dict[str, float]:
    """Median microseconds of one evaluation of the drive flank over random cycles at about the force (N)."""
    drive = pair_laws[0]
    cycle = np.random.default_rng(0).uniform(0.0, 100.0, CALLS)
    curve = stiffness_curve(drive, force)
    delta = np.interp(cycle % 1.0, curve.cycle, curve.transmission_error, period=1.0)
    law = LawEvaluator(drive)
    none, tables = law.teeth(None, None), law.packed
    _many(tables, cycle[:2], delta[:2], 0.0, *none)
    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        _many(tables, cycle, delta, 0.0, *none)
        seconds.append(time.perf_counter() - start)
    return {"microseconds": float(np.median(seconds)) / CALLS * 1e6, "calls": CALLS}
