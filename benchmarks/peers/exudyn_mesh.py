"""One gear stage: gearcase against Exudyn at equal error: python -m benchmarks.peers.exudyn_mesh

Exudyn holds the same modal equations as one second-order object (ObjectGenericODE2) with constant mass, stiffness and
damping; the compiled mesh force is its user function. Both run in one process of the environment `.peers` (make peers).
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.clock import conditions, timed
from benchmarks.peers import environment, output
from benchmarks.peers.scipy_mesh import own_rows, scipy, summary
from benchmarks.peers.single_stage import CLOSE, RATE, SPAN, Equations, error, system

RESULTS = Path(__file__).resolve().parent.parent / "results" / "exudyn_mesh.json"
STEPS = (20e-6, 10e-6, 5e-6, 2.5e-6, 1.25e-6)
SOLVERS = ("GeneralizedAlpha", "TrapezoidalIndex2", "DOPRI5")


class Model:
    """The stage in Exudyn."""

    def __init__(self, equations: Equations) -> None:
        import exudyn
        import exudyn.itemInterface as items

        self.exudyn, n = exudyn, len(equations.omega2)
        self.container = exudyn.SystemContainer()
        self.system = self.container.AddSystem()
        self.equations, self.calls = equations, 0
        node = self.system.AddNode(
            items.NodeGenericODE2(
                referenceCoordinates=[0.0] * n,
                initialCoordinates=list(equations.start[:n]),
                initialCoordinates_t=list(equations.start[n:]),
                numberOfODE2Coordinates=n,
            )
        )

        def force(mbs: Any, t: float, number: int, q: Any, rate: Any) -> np.ndarray:
            self.calls += 1
            return equations.push(t, np.asarray(q), np.asarray(rate))

        self.system.AddObject(
            items.ObjectGenericODE2(
                nodeNumbers=[node],
                massMatrix=np.eye(n),
                stiffnessMatrix=np.diag(equations.omega2),
                dampingMatrix=equations.damping,
                forceUserFunction=force,
            )
        )
        self.sensor = self.system.AddSensor(
            items.SensorNode(nodeNumber=node, storeInternal=True, writeToFile=False,
                             outputVariableType=exudyn.OutputVariableType.Coordinates)
        )  # fmt: skip
        self.system.Assemble()

    def solve(self, method: str, step: float, tolerance: float | None = None) -> np.ndarray:
        """Approach of the drive flank at the instants compared."""
        settings = self.exudyn.SimulationSettings()
        integration = settings.timeIntegration
        integration.numberOfSteps, integration.endTime = round(SPAN / step), SPAN
        integration.verboseMode = 0
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = 1.0 / RATE
        integration.newton.useModifiedNewton = True
        integration.newton.numericalDifferentiation.doSystemWideDifferentiation = False
        if tolerance is not None:
            integration.automaticStepSize = True
            integration.relativeTolerance, integration.absoluteTolerance = tolerance, tolerance * 1e-6
            integration.numberOfSteps = round(SPAN * RATE)
        kind = getattr(self.exudyn.DynamicSolverType, method)
        if not self.system.SolveDynamic(settings, solverType=kind, showHints=False, showCausingItems=False):
            raise RuntimeError(f"Exudyn {method} failed at a step of {step:g} s")
        table = np.asarray(self.system.GetSensorStoredData(self.sensor))
        wanted = np.arange(1, round(SPAN * RATE) + 1) / RATE
        rows = [int(np.argmin(np.abs(table[:, 0] - t))) for t in wanted]
        return np.asarray(table[rows, 1:] @ self.equations.delta)


def measure() -> dict[str, Any]:
    """Work and precision of both (to be run where Exudyn is installed)."""
    import exudyn

    machine = system()
    equations = Equations.of(machine)
    exact = scipy(equations, equations.rate(), "DOP853", 1e-11)
    methods: dict[str, list[dict[str, Any]]] = {"gearcase exponential": own_rows(machine, exact)}
    for method in SOLVERS:
        rows = methods[f"Exudyn {method}"] = []
        for step in STEPS:
            model = Model(equations)
            start = time.perf_counter()
            try:
                taken, found = timed(lambda m=model, k=method, s=step: m.solve(k, s), repeats=1)
            except (RuntimeError, ValueError) as failure:
                rows.append({"step_us": step * 1e6, "failed": str(failure).splitlines()[0]})
                continue
            rows.append({"step_us": step * 1e6, "error": error(found, exact), "force_calls": model.calls, **taken})
            if rows[-1]["error"] < CLOSE / 3 or time.perf_counter() - start > 120.0:
                break
    done = {name: [row for row in rows if "error" in row] for name, rows in methods.items()}
    return {
        "conditions": conditions(),
        "program": f"Exudyn {exudyn.__version__}",
        "coordinates": len(equations.omega2),
        "span_s": SPAN,
    } | summary(done)


def main() -> int:
    """Measure in the environment of the peers and write."""
    if "--here" in sys.argv:
        print(json.dumps(measure()))
        return 0
    try:
        found = environment.answer("exudyn", "benchmarks.peers.exudyn_mesh")
    except environment.NotInstalledError as error:
        print(f"skipped: {error}")
        return 1
    output.report(found, RESULTS)
    return 0


if __name__ == "__main__":
    sys.exit(main())
