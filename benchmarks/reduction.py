"""Seconds and memory of a casing reduction from geometry to body: python -m benchmarks.reduction [--elements MM ...].

The housing of the shipped rig, feet held, eight bearings with five coordinates each, every fixed-interface mode to 1.5
times the band. Every case runs in a process of its own, the BLAS on one thread, the halves of the heavy steps side by
side on two; 15.8 mm gives about 150,000 unknowns, 9.2 mm about 400,000. Without options it runs all of `CASES`, else
the combinations of what is given. Writes benchmarks/results/reduction.json.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from itertools import product
from pathlib import Path
from typing import Any

from benchmarks.clock import conditions
from fem.processes.child import command, environment

CASES = (  # mm, Hz
    (26.0, 5000.0),
    (15.8, 10000.0 / 3.0),
    (15.8, 5000.0),
    (9.2, 5000.0),
)
RESULTS = Path(__file__).resolve().parent / "results" / "reduction.json"


def main(arguments: list[str] | None = None) -> int:
    """Measure every case; 1 if one fails."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.reduction", description="Cost of a casing reduction.")
    parser.add_argument("--elements", type=float, nargs="+", metavar="MM", help="element sizes")
    parser.add_argument("--bands", type=float, nargs="+", metavar="HZ", help="wanted bands")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    asked = tuple(product(given.elements or [15.8], given.bands or [5000.0]))
    if given.one:
        print(json.dumps(measure(*asked[0])))
        return 0
    cases = []
    for size, band in asked if given.elements or given.bands else CASES:
        cases.append(_in_child(size, band))
        print(_text(cases[-1]), flush=True)
    RESULTS.write_text(
        json.dumps({"conditions": conditions() | {"threads": 2}, "cases": cases}, indent=1) + "\n", encoding="utf-8"
    )
    return int(any("failed" in case for case in cases))


def measure(element_size: float, band: float) -> dict[str, Any]:
    """One case; steps with wall-clock and processor seconds."""
    from threadpoolctl import threadpool_limits

    from benchmarks.clock import peak_megabytes
    from benchmarks.rig import casing_parts, read
    from fem.casing.mesh.choose_mesher import mesh_geometry
    from fem.casing.mesh.sizes import Sizes
    from fem.casing.models.casing_model import Structure
    from fem.casing.models.craig_bampton import CraigBamptonCasing
    from fem.casing.reduced.casing_modes import casing_modes
    from fem.casing.reduced.checkup import check_up
    from fem.casing.reduced.grounded import assembled_casing
    from fem.casing.reduced.halves import reduced_and_counted
    from fem.casing.reduced.reduced_body import MODES_OVER_BAND

    steps: list[dict[str, Any]] = []

    def step(name: str, work: Any) -> Any:
        start, processor = time.perf_counter(), time.process_time()
        result = work()
        seconds, cpu = time.perf_counter() - start, time.process_time() - processor
        steps.append({"step": name, "seconds": seconds, "cpu_seconds": cpu, "peak_MB": peak_megabytes()})
        return result

    with threadpool_limits(1):
        box, iron = casing_parts(read())
        sizes = Sizes(element=element_size / 1000)
        recovery = CraigBamptonCasing(band=band).recovery(Structure(housing=box))
        limit = MODES_OVER_BAND * band
        mesh = step("geometry and mesh", lambda: mesh_geometry(box, sizes))
        casing = step(
            "assembly",
            lambda: assembled_casing(mesh, iron),
        )
        reduction, counted = step(
            "factorisation, constraint and fixed-interface modes and their count, inertia correction",
            lambda: reduced_and_counted(casing.subspaces, casing.loads, highest=limit),
        )
        modes = step(
            "basis on the mesh",
            lambda: casing_modes(casing, reduction, model="craig-bampton", band_limit=limit, counted=counted),
        )
        checked = step("check-up", lambda: check_up(casing, reduction))
        step("reduced body with nine sensors", lambda: recovery.build(modes=(modes, checked)))
    return {
        "element_size_mm": element_size,
        "band_Hz": band,
        "unknowns": casing.unknowns,
        "solver": reduction.solver,
        "interface": len(casing.coordinate_names),
        "modes": reduction.n_fixed,
        "counted": counted,
        "failures": list(checked.failures),
        "first_Hz": [float(f) for f in checked.frequencies[:3]],
        "seconds": sum(s["seconds"] for s in steps),
        "cpu_seconds": sum(s["cpu_seconds"] for s in steps),
        "peak_MB": peak_megabytes(),
        "steps": steps,
    }


def _in_child(size: float, band: float) -> dict[str, Any]:
    case = ["--elements", str(size), "--bands", str(band)]
    run = command("benchmarks.reduction", "--one", *case)
    done = subprocess.run(run, env=environment(), capture_output=True, text=True, check=False)
    if done.returncode:
        return {"element_size_mm": size, "band_Hz": band, "failed": done.stderr.strip()[-300:]}
    return json.loads(done.stdout.splitlines()[-1])


def _text(case: dict[str, Any]) -> str:
    if "failed" in case:
        return f"{case['element_size_mm']:g} mm: {case['failed']}"
    lines = [
        f"{case['unknowns']} unknowns, {case['interface']} interface coordinates, {case['modes']} modes to "
        f"{1.5 * case['band_Hz']:g} Hz (counted {case['counted']}), {case['solver']}"
    ]
    lines += [
        f"  {s['seconds']:7.1f} s  {s['cpu_seconds']:7.1f} s cpu  {s['peak_MB']:6.0f} MB  {s['step']}"
        for s in case["steps"]
    ]
    lines.append(f"  {case['seconds']:7.1f} s  {case['cpu_seconds']:7.1f} s cpu  {case['peak_MB']:6.0f} MB  in all")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
