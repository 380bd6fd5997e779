"""A gear pair as a three-dimensional contact model of CalculiX: both wheels whole, bores rigid, flanks in contact.

The bore of the wheel is held; the bore of the pinion is turned by delta / r_b1 from the rigid, error-free position in
which the flanks just touch. The torque of the bore nodes over r_b1 is the force F along the transverse line of action.
Turning instead of loading keeps the first, still open contact from leaving the pinion free. Penalty contact, surface to
surface, no friction; C3D20R elements. N, mm, MPa.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy import sparse

from benchmarks.peers import ccx
from benchmarks.peers.tooth_mesh import Sizes
from benchmarks.peers.wheel_mesh import LOADED_FACE, WheelMesh, wheel_mesh
from fem.elements.materials import Material
from fem.gears.geometry import GearPair
from fem.gears.path import path_points

NAMES = ("PINION", "WHEEL")


@dataclass(frozen=True, kw_only=True)
class ContactModel:
    """One position of a pair: mesh cycle, the pair number whose wheel tooth is broken off, sizes and penalty.

    ends : of pinion and wheel, by pair number, see `wheel_mesh`
    penalty in N/mm3; largest_gap (m): pairs that are closer than this somewhere on the face have fine teeth.
    plane_strain holds every node along the axis.
    """

    pair: GearPair
    cycle: float
    missing: int | None = None
    fine: Sizes
    coarse: Sizes
    penalty: float = 1e8
    largest_gap: float = 15e-6
    plane_strain: bool = False
    ends: tuple[dict[int, np.ndarray], dict[int, np.ndarray]] = field(default_factory=lambda: ({}, {}))

    def position(self, number: int, height: np.ndarray) -> np.ndarray:
        """Position xi of a tooth pair on the path of contact at the face coordinates `height` (m)."""
        lead = math.tan(self.pair.base_helix_angle) / self.pair.base_pitch
        return self.cycle - number + self.pair.pinion.hand_sign * lead * height

    def candidates(self) -> list[int]:
        """Pair numbers, without holes, of the teeth that can touch."""
        height = np.linspace(-0.5, 0.5, 101) * self.pair.face_width
        numbers = range(math.floor(self.cycle) - 4, math.floor(self.cycle) + 5)
        near = [
            n for n in numbers if path_points(self.pair, self.position(n, height), self.largest_gap).gap.min() < np.inf
        ]
        return list(range(min(near), max(near) + 1))

    @cached_property
    def wheels(self) -> tuple[WheelMesh, WheelMesh]:
        """The meshes of pinion and wheel, each about its own axis."""
        pair, out = self.pair, []
        tangent, pitch = math.tan(pair.working_pressure_angle), pair.base_pitch
        station = np.linspace(-0.5, 0.5, 2 * self.fine.face + 1) * pair.face_width
        for gear, sign, turned in ((pair.pinion, 1.0, 0.0), (pair.wheel, -1.0, math.pi)):

            def roll(number: int, height: np.ndarray, gear=gear, sign=sign) -> np.ndarray:
                return gear.base_radius * tangent + sign * pitch * self.position(number, height)

            def centre(number: int, height: np.ndarray, gear=gear, roll=roll, turned=turned) -> np.ndarray:
                leads = roll(number, height) / gear.base_radius - gear.half_thickness_angle(gear.base_radius)
                return turned - pair.working_pressure_angle + leads

            out.append(
                wheel_mesh(
                    gear,
                    centre,
                    {n: roll(n, station) for n in self.candidates()},
                    self.fine,
                    self.coarse,
                    falling=sign > 0.0,
                    missing=self.missing if sign < 0.0 else None,
                    ends=self.ends[sign < 0.0],
                )
            )
        return out[0], out[1]

    def write(self, deck: Path, approaches: tuple[float, ...]) -> dict[str, int]:
        """Write the deck for the approaches delta (m), one step each; its size."""
        pair, wheels = self.pair, self.wheels
        shift = len(wheels[0].nodes)
        lines: list[str] = ["*HEADING", f"{pair.label}, mesh cycle {self.cycle:.6f}", "*NODE, NSET=ALL"]
        for wheel, first, place in ((wheels[0], 1, 0.0), (wheels[1], 1 + shift, 1000.0 * pair.axis_distance)):
            for i, (x, y, z) in enumerate(wheel.nodes, first):
                lines.append(f"{i},{x + place:.12g},{y:.12g},{z:.12g}")
        elements = [0, len(wheels[0].elements)]
        for k, (name, wheel) in enumerate(zip(NAMES, wheels, strict=True)):
            lines += _elements(name, wheel, 1 + k * shift, 1 + elements[k])
            lines += [f"*NSET, NSET={name}BORE", *_wrapped(wheel.bore + 1 + k * shift)]
            lines += [f"*NSET, NSET={name}CUT", *_wrapped(_bonded(wheel)[0] + 1 + k * shift)]
            lines += _equations(wheel, 1 + k * shift, 2 if self.plane_strain else 3)
        for name, material in zip(NAMES, (pair.pinion_material, pair.wheel_material), strict=True):
            lines += _material(name, material)
        lines += ["*SURFACE INTERACTION, NAME=FLANKS", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
        lines += [f"{self.penalty:.6g}"]
        for number in sorted(wheels[0].flanks.keys() & wheels[1].flanks.keys()):
            for name, wheel, first in zip(NAMES, wheels, elements, strict=True):
                lines += [f"*SURFACE, NAME={name}{_tag(number)}, TYPE=ELEMENT"]
                lines += [f"{e + 1 + first},S{LOADED_FACE}" for e in wheel.flanks[number]]
            lines += ["*CONTACT PAIR, INTERACTION=FLANKS, TYPE=SURFACE TO SURFACE"]
            lines += [f"PINION{_tag(number)},WHEEL{_tag(number)}"]
        lines += ["*BOUNDARY", "WHEELBORE,1,3"]
        if self.plane_strain:
            lines += ["ALL,3,3"]
        for approach in approaches:
            lines += self._step(wheels[0], approach)
        deck.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return {"nodes": sum(len(w.nodes) for w in wheels), "elements": sum(len(w.elements) for w in wheels)}

    def _step(self, pinion: WheelMesh, approach: float) -> list[str]:
        angle = approach / self.pair.pinion.base_radius
        x, y = pinion.nodes[pinion.bore, :2].T
        moved_x = x * (math.cos(angle) - 1.0) - y * math.sin(angle)
        moved_y = x * math.sin(angle) + y * (math.cos(angle) - 1.0)
        lines = ["*STEP, INC=1000", "*STATIC", "1.,1.", "*BOUNDARY"]
        for node, u, v in zip(pinion.bore + 1, moved_x, moved_y, strict=True):
            lines += [f"{node},1,1,{u:.12g}", f"{node},2,2,{v:.12g}", f"{node},3,3,0."]
        for name in NAMES:
            lines += [f"*NODE PRINT, NSET={name}BORE", "RF", f"*NODE PRINT, NSET={name}CUT", "RF"]
        return [*lines, "*END STEP"]

    def forces(self, deck: Path) -> tuple[np.ndarray, np.ndarray]:
        """F (N) of every step, from the torque of the pinion's bore and from that of the wheel's.

        What the constraints hand to nodes of the bore is no part of their printed force and is added here.
        """
        out, first = [], 1
        for name, wheel, gear in zip(NAMES, self.wheels, (self.pair.pinion, self.pair.wheel), strict=True):
            cut, share = _bonded(wheel)
            x, y = wheel.nodes[:, :2].T
            lever = np.zeros((len(wheel.nodes), 2))  # moment of a force on the node that the bore takes
            lever[wheel.bore] = np.column_stack([-y, x])[wheel.bore]
            lever[cut] = share @ np.column_stack([-y, x])
            torque = 0.0
            for part in ("BORE", "CUT"):
                found = ccx.tables(deck.with_suffix(".dat"), f"forces (fx,fy,fz) for set {name}{part}")
                nodes = found[0][1][:, 0].astype(int) - first
                torque = torque + np.array([(lever[nodes] * rows[:, 1:3]).sum() for _, rows in found])
            out.append(torque / (1000.0 * gear.base_radius))
            first += len(wheel.nodes)
        return out[0], out[1]


def _bonded(wheel: WheelMesh) -> tuple[np.ndarray, sparse.csr_matrix]:
    """Constrained nodes that hang on nodes of the bore, and the weights of those: (constrained, nodes)."""
    bore = set(wheel.bore.tolist())
    found = [
        (d, n, w) for d, nodes, weights in wheel.constraints for n, w in zip(nodes, weights, strict=True) if n in bore
    ]
    dependent, node, weight = (np.array(column) for column in zip(*found, strict=True))
    cut, row = np.unique(dependent, return_inverse=True)
    return cut, sparse.csr_matrix((weight, (row, node)), shape=(cut.size, len(wheel.nodes)))


def _elements(name: str, wheel: WheelMesh, first_node: int, first_element: int) -> list[str]:
    lines = [f"*ELEMENT, TYPE=C3D20R, ELSET={name}"]
    for i, nodes in enumerate(wheel.elements + first_node, first_element):
        lines += [f"{i}," + ",".join(map(str, nodes[:10])) + ",", ",".join(map(str, nodes[10:]))]
    return lines


def _equations(wheel: WheelMesh, first: int, axes: int) -> list[str]:
    lines = []
    for dependent, nodes, weights in wheel.constraints:
        for axis in range(1, axes + 1):
            terms = [f"{dependent + first},{axis},1."]
            terms += [f"{node + first},{axis},{-weight:.12g}" for node, weight in zip(nodes, weights, strict=True)]
            lines += ["*EQUATION", str(len(terms))]
            lines += [",".join(terms[i : i + 4]) for i in range(0, len(terms), 4)]
    return lines


def _material(name: str, material: Material) -> list[str]:
    return [
        f"*MATERIAL, NAME={name}STEEL",
        "*ELASTIC",
        f"{material.elastic_modulus / 1e6:.12g},{material.poisson_ratio:.12g}",
        f"*SOLID SECTION, ELSET={name}, MATERIAL={name}STEEL",
    ]


def _tag(number: int) -> str:
    return f"{'M' if number < 0 else 'P'}{abs(number)}"


def _wrapped(numbers: np.ndarray) -> list[str]:
    return [",".join(map(str, numbers[i : i + 12])) + "," for i in range(0, len(numbers), 12)]
