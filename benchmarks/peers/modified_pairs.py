"""Modified pairs by finite elements in contact beside model `solid`: python -m benchmarks.peers.modified_pairs

Transmission error, flank pressure and root stress of pairs with tip relief, crowning and helix slope, on two meshes of
`flank_contact` with all element sizes in one ratio; the extrapolated value takes the error as quadratic in the size.
Computes what benchmarks/results/modified_pairs.json does not hold yet (about a minute of processor time per position),
then compares. --compare only compares.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np

from benchmarks.clock import conditions
from benchmarks.gear_pairs import gear_pair
from benchmarks.peers import output
from benchmarks.peers.contact_deck import ContactModel
from benchmarks.peers.flank_contact import Contact, FlankContact
from benchmarks.peers.tooth_mesh import Sizes
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.mesh_cycle import mesh_cycle
from fem.contact.faults.changed_law import modified_law
from fem.contact.models.solid import Solid
from fem.contact.models.solid_stress import SMOOTHED, root_stress
from fem.gears.geometry import GearPair
from fem.gears.modifications import FlankModifications, PairModifications, Relief

RESULTS = Path(__file__).resolve().parent.parent / "results" / "modified_pairs.json"
POSITIONS = 6
LINE_LOADS = (100e3, 200e3)  # N/m
SCALES: dict[float, Any] = {1.0: range(POSITIONS), 1.35: (0,)}  # positions by the number of elements in every direction
REACH = 0.12  # m_n, of the flank around a contact line
QUANTITIES = ("delta_m", "pressure_Pa", "root_stress_pinion_Pa", "root_stress_wheel_Pa")


@dataclass(frozen=True, kw_only=True)
class Case:
    """A pair with tip relief (m, on both gears, over `length` of the path, power 1 or 2), crowning and slope (m)."""

    teeth: tuple[int, int]
    helix_deg: float
    face_mm: float
    bores_mm: tuple[float, float]
    relief: float = 0.0
    length: float = 2.5e-3
    power: int = 1
    crowning: float = 0.0
    slope: float = 0.0

    @cached_property
    def pair(self) -> GearPair:
        """The pair, module 2 mm."""
        return gear_pair(self.teeth, 2, self.helix_deg, self.face_mm, bores_mm=self.bores_mm)

    @property
    def modifications(self) -> PairModifications:
        """As the product takes them."""
        shape: Literal["linear", "parabolic"] = "linear" if self.power == 1 else "parabolic"
        tip = Relief(amount=self.relief, length=self.length, shape=shape) if self.relief else None
        return PairModifications(
            pinion=FlankModifications(tip_relief=tip, lead_crowning=self.crowning, helix_slope=self.slope),
            wheel=FlankModifications(tip_relief=tip),
        )

    def gap(self, y: np.ndarray, _: np.ndarray, *radii: np.ndarray) -> np.ndarray:
        """The same material, m, at face coordinates and radii of both gears (m)."""
        b = self.pair.face_width
        out = self.crowning * (2 * y / b) ** 2 + self.slope * y / b
        for gear, radius in zip((self.pair.pinion, self.pair.wheel), radii, strict=True):
            roll, tip = (np.sqrt(r**2 - gear.base_radius**2) for r in (radius, gear.tip_form_radius))
            out = out + self.relief * np.clip(1 - (tip - roll) / self.length, 0.0, None) ** self.power
        return out


CASES = {
    "25/62, β 12°, tip relief 20 µm": Case(
        teeth=(25, 62), helix_deg=12, face_mm=20, bores_mm=(15, 20), relief=20e-6
    ),
    "25/62, β 12°, lead crowning 12 µm": Case(
        teeth=(25, 62), helix_deg=12, face_mm=20, bores_mm=(15, 20), crowning=12e-6
    ),
    "20/55, β 20°, tip relief 15 µm (parabolic), lead crowning 8 µm, helix slope 10 µm": Case(
        teeth=(20, 55), helix_deg=20, face_mm=16, bores_mm=(12.5, 17.5),
        relief=15e-6, power=2, crowning=8e-6, slope=10e-6,
    ),
}  # fmt: skip


def sizes(module: float, scale: float) -> tuple[Sizes, Sizes]:
    """Fine and coarse sectors, every number of elements times `scale`."""

    def of(contact: float, **counts: int) -> Sizes:
        return Sizes(contact=contact * module / scale, **{k: round(scale * n) for k, n in counts.items()})

    return (
        of(0.03, below=7, above=7, fillet=5, across=8, land=2, layers=5, face=8, even=4),
        of(0.4, below=1, above=1, fillet=1, across=2, land=1, layers=3, face=2),
    )


def measured(model: FlankContact, case: Case, state: Contact) -> dict[str, float]:
    """What is compared, of one state."""
    pair = case.pair
    out = {"delta_m": state.delta / 1e3, "pressure_Pa": 1e6 * pressure(model, pair, state)}
    for name, body, nodes, force, turn in zip(
        ("pinion", "wheel"), model.bodies, model.nodes, state.force, (0, 1), strict=True
    ):
        start = np.hypot(body.gear.base_radius, min(pair.roll_lengths(xi)[turn] for xi in (pair.xi_start, pair.xi_end)))
        highest = 1e3 * (start - SMOOTHED * body.gear.normal_module)
        fine = model.model.fine
        stress = body.root_stress(nodes, force, highest, fine.across, fine.face)
        out[f"root_stress_{name}_Pa"] = 1e6 * float(stress.max())
    return out


def pressure(model: FlankContact, pair: GearPair, state: Contact) -> float:
    """Largest Hertz pressure (MPa) within the path by the line load of every line of Gauss points across the contact.

    The traction itself is larger at the kink where a linear relief starts and at tip edges.
    """
    inside = (model.xi > pair.xi_start) & (model.xi < pair.xi_end) & (state.traction > 0)
    line = np.unique(np.round(model.xi, 9), return_inverse=True)[1]
    load = np.bincount(line, model.line_weight * state.traction)[line][inside]
    curvature = (1e-3 / np.stack(pair.roll_lengths(model.xi[inside]))).sum(axis=0) * np.cos(pair.base_helix_angle)
    softness = sum(1e6 / m.plane_strain_modulus for m in (pair.pinion_material, pair.wheel_material))
    return float(np.sqrt((load * curvature).max() / (np.pi * softness)))


def compute(result: dict[str, Any], position: int, scale: float) -> None:
    """All cases and loads at one position on one mesh, unless they are there; written at once."""
    for pair_of in dict.fromkeys((c.teeth, c.helix_deg) for c in CASES.values()):
        names = [n for n, c in CASES.items() if (c.teeth, c.helix_deg) == pair_of]
        key = f"{position}, {scale:g}"
        if all(key in result["cases"].get(n, {}) for n in names):
            continue
        pair = CASES[names[0]].pair
        fine, coarse = sizes(pair.pinion.normal_module, scale)
        deck = ContactModel(pair=pair, cycle=position / POSITIONS, fine=fine, coarse=coarse)
        model = FlankContact(deck, REACH * pair.pinion.normal_module)
        for name in names:
            case, rows = CASES[name], []
            for line_load in LINE_LOADS:
                state = model.solve(line_load * pair.face_width, case.gap)
                rows.append(measured(model, case, state))
            nodes = [len(b.mesh.nodes) for b in model.bodies]
            result["cases"].setdefault(name, {})[key] = {"nodes": nodes, "loads": rows}
            print(
                f"{name}: position {key}: " + "; ".join(", ".join(f"{v:.5g}" for v in r.values()) for r in rows),
                flush=True,
            )
        output.keep(result, RESULTS)


def extrapolated(found: dict[str, Any]) -> np.ndarray:
    """Quantities (load, position, quantity) for vanishing elements; of the coarse mesh if there is no other.

    The ratio to the coarse mesh is that at the positions that are solved on both, linear between them.
    """

    def values(scale: float) -> np.ndarray:
        rows = [found[f"{p}, {scale:g}"]["loads"] for p in SCALES[scale] if f"{p}, {scale:g}" in found]
        return np.array([[[row[q] for q in QUANTITIES] for row in position] for position in rows])

    first, second = SCALES
    coarse, fine, some = values(first), values(second), list(SCALES[second])
    if len(fine) < len(some):
        return np.asarray(coarse.swapaxes(0, 1))
    ratio = 1 + (fine / coarse[some] - 1) / (1 - (first / second) ** 2)
    around = np.concatenate([ratio, ratio[:1]]).reshape(len(some) + 1, -1)
    between = np.array([np.interp(range(POSITIONS), [*some, POSITIONS], column) for column in around.T]).T
    return np.asarray((coarse * between.reshape(coarse.shape)).swapaxes(0, 1))


def by_solid(case: Case) -> np.ndarray:
    """The same quantities by the product."""
    pair, solid = case.pair, Solid()
    law = modified_law(solid.laws(pair)[0], pair, case.modifications)
    forces = np.array(LINE_LOADS) * pair.face_width
    cycle = mesh_cycle(pair, LawEvaluator(law), forces, 0.0, POSITIONS)
    roots, out = root_stress(pair, solid), []
    for k in range(len(forces)):
        pairs, loads = cycle.line_loads(k)
        one = [
            mesh_position_pressure(cycle, k),
            *(r.of(law, cycle.cycle, pairs, loads).max(axis=(1, 2)) for r in roots),
        ]
        out.append(np.column_stack([cycle.error[k], *one]))
    return np.array(out)


def mesh_position_pressure(cycle: Any, load: int) -> np.ndarray:
    """Largest pressure (position,), Pa."""
    from fem.contact.contact_pressure import flank_pressure

    return flank_pressure(cycle.pair, cycle.evaluator.law, cycle.cycle, *cycle.line_loads(load)).max(axis=(1, 2))


def described(cases: dict[str, Any]) -> str:
    """The meshes in words."""
    first, second = SCALES
    coarse = max(max(case[f"0, {first:g}"]["nodes"]) for case in cases.values())
    finer = [max(case[f"0, {second:g}"]["nodes"]) for case in cases.values() if f"0, {second:g}" in case]
    words = f"Mesh of up to {coarse} nodes per gear"
    if not finer:
        return f"{words}, one mesh, not extrapolated."
    some = "" if len(finer) == len(cases) else f" for {len(finer)} of {len(cases)} pairs"
    return f"{words}{some}, of {max(finer)} at c = 0, from which all positions are extrapolated."


def main(arguments: list[str] | None = None) -> int:
    """Compute what is missing, compare, write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.peers.modified_pairs")
    parser.add_argument("--compare", action="store_true", help="only compare with the stored figures")
    result = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {"cases": {}}
    if not parser.parse_args(arguments).compare:
        result["conditions"] = conditions()
        for scale, positions in SCALES.items():
            for position in positions:
                compute(result, position, scale)
    for name, case in CASES.items():
        exact, own = extrapolated(result["cases"][name]), by_solid(case)
        result["cases"][name]["compared"] = {"elements": exact.tolist(), "solid": own.tolist()}
        for line_load, a, b in zip(LINE_LOADS, exact, own, strict=True):
            print(name, line_load)
            print("  mean", a[:, 0].mean(), b[:, 0].mean() / a[:, 0].mean() - 1, "pp", np.ptp(a[:, 0]), np.ptp(b[:, 0]))
            for k in (1, 2, 3):
                print("  ", QUANTITIES[k], a[:, k].max(), b[:, k].max() / a[:, k].max() - 1, (b[:, k] / a[:, k] - 1))
    result["meshes"] = described(result["cases"])
    output.keep(result, RESULTS)
    return 0


if __name__ == "__main__":
    sys.exit(main())
