"""Part `lockstep`: what scenes that share their modes would gain by advancing as columns of a matrix.

The arithmetic of a step over the modes (`mbd.integrators.modal_loop`) for one column and for several, each as fast as
it gets, against the whole step. What the forces take stays the same, because every column has its own, and so does what
follows the loop. Columns whose steps are cut at different places would gain less.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numba
import numpy as np

from benchmarks.campaigns import PLAN, SCENES
from pipelines.datasets.campaign_scenes import sampled_scenes, scene_of
from pipelines.datasets.plan import load_plan
from pipelines.datasets.worker_cache import WorkerCache
from pipelines.engine.build_step import one_thread
from pipelines.engine.run_graph import Work
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.steps.motion import moved

BATCHES = (1, 3, 8, 16)
STEPS = 4000


def lockstep(folder: Path) -> list[dict[str, Any]]:
    """Microseconds per column and step of the arithmetic over modes by the number of columns, and of the whole step."""
    rows = []
    for name, (_, _, preset) in SCENES.items():
        path = folder / f"{name}-lockstep.toml"
        path.write_text(PLAN.format(scene=name, count=1, end=1.0, preset=preset), encoding="utf-8")
        plan = load_plan(path)
        machine = checked_machine(scene_of(plan, sampled_scenes(plan)[0].values).scene, "scene")
        with one_thread():
            system = WorkerCache(Work().cache).system(machine)
            moved(system, machine.motion)
            start = time.perf_counter()
            motion = moved(system, machine.motion)
            whole = (time.perf_counter() - start) / motion.counter("steps") * 1e6
            modes, forces = len(system.frequencies), len(system.rows)
            columns = {n: _arithmetic(modes, forces, len(system.all_rows), n) for n in BATCHES}
        best = min(columns[n] for n in BATCHES if n > 1)
        rows.append(
            {
                "scene": name,
                "modes": modes,
                "rows": forces,
                "step_us": whole,
                "columns_us": {str(n): value for n, value in columns.items()},
                "gain": whole / (whole - columns[1] + best),
            }
        )
    return rows


def _arithmetic(modes: int, forces: int, rows: int, columns: int) -> float:
    """Microseconds per column and step: modes turned on, rows and their rates read, forces entered."""
    random = np.random.default_rng(0)
    state = random.standard_normal((columns, 2 * modes))
    factors = 1e-3 * random.standard_normal((5, 2 * modes))
    read = random.standard_normal((rows, 2 * modes)) / modes
    enter = random.standard_normal((forces, 2 * modes))
    advance = _one if columns == 1 else _several
    given = (state[0] if columns == 1 else np.ascontiguousarray(state.T), factors, read, enter)
    advance(2, *given)
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        advance(STEPS, *given)
        seconds.append(time.perf_counter() - start)
    return min(seconds) / STEPS / columns * 1e6


@numba.njit(fastmath={"reassoc", "contract", "nsz"})
def _one(steps, state, factors, read, enter):
    """The arithmetic of `mbd.integrators.modal_loop` for one column: growth, two earlier forces, rates, new forces."""
    size = len(state)
    n, forces = size // 2, len(enter)
    now, rates, newest, older = np.empty(size), np.empty(size), np.zeros(size), np.zeros(size)
    seen, moving = np.empty(len(read)), np.empty(forces)
    for _ in range(steps):
        for j in range(n):
            k = n + j
            x = (
                factors[0, j] * state[j]
                - factors[0, k] * state[k]
                + factors[1, j] * newest[j]
                - factors[1, k] * newest[k]
            )
            y = (
                factors[0, j] * state[k]
                + factors[0, k] * state[j]
                + factors[1, j] * newest[k]
                + factors[1, k] * newest[j]
            )
            now[j] = x + factors[2, j] * older[j] - factors[2, k] * older[k]
            now[k] = y + factors[2, j] * older[k] + factors[2, k] * older[j]
            rates[j] = factors[3, j] * now[j] - factors[3, k] * now[k]
            rates[k] = factors[3, j] * now[k] + factors[3, k] * now[j]
        for r in range(len(read)):
            seen[r] = np.dot(read[r], now)
        for r in range(forces):
            moving[r] = np.dot(read[r], rates)
        older[:] = newest
        newest[:] = 0.0
        for r in range(forces):
            for j in range(size):
                newest[j] += 1e-3 * (seen[r] + moving[r]) * enter[r, j]
        for j in range(n):
            k = n + j
            state[j] = now[j] + factors[4, j] * newest[j] - factors[4, k] * newest[k]
            state[k] = now[k] + factors[4, j] * newest[k] + factors[4, k] * newest[j]


@numba.njit(fastmath={"reassoc", "contract", "nsz"})
def _several(steps, state, factors, read, enter):
    """The same for the columns of a matrix (2 mode, column)."""
    size, columns = state.shape
    n, forces = size // 2, len(enter)
    now, rates, newest, older = np.empty_like(state), np.empty_like(state), np.zeros_like(state), np.zeros_like(state)
    entering, fast = np.ascontiguousarray(enter.T), np.ascontiguousarray(read[:forces])
    for _ in range(steps):
        for j in range(n):
            k = n + j
            a, b, c, d, e, f = factors[0, j], factors[0, k], factors[1, j], factors[1, k], factors[2, j], factors[2, k]
            for i in range(columns):
                x = a * state[j, i] - b * state[k, i] + c * newest[j, i] - d * newest[k, i]
                y = a * state[k, i] + b * state[j, i] + c * newest[k, i] + d * newest[j, i]
                now[j, i] = x + e * older[j, i] - f * older[k, i]
                now[k, i] = y + e * older[k, i] + f * older[j, i]
                rates[j, i] = factors[3, j] * now[j, i] - factors[3, k] * now[k, i]
                rates[k, i] = factors[3, j] * now[k, i] + factors[3, k] * now[j, i]
        seen, moving = read @ now, fast @ rates
        older[:] = newest
        newest = entering @ (1e-3 * (seen[:forces] + moving))
        for j in range(n):
            k = n + j
            for i in range(columns):
                state[j, i] = now[j, i] + factors[4, j] * newest[j, i] - factors[4, k] * newest[k, i]
                state[k, i] = now[k, i] + factors[4, j] * newest[k, i] + factors[4, k] * newest[j, i]
