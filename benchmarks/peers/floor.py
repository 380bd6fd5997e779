"""What the arithmetic alone would cost: python -m benchmarks.peers.floor

Counts the multiplications and the bytes of one time step of the rig and of the factorisation of its casing, and divides
by what this machine reaches on one thread in a product of dense matrices and in a streaming sum.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.clock import conditions
from benchmarks.peers import output

RESULTS = Path(__file__).resolve().parent.parent / "results" / "floor.json"
NUMBER = 8  # bytes


def rates() -> dict[str, float]:
    """Flops per second of dgemm (n = 1000), bytes per second of sums from memory and from the cache, best of 5."""
    a = np.random.default_rng(0).standard_normal((1000, 1000))
    dense = min(_seconds(lambda: a @ a) for _ in range(5))
    out: dict[str, float] = {"dgemm": 2e9 / dense}
    for name, size, repeats in (("memory", 30_000_000, 1), ("cache", 12_000, 2000)):
        x, y = np.ones(size), np.ones(size)

        def stream(x: np.ndarray = x, y: np.ndarray = y, repeats: int = repeats) -> None:
            for _ in range(repeats):
                np.add(x, y, out=y)

        out[name] = 3 * NUMBER * size * repeats / min(_seconds(stream) for _ in range(5))
    return out


def _seconds(work: Any) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def step_count(modes: int, rows: int, forces: int, outputs: int, iterations: float) -> dict[str, float]:
    """Flops and bytes of one exponential step without the mesh forces.

    Two vectors of modal coordinates are moved by 2 x 2 blocks (8 flops per mode), rows are read and forces brought back
    (2 flops per entry each), a dense system of the forces is solved in every iteration, output rows are formed. Every
    matrix is read once.
    """
    matrices = modes * (2 * rows + 2 * forces + 2 * outputs)
    small = iterations * (2.0 / 3.0 * forces**3 + 4.0 * forces * rows)
    return {"flops": 2.0 * matrices + 8.0 * modes + small, "bytes": NUMBER * (matrices + 6.0 * modes)}


def factor_count(matrix: Any) -> dict[str, float]:
    """Flops and bytes of a Cholesky factor in the nested dissection order of the library, by the column counts."""
    from fem.numerics.elimination import plan_elimination

    order = plan_elimination(matrix, 3).order
    counts = column_counts(matrix[order][:, order])
    return {"flops": float(np.square(counts, dtype=float).sum()), "bytes": NUMBER * float(counts.sum()),
            "unknowns": int(matrix.shape[0]), "entries": float(counts.sum())}  # fmt: skip


def column_counts(matrix: Any) -> np.ndarray:
    """Entries (n,) of the columns of the Cholesky factor, diagonal included, by the row subtrees (Liu, 1990)."""
    from numba import njit
    from scipy.sparse import csr_matrix, tril

    lower = csr_matrix(tril(matrix, format="csr"))

    @njit
    def count(indptr, indices, n):
        parent, ancestor, mark, counts = np.full(n, -1), np.full(n, -1), np.full(n, -1), np.ones(n, np.int64)
        for i in range(n):
            for k in range(indptr[i], indptr[i + 1]):
                j = indices[k]
                while j != -1 and j < i:
                    up = ancestor[j]
                    ancestor[j] = i
                    if up == -1:
                        parent[j] = i
                    j = up
        for i in range(n):
            mark[i] = i
            for k in range(indptr[i], indptr[i + 1]):
                j = indices[k]
                while j < i and mark[j] != i:
                    counts[j] += 1
                    mark[j] = i
                    j = parent[j]
        return counts

    found: np.ndarray = count(lower.indptr.astype(np.int64), lower.indices.astype(np.int64), lower.shape[0])
    return found


def measure() -> dict[str, Any]:
    """Counts, rates and the seconds that follow."""
    from benchmarks.rig import casing_parts, read
    from fem.casing.mesh.choose_mesher import mesh_geometry
    from fem.casing.mesh.sizes import Sizes
    from fem.casing.models.elastic_casing import ElasticCasing
    from fem.casing.reduced.grounded import assembled_casing

    machine = read()
    box, iron = casing_parts(machine)
    assert isinstance(machine.casing, ElasticCasing)
    mesh = mesh_geometry(box, Sizes(element=machine.casing.element_size))
    machine_rates = rates()
    factor = factor_count(assembled_casing(mesh, iron, interfaces=()).K_free)
    step = step_count(modes=420, rows=17, forces=14, outputs=len(machine.sensors) * 3, iterations=2.0)
    seconds = {
        "factor": max(factor["flops"] / machine_rates["dgemm"], factor["bytes"] / machine_rates["memory"]),
        "step": max(step["flops"] / machine_rates["dgemm"], step["bytes"] / machine_rates["cache"]),
    }
    return {"conditions": conditions(), "rates": machine_rates, "factor": factor, "step": step, "seconds": seconds}


if __name__ == "__main__":
    output.report(measure(), RESULTS)
