"""Spalls that the mate bridges, by finite elements in contact: python -m benchmarks.peers.bridged_spalls

A rectangular spall covers half of the face of a pinion tooth. Its vertical walls are cut into the mesh (`VOID`), whose
rows are fine at the rims and at their mates on the wheel. What it adds to the deflection is the difference from the
healthy pair, whose rows are fine at the contact line. Computes what benchmarks/results/bridged_spalls.json does not
hold yet (a minute of processor time per position), then compares model `solid` with it. --compare only compares.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.clock import conditions
from benchmarks.gear_pairs import gear_pair
from benchmarks.peers import output
from benchmarks.peers.contact_deck import ContactModel
from benchmarks.peers.flank_contact import FACE, FlankContact
from benchmarks.peers.tooth_mesh import Profile, Sizes, contact_rows, graded
from benchmarks.peers.wheel_mesh import HEXAHEDRON
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.faults.changed_law import damaged_law
from fem.contact.faults.spalled_tooth import SpalledTooth
from fem.contact.models.solid import Solid
from fem.contact.teeth import tooth_terms
from fem.gears.geometry import GearPair

RESULTS = Path(__file__).resolve().parent.parent / "results" / "bridged_spalls.json"
TORQUES = (20.0, 75.0, 300.0)  # N m
PLACES = ((1.2e-3, 0.1), (3e-3, 0.5))  # height of the spall (m) and mesh cycle at which its rim is near the contact
HELICES = (0.0, 12.0)
DEEP = 4  # columns of elements
REACH = 0.65e-3  # m, of the flank around a contact line


@dataclass(frozen=True, kw_only=True)
class Spall:
    """A spall of the pinion tooth of pair 0 at y > 0 around the reference circle, and its mesh.

    finest : size of the elements at the rims, m; rows : numbers of elements below, at each rim inside, and above
    """

    helix_deg: float
    height: float
    cycle: float
    finest: float = 12e-6
    rows: tuple[int, int, int] = (7, 4, 7)
    face: int = 8
    across: int = 10

    @cached_property
    def pair(self) -> GearPair:
        """The pair of the crack benchmarks."""
        return gear_pair((20, 55), 2, self.helix_deg, 12, bores_mm=(12.5, 17.5))

    @property
    def rims(self) -> np.ndarray:
        """Arc lengths from the base circle, m."""
        gear = self.pair.pinion
        middle = (gear.reference_radius**2 - gear.base_radius**2) / (2 * gear.base_radius)
        return np.array([middle - self.height / 2, middle + self.height / 2])

    def sizes(self, contact: float, below: int, above: int, even: int) -> Sizes:
        """Of fine sectors."""
        return Sizes(
            contact=contact, below=below, above=above, even=even,
            fillet=3, across=self.across, land=2, layers=5, face=self.face,
        )  # fmt: skip

    @property
    def coarse(self) -> Sizes:
        """Of the other sectors."""
        return Sizes(contact=0.8e-3, below=1, above=1, fillet=1, across=2, land=1, layers=3, face=2)

    def healthy(self) -> FlankContact:
        """The pair without spall."""
        fine = self.sizes(5 * self.finest, 8, 8, 4)
        return FlankContact(ContactModel(pair=self.pair, cycle=self.cycle, fine=fine, coarse=self.coarse), 0.25e-3)

    def spalled(self) -> tuple[FlankContact, float]:
        """The pair with spall, and its depth (m)."""
        below, inside, above = self.rows
        count = below + 2 * inside + above
        fine = self.sizes(self.finest, count // 2, count - count // 2, 0)
        model = ContactModel(pair=self.pair, cycle=self.cycle, fine=fine, coarse=self.coarse)
        ends = self._ends(model)
        model = ContactModel(pair=self.pair, cycle=self.cycle, fine=fine, coarse=self.coarse, ends=ends)
        mesh = model.wheels[0]
        flank = mesh.flanks[0].reshape(-1, self.face)
        middle = (ends[0][0][:-1] + ends[0][0][1:])[:, 1::2] / 2 + Profile(self.pair.pinion).form_arc
        y = np.linspace(-0.5, 0.5, 2 * self.face + 1)[1::2]
        cut = flank[(y > 0) & (middle > self.rims[0]) & (middle < self.rims[1])]
        columns = cut[:, None] - self.face * np.arange(DEEP)
        back = np.flatnonzero(HEXAHEDRON[:, 1] == 0)
        top, floor = (mesh.nodes[mesh.elements[columns[:, k]]][:, n].mean(axis=1) for k, n in ((0, FACE), (-1, back)))
        depth = 1e-3 * float(np.linalg.norm(top - floor, axis=1).mean())
        return FlankContact(model, REACH, columns.ravel()), depth

    def _ends(self, model: ContactModel) -> tuple[dict[int, np.ndarray], dict[int, np.ndarray]]:
        """Ends of the rows of pair 0: at the contact line for y < 0, at the rims and their mates beyond."""
        pair, out = self.pair, []
        y = np.linspace(-0.5, 0.5, 2 * self.face + 1) * pair.face_width
        xi = model.position(0, y)
        for gear, rolls in zip((pair.pinion, pair.wheel), pair.roll_lengths(xi), strict=True):
            profile = Profile(gear)
            ends = contact_rows(profile, model.fine, profile.arc_of_roll(rolls))
            for k in np.flatnonzero(y > -1e-9):
                rims = self.rims if gear is pair.pinion else self._mates(model, xi[k])
                ends[:, k] = self._between(ends[:, k], np.sort(rims) - profile.form_arc, profile.length)
            out.append({0: ends})
        return out[0], out[1]

    def _mates(self, model: ContactModel, xi: float) -> np.ndarray:
        """Arc lengths on the wheel at which the rims touch it, m."""
        base1, base2 = self.pair.pinion.base_radius, self.pair.wheel.base_radius
        radius = np.sqrt(base1**2 + 2 * base1 * self.rims.clip(0.0))
        mate = FlankContact.mate_radius(model, np.full(2, xi), 1e3 * radius) / 1e3
        return np.asarray((mate**2 - base2**2) / (2 * base2))

    def _between(self, usual: np.ndarray, rims: np.ndarray, length: float) -> np.ndarray:
        """Ends (row,) of the same number, finest at the rims that lie on the flank; `usual` where none does."""
        below, inside, above = self.rows
        size, on = self.finest, (rims > 2 * self.finest) & (rims < length - 2 * self.finest)
        if on.all():
            half = graded((rims[1] - rims[0]) / 2, size, inside)
            floor = rims[0] + np.append(half, rims[1] - rims[0] - half[-2::-1])
            low = rims[0] - graded(rims[0], size, below)[::-1]
            return np.concatenate([low, floor[1:], rims[1] + graded(length - rims[1], size, above)[1:]])
        if on.any():
            rim, low = rims[on][0], len(usual) - 1 - above
            return np.append(rim - graded(rim, size, low)[::-1], rim + graded(length - rim, size, above)[1:])
        return usual

    def gap(self, depth: float) -> Any:
        """Function of y, xi and both radii: `depth` inside the spall."""
        base = self.pair.pinion.base_radius
        low, high = np.sqrt(base**2 + 2 * base * self.rims.clip(0.0))
        lead = self.pair.pinion.hand_sign * np.tan(self.pair.base_helix_angle) / self.pair.base_pitch

        def gap(y: np.ndarray, xi: np.ndarray, radius: np.ndarray, _: np.ndarray) -> np.ndarray:
            own = np.round(self.cycle + lead * y - xi) == 0
            return np.where(own & (y > 0) & (radius > low) & (radius < high), depth, 0.0)

        return gap

    def added(self) -> dict[str, Any]:
        """Healthy and added deflection, m, at every torque, by the elements."""
        healthy, (spalled, depth) = self.healthy(), self.spalled()
        rows = []
        for torque in TORQUES:
            force = torque / self.pair.pinion.base_radius
            sound, damaged = healthy.solve(force), spalled.solve(force, self.gap(depth))
            rows.append({"healthy_m": sound.delta / 1e3, "added_m": (damaged.delta - sound.delta) / 1e3})
        nodes = [len(body.mesh.nodes) for body in spalled.bodies]
        return {"depth_m": depth, "finest_m": self.finest, "nodes": nodes, "torques": rows}

    def by_solid(self, depth: float) -> list[float]:
        """Added deflection (torque,), m, by the model."""
        law = Solid().laws(self.pair)[0]
        fault = SpalledTooth(height=self.height, length=6e-3, position=3e-3, depth=depth, shape="rectangle")
        teeth = self.pair.pinion.teeth
        evaluator = LawEvaluator(damaged_law(law, self.pair, "pinion", [fault]))
        forces = np.array(TORQUES) / self.pair.pinion.base_radius
        damaged = tooth_terms(teeth, variant=np.arange(teeth) == 0)
        with_fault, without = (evaluator.approach_at(forces, self.cycle, 0.0, h) for h in (damaged, None))
        return (with_fault - without).ravel().tolist()


def main(arguments: list[str] | None = None) -> int:
    """Compute what is missing, compare, write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.peers.bridged_spalls")
    parser.add_argument("--compare", action="store_true", help="only compare with the stored figures")
    compare = parser.parse_args(arguments).compare
    result = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {"cases": {}}
    for helix in HELICES:
        for height, cycle in PLACES:
            spall = Spall(helix_deg=helix, height=height, cycle=cycle)
            name = f"β {helix:g}°, {1e3 * height:g} mm high, c = {cycle:g}"
            if name not in result["cases"]:
                if compare:
                    continue
                result["cases"][name] = spall.added()
                result["conditions"] = conditions()
                output.keep(result, RESULTS)
            case = result["cases"][name]
            case["solid_m"] = spall.by_solid(case["depth_m"])
            for torque, row, own in zip(TORQUES, case["torques"], case["solid_m"], strict=True):
                found = f"{name}, {torque:g} N m: healthy {1e6 * row['healthy_m']:.3f} um, "
                added = 1e6 * row["added_m"]
                print(f"{found}added {added:.3f} um, solid {1e8 * own / added - 100:+.1f} %", flush=True)
    output.keep(result, RESULTS)
    return 0


if __name__ == "__main__":
    sys.exit(main())
