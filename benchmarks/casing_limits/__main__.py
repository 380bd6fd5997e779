"""Limits and bands put to the test: python -m benchmarks.casing_limits [HOUSING ...].

Every housing is meshed as the preset `standard` meshes it and extrapolated; all its modes to 3.5 kHz, 60 at most, are
held against references of another element (`benchmarks.casing_limits.reference`). Writes
benchmarks/results/casing_limits.json and the table in docs/theory.md. Housings named on the command line are measured
again, the others are taken over from the last result; with --limits their references are, too.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.casing_limits.housings import CASES, Case
from benchmarks.casing_limits.reference import reference
from benchmarks.clock import conditions
from benchmarks.markdown import markdown
from benchmarks.page import filled
from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.uncertainty.extrapolation import limits_from, lowest_modes

ROOT = Path(__file__).resolve().parent.parent.parent
RESULTS = ROOT / "benchmarks" / "results" / "casing_limits.json"
PAGE = ROOT / "docs" / "theory.md"
BLOCK = "casing limits"
HIGHEST = 3500.0  # Hz
HEADERS = (
    "housing", "element", "unknowns", "modes", "modes inside their band", "band, %", "error before extrapolation, %",
    "error after extrapolation, %", "uncertainty of the reference, %",
)  # fmt: skip


def measured(case: Case, last: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Frequencies, limits, bands and references (Hz) of the modes of one housing; references of the last result."""
    mesh = mesh_geometry(case.geometry, case.sizes, case.element)
    cubic, quadratic = found = [
        lowest_modes(assembled_casing(one, case.material), static=False) for one in (mesh, replace(mesh, cubic=0))
    ]
    inside = cubic.frequencies <= HIGHEST
    limits = limits_from(cubic.frequencies[inside], cubic.shapes[:, inside], cubic.element_size, [quadratic])
    numbers = {"frequencies": limits.frequencies, "limits": limits.limits, "bands": limits.bands}
    rounded = {name: values.round(4).tolist() for name, values in numbers.items()}
    if last is not None:
        before = last["Hz"]["frequencies"]
        if len(before) != len(limits.frequencies) or not np.allclose(rounded["frequencies"], before, rtol=1e-6):
            raise SystemExit(f"{case.name}: its frequencies are no longer those of the last result; leave out --limits")
        return {**last, "unknowns": [one.unknowns for one in found], "Hz": {**last["Hz"], **rounded}}
    fineness = case.reference_size, case.reference_levels
    exact = reference(case.build, case.material, *fineness, limits.frequencies, cubic.shapes[:, inside])
    references = {"references": exact.limits, "uncertainties": exact.uncertainties, "upper_bounds": exact.finest}
    return {
        "housing": case.name,
        "element": case.element,
        "unknowns": [one.unknowns for one in found],
        "reference": {
            "size": case.reference_size,
            "levels": case.reference_levels,
            "unknowns_of_half": exact.unknowns,
            "order": exact.order,
        },
        "Hz": {**rounded, **{name: values.round(4).tolist() for name, values in references.items()}},
    }


def row(result: Mapping[str, Any]) -> list[str]:
    """One line of the table; modes without counterpart on the finest mesh of the reference count as outside."""
    hz = {name: np.array(values) for name, values in result["Hz"].items()}
    inside = abs(hz["references"] - hz["limits"]) <= hz["bands"]
    parts = {
        "band": hz["bands"] / hz["limits"],
        "mesh": hz["frequencies"] / hz["references"] - 1.0,
        "limit": hz["limits"] / hz["references"] - 1.0,
        "reference": hz["uncertainties"] / hz["references"],
    }
    return [
        result["housing"],
        result["element"],
        f"{result['unknowns'][0]:,}",
        str(len(inside)),
        f"{100 * inside.mean():.0f} %",
        *(_median_and_worst(values) for values in parts.values()),
    ]


def _median_and_worst(values: np.ndarray) -> str:
    known = 100.0 * values[np.isfinite(values)]
    return f"{np.median(known):.2f} ({known[abs(known).argmax()]:.2f})"


def table(results: Mapping[str, Any]) -> str:
    """The housings that were measured."""
    return markdown(HEADERS, [row(results[name]) for name in CASES if name in results])


def main(arguments: list[str] | None = None) -> int:
    """Measure, write, print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.casing_limits", description="Test the limits.")
    parser.add_argument("housing", nargs="*", help=f"all if none is given: {', '.join(CASES)}")
    parser.add_argument("--limits", action="store_true", help="limits anew, references of the last result")
    options = parser.parse_args(arguments)
    chosen = options.housing
    if unknown := [name for name in chosen if name not in CASES]:
        parser.error(f"unknown housing {', '.join(unknown)}; known: {', '.join(CASES)}")
    results = json.loads(RESULTS.read_text(encoding="utf-8"))["housings"] if RESULTS.exists() else {}
    with tempfile.TemporaryDirectory(prefix="gearcase-casing-limits-") as folder:
        for name in chosen or CASES:
            print(name, flush=True)
            results[name] = measured(CASES[name](Path(folder)), results[name] if options.limits else None)
            kept = {"conditions": conditions(), "housings": results}
            RESULTS.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
            text = PAGE.read_text(encoding="utf-8")
            PAGE.write_text(filled(text, BLOCK, table(results)), encoding="utf-8")
    print(table(results))
    return 0


if __name__ == "__main__":
    sys.exit(main())
