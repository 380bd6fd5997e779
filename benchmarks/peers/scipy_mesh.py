"""One gear stage: gearcase against SciPy's stiff solvers at equal error: python -m benchmarks.peers.scipy_mesh

Error: RMS of the difference in the approach of the drive flank at 10 kHz over the standard deviation of the reference,
DOP853 at a tolerance of 1e-11. All take the compiled force; SciPy takes the compiled right-hand side and forms its
Jacobian by differences, as it does by default.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.clock import conditions, timed
from benchmarks.peers import output
from benchmarks.peers.single_stage import CLOSE, RATE, SPAN, SPEED, Equations, error, instants, seconds_at, system
from mbd.integrators.methods import make_integrator
from mbd.system.statics import equilibrium
from mbd.system.system import System

RESULTS = Path(__file__).resolve().parent.parent / "results" / "scipy_mesh.json"
STEPS = (20e-6, 10e-6, 5e-6, 2.5e-6, 1.25e-6, 0.625e-6)
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
Rate = Callable[[float, np.ndarray], np.ndarray]
SOLVERS = ("LSODA", "BDF", "Radau")
LONG = 300.0  # s; a method is not driven further once a run takes this long


def gearcase(machine: System, step: float, method: str = "exponential") -> np.ndarray:
    """Approach (instants,) by a fixed-step method of the library, start included."""
    every, steps = round(1.0 / (RATE * step)), round(SPAN / step)
    integrator = make_integrator(method, machine, step)
    integrator.start(equilibrium(machine))
    block = integrator.advance(SPEED * step * np.arange(1, steps + 1), np.full(steps, SPEED), np.zeros(steps))
    return np.asarray(block.rows[every - 1 :: every, 0])


def scipy(equations: Equations, rate: Rate, method: str, rtol: float) -> np.ndarray:
    """Approach (instants,) by a solver of scipy.integrate."""
    from scipy.integrate import solve_ivp

    size = np.abs(equations.start[: len(equations.omega2)]).max()
    scale = np.concatenate([np.full(len(equations.omega2), size), np.full(len(equations.omega2), size * 1e3)])
    answer = solve_ivp(
        rate, (0.0, SPAN), equations.start, method=method, rtol=rtol, atol=rtol * 1e-2 * scale,
        t_eval=instants(),
    )  # fmt: skip
    if not answer.success:
        raise RuntimeError(f"{method}: {answer.message}")
    return np.asarray(equations.delta @ answer.y[: len(equations.omega2)])


def own_rows(machine: System, exact: np.ndarray) -> list[dict[str, float]]:
    """Error and seconds of the default method over its steps."""
    rows = []
    gearcase(machine, STEPS[0])
    for step in STEPS:
        taken, found = timed(lambda s=step: gearcase(machine, s))
        rows.append({"step_us": step * 1e6, "error": error(found, exact), **taken})
    return rows


def measure() -> dict[str, Any]:
    """Work and precision of all methods, and the ratio of seconds at equal error."""
    machine = system()
    equations = Equations.of(machine)
    rate = equations.rate()
    exact = scipy(equations, rate, "DOP853", 1e-11)
    methods: dict[str, list[dict[str, float]]] = {"gearcase exponential": own_rows(machine, exact)}
    for method in SOLVERS:
        rows = methods[f"SciPy {method}"] = []
        for rtol in TOLERANCES:
            taken, found = timed(lambda m=method, r=rtol: scipy(equations, rate, m, r), repeats=1)
            rows.append({"rtol": rtol, "error": error(found, exact), **taken})
            if taken["seconds"] > LONG or rows[-1]["error"] < CLOSE / 3:
                break
    return {"conditions": conditions(), "coordinates": len(equations.omega2), "span_s": SPAN} | summary(methods)


def summary(methods: dict[str, list[dict[str, float]]]) -> dict[str, Any]:
    """Seconds of every method at the error at which they are compared, and how many times the library's that is."""
    seconds = {name: seconds_at(rows) for name, rows in methods.items()}
    own = seconds["gearcase exponential"]
    ratios = {name: s / own for name, s in seconds.items() if s and own and not name.startswith("gearcase")}
    return {"error": CLOSE, "methods": methods, "cpu_seconds_at_error": seconds, "ratio": ratios}


if __name__ == "__main__":
    output.report(measure(), RESULTS)
