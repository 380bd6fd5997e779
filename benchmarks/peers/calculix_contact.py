"""Approach of stage 1 of the rig by CalculiX, whole wheels in 3-D: python -m benchmarks.peers.calculix_contact

Computes what benchmarks/results/calculix_contact.json does not hold yet (minutes to half an hour per position and
mesh), then compares the models with it. --compare leaves CalculiX alone.

Every position is computed on two meshes of equal flank, fillet and body elements and more along the face; the
extrapolated value takes the error as quadratic in the element length along the face. The approach is set near the value
wanted and brought to the load by the local exponent d ln F / d ln(delta - delta_0) of model `plane`, a correction of
some per cent at most.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.clock import conditions
from benchmarks.peers import ccx, output
from benchmarks.peers.contact_deck import ContactModel
from benchmarks.peers.tooth_mesh import Sizes
from benchmarks.rig import plane_law, read
from benchmarks.solid_contact import solve as solve_solid
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.law import MeshLaw
from fem.contact.models.energy import Energy
from fem.contact.models.iso import Iso
from fem.contact.models.plane import Plane
from fem.contact.models.solid import Solid
from fem.gears.geometry import GearPair

RESULTS = Path(__file__).resolve().parent.parent / "results" / "calculix_contact.json"
PENALTY = 1e8  # N/mm3
POSITIONS = ((0.1, False), (0.6, False), (0.3, True), (0.6, True))  # mesh cycle, wheel tooth 0 missing
POSITIONS_PER_CYCLE = 10  # on which all POSITIONS lie
FACE_ELEMENTS = (4, 6)
CLOSE = 0.1  # largest relative distance of the computed from the wanted force


def sizes(pair: GearPair, face: int) -> tuple[Sizes, Sizes]:
    """Fine and coarse sectors; 0.03 m_n at the contact line, 0.1 % in the approach of a plane-strain slab."""
    module = pair.pinion.normal_module
    fine = Sizes(contact=0.03 * module, below=6, above=6, fillet=3, across=8, land=2, layers=5, face=face)
    return fine, Sizes(contact=0.4 * module, below=1, above=1, fillet=1, across=2, land=1, layers=3, face=2)


def approach(law: MeshLaw, force: float, cycle: float, missing: bool) -> tuple[float, float]:
    """delta (m) at the force (N) from the rigid position, and d ln F / d ln(delta - delta_0), by a model."""
    wheel = np.zeros(law.wheel_teeth)
    wheel[0] = np.inf if missing else 0.0
    found = stiffness_curve(law, force, np.array([cycle]), clearance_wheel=wheel)
    return float(found.transmission_error[0]), float(found.tangent[0] / found.secant[0])


def solve(
    pair: GearPair, force: float, cycle: float, missing: bool, face: int, start: float, exponent: float
) -> dict[str, Any]:
    """delta (m) at the force (N) by CalculiX from the guess `start` (m), with size, seconds and both torques."""
    fine, coarse = sizes(pair, face)
    model = ContactModel(
        pair=pair, cycle=cycle, missing=0 if missing else None, fine=fine, coarse=coarse, penalty=PENALTY
    )
    seconds = processor = 0.0
    guess, runs = start, 0
    with tempfile.TemporaryDirectory(prefix="gearcase-calculix-") as folder:
        while True:
            deck = Path(folder) / f"contact{runs}.inp"
            size = model.write(deck, (guess,))
            wall, used = ccx.run(deck)
            seconds, processor, runs = seconds + wall, processor + used, runs + 1
            (by_pinion,), (by_wheel,) = model.forces(deck)
            set_to, guess = guess, guess * (force / by_pinion) ** (1.0 / exponent)
            if abs(by_pinion / force - 1.0) < CLOSE or runs == 3:
                break
    return {
        "face_elements": face,
        "delta_m": guess,
        "delta_set_m": set_to,
        "force_N": by_pinion,
        "force_by_wheel_N": by_wheel,
        "seconds": seconds,
        "cpu_seconds": processor,
        "runs": runs,
        **size,
    }


def extrapolated(rows: list[dict[str, Any]]) -> float:
    """delta (m) for vanishing elements along the face, error taken as quadratic; of the one mesh if there is one."""
    last = rows[-1]
    if len(rows) == 1:
        return float(last["delta_m"])
    ratio = (last["face_elements"] / rows[-2]["face_elements"]) ** 2
    return float(last["delta_m"] + (last["delta_m"] - rows[-2]["delta_m"]) / (ratio - 1.0))


def compare(result: dict[str, Any], pair: GearPair, force: float) -> None:
    """Add the approach by every model, and its deviation from the extrapolated value, to the positions."""
    laws = {"iso": Iso().laws(pair)[0], "energy": Energy().laws(pair)[0], "plane": Plane().laws(pair)[0]}
    solid = Solid(positions=POSITIONS_PER_CYCLE).compliance(pair)
    for place in result["positions"]:
        if not place["meshes"]:
            continue
        exact = place["extrapolated_m"] = extrapolated(place["meshes"])
        found = {name: approach(law, force, place["cycle"], place["missing"])[0] for name, law in laws.items()}
        index = np.array([round(place["cycle"] * POSITIONS_PER_CYCLE)])
        state = solve_solid(solid, index, force=force, clearance={0: math.inf} if place["missing"] else None)
        found["solid"] = float(state.approach[0])
        place["models"] = {name: {"delta_m": delta, "deviation": delta / exact - 1.0} for name, delta in found.items()}


def main(arguments: list[str] | None = None) -> int:
    """Compute what is missing, compare, write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.peers.calculix_contact")
    parser.add_argument("--compare", action="store_true", help="only compare the models with the stored figures")
    only = parser.parse_args(arguments).compare
    machine = read()
    pair, force = machine.layout.pairs[0], machine.facts.stages[0].mesh_force
    result = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {"positions": []}
    if only and not result["positions"]:
        print("skipped: no figures of CalculiX are stored; python -m benchmarks.peers.calculix_contact computes them")
        return 1
    try:
        if not only:
            law = plane_law(pair)[0]
            result |= {"program": f"CalculiX {ccx.version()}", "element": "C3D20R", "penalty_N_per_mm3": PENALTY}
            result |= {"pair": pair.label, "force_N": force, "conditions": conditions()}
            for face in FACE_ELEMENTS:
                for cycle, missing in POSITIONS:
                    compute(result, pair, force, law, cycle, missing, face)
    except ccx.PeerMissing as error:
        print(f"skipped: {error}")
        return 1
    compare(result, pair, force)
    output.keep(result, RESULTS)
    for place in result["positions"]:
        found = ", ".join(f"{name} {100 * r['deviation']:+.2f} %" for name, r in place.get("models", {}).items())
        where = f"cycle {place['cycle']:g}, {'tooth missing' if place['missing'] else 'healthy'}"
        print(f"{where}: delta {1e6 * place['extrapolated_m']:.4f} um; {found}")
    return 0


def compute(
    result: dict[str, Any], pair: GearPair, force: float, law: MeshLaw, cycle: float, missing: bool, face: int
) -> None:
    """One position on one mesh, unless it is there; written at once."""
    places = [p for p in result["positions"] if math.isclose(p["cycle"], cycle) and p["missing"] == missing]
    place = places[0] if places else {"cycle": cycle, "missing": missing, "meshes": []}
    if not places:
        result["positions"].append(place)
    if any(mesh["face_elements"] >= face for mesh in place["meshes"]):
        return
    delta, exponent = approach(law, force, cycle, missing)
    start = place["meshes"][-1]["delta_m"] if place["meshes"] else 1.08 * delta
    place["meshes"].append(solve(pair, force, cycle, missing, face, start, exponent))
    output.keep(result, RESULTS)
    found = place["meshes"][-1]
    print(f"cycle {cycle:g}, missing {missing}, {face} along the face: {1e6 * found['delta_m']:.4f} um, "
          f"{found['seconds']:.0f} s", flush=True)  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
