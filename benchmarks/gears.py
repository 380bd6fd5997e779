"""Parts `laws` and `evaluation`: seconds to build a mesh law, microseconds to evaluate it in compiled code."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

from benchmarks.clock import timed
from benchmarks.rig import Laws, keep, plane_law, read, stage_law
from fem.contact.evaluation.curves import stiffness_curve
from fem.contact.evaluation.evaluator import checked_teeth, evaluate, law_tables

CALLS = 20_000


@njit
def _many(tables, cycle, delta, psi, pinion, wheel):
    total = 0.0
    for i in range(len(cycle)):
        total += evaluate(tables, cycle[i], delta[i], psi, pinion, wheel)[0]
    return total


def laws(folder: Path) -> list[dict[str, Any]]:
    """Seconds of models iso and plane for every stage of the rig; keeps the plane laws."""
    rows, found = [], []
    cheap = read(**{f"stages__{n}__mesh__model": "iso" for n in (1, 2, 3)})
    plant = read()
    plane_law(plant.layout.pairs[0], 1, 0.5)  # imports and first calls are not the law's
    for stage, pair in enumerate(plant.layout.pairs):
        iso, _ = timed(lambda n=stage: stage_law(cheap, n))
        plane, pair_laws = timed(lambda n=stage: stage_law(plant, n))
        found.append(pair_laws)
        for model, time_taken in (("iso", iso), ("plane", plane)):
            rows.append({"stage": stage + 1, "pair": pair.label.split()[-1], "model": model, **time_taken})
    keep(folder, "laws", found)
    return rows


def evaluation(folder: Path) -> list[dict[str, Any]]:
    """Microseconds per call of the compiled law at the load of the rig, stage 1, by model and number of slices."""
    plant = read()
    force = plant.facts.stages[0].mesh_force
    rows = []
    for model, slices in (("iso", 15), ("plane", 7), ("plane", 15), ("plane", 31)):
        settings = {"stages__1__mesh__model": model, "stages__1__mesh__slices": slices}
        drive, _ = stage_law(*read(**settings), 0)
        rows.append({"model": model, "slices": slices, "force_N": force, **per_call((drive, drive), force)})
    return rows


def per_call(pair_laws: Laws, force: float) -> dict[str, float]:
    """Median microseconds of one evaluation of the drive flank over random cycles at about the force (N)."""
    drive = pair_laws[0]
    cycle = np.random.default_rng(0).uniform(0.0, 100.0, CALLS)
    curve = stiffness_curve(drive, force)
    delta = np.interp(cycle % 1.0, curve.cycle, curve.transmission_error, period=1.0)
    none = checked_teeth(drive, None, None)
    tables = law_tables(drive)
    _many(tables, cycle[:2], delta[:2], 0.0, *none)
    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        _many(tables, cycle, delta, 0.0, *none)
        seconds.append(time.perf_counter() - start)
    return {"microseconds": float(np.median(seconds)) / CALLS * 1e6, "calls": CALLS}
