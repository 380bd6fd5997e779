"""Deflection of rims on webs under fixed loads on the flank, by tetrahedra: python -m benchmarks.gear_bodies

Computes what benchmarks/results/gear_bodies.json does not hold yet (about 2 and 10 minutes for the two meshes of a
gear), then compares the condensed sector of model `solid` with it: six places on one flank, near the root and near the
tip, at both ends of the face and in its middle.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.clock import conditions
from benchmarks.gear_pairs import gear
from benchmarks.tetrahedral_gear import Patch, Ring, Sizes, compliance
from fem.contact.models.solid import SECTION
from fem.contact.wheels.ring import flank_compliance
from fem.contact.wheels.solid_ring import solid_flank
from fem.contact.wheels.web_place import axial_ends, web_ends
from fem.elements.twisted_hexahedra import slice_means
from fem.gears.gear import Gear
from fem.gears.profile import form_radius, roll_length
from fem.gears.sector_mesh import sector_mesh

RESULTS = Path(__file__).resolve().parent / "results" / "gear_bodies.json"
YOUNG, POISSON = 206e9, 0.3
HEIGHTS = (0.3, 0.8)  # of the involute's length
HALF_WIDTH = 0.25  # of the patches, in m_n
SLICES = 6  # a patch is a slice long
MESHES = (
    (Sizes(flank=0.45e-3, teeth=1.8e-3, body=3.2e-3), 1.5e-3),
    (Sizes(flank=0.3e-3, teeth=1.2e-3, body=2.4e-3), 1.05e-3),
)  # and the longest layer along the face, m


@dataclass(frozen=True, kw_only=True)
class Body:
    """A gear z 24, m_n 2 mm, b 12 mm, bore radius 10 mm with a rim on a web; mm and degrees."""

    name: str
    helix: float
    rim: float
    web: float
    offset: float

    def gear(self) -> Gear:
        """In SI."""
        return replace(
            gear(24, helix_deg=self.helix, bore_mm=10.0),
            rim_thickness=self.rim / 1000,
            web_thickness=self.web / 1000,
            web_offset=self.offset / 1000,
        )


BODIES = (
    Body(name="web at the face end, spur", helix=0.0, rim=4.0, web=3.0, offset=4.5),
    Body(name="web at the face end, helix 12 degrees", helix=12.0, rim=4.0, web=3.0, offset=4.5),
    Body(name="thin rim, spur", helix=0.0, rim=2.4, web=4.0, offset=0.0),
    Body(name="thin rim, helix 12 degrees", helix=12.0, rim=2.4, web=4.0, offset=0.0),
)


def places(one: Gear) -> tuple[np.ndarray, np.ndarray]:
    """Arc lengths (height,) of the patches and their ends along the face (3, 2), m."""
    low, high = (roll_length(one, r) ** 2 / (2 * one.base_radius) for r in (form_radius(one), one.tip_form_radius))
    half, length = one.face_width / 2, one.face_width / SLICES
    ends = np.array([[-half, -half + length], [-length / 2, length / 2], [half - length, half]])
    return low + np.array(HEIGHTS) * (high - low), ends


def by_tetrahedra(body: Body, sizes: Sizes, layer: float) -> tuple[np.ndarray, int]:
    """Compliances (6, 6) between the places, m/N, and the number of unknowns."""
    one = body.gear()
    arcs, ends = places(one)
    width = HALF_WIDTH * one.normal_module
    patches = [Patch(arc=float(s), half_width=width, low=float(a), high=float(b)) for s in arcs for a, b in ends]
    half, inner = one.face_width / 2, one.rim_inner_radius
    web = web_ends(one, 1)
    rings = [
        Ring(inner=inner, outer=one.tip_radius, low=-half, high=half),
        Ring(inner=one.bore_radius, outer=inner, low=web[0], high=web[1]),
    ]
    joints = np.unique(np.round(np.concatenate([[-half, half], ends.ravel(), web]), 9))
    parts = [np.linspace(a, b, int(np.ceil((b - a) / layer)) + 1) for a, b in zip(joints[:-1], joints[1:], strict=True)]
    layers = np.unique(np.round(np.concatenate(parts), 9))
    return compliance(one, rings, "bore", patches, layers, sizes, YOUNG, POISSON)


def by_sector(body: Body, refinement: float = 1.0) -> np.ndarray:
    """The same as model `solid` takes them: a coarse section in space, made good by a fine one in the plane."""
    one = body.gear()
    arcs, ends = places(one)
    web = web_ends(one, 1)
    axial = axial_ends(one.face_width, round(8 * refinement), web)
    coarse, fine = sector_mesh(one, SECTION * refinement), sector_mesh(one, 1.5)
    width = HALF_WIDTH * one.normal_module
    own = []
    for mesh in (coarse, fine):
        flat = flank_compliance(mesh, YOUNG, POISSON, 1)
        weight, _ = flat.patches(arcs, width)
        own.append(np.einsum("pi,ij,pj->p", weight, flat.matrix[0], weight))
        if mesh is coarse:
            seen = weight
    rows = np.flatnonzero(seen.any(axis=0))
    matrix = solid_flank(coarse, YOUNG, POISSON, axial, rows, 1, web=web).matrix[0]
    means = np.vstack([slice_means(axial, np.array(pair)) for pair in ends])
    load = np.einsum("pr,sa->psra", seen[:, rows], means).reshape(len(arcs) * len(ends), -1)
    made_good = np.repeat(own[1] - own[0], len(ends)) * SLICES / one.face_width
    return load @ matrix @ load.T + np.diag(made_good)


def stored() -> dict[str, list[dict]]:
    """What the file holds, by the name of the body: one entry per mesh."""
    return json.loads(RESULTS.read_text(encoding="utf-8"))["bodies"] if RESULTS.exists() else {}


def reference(body: Body) -> np.ndarray:
    """Compliances (6, 6) between the places on the finest mesh that is stored, m/N."""
    finest = min(stored()[body.name], key=lambda entry: entry["flank_m"])
    return np.array(finest["compliance_m_per_N"])


def main() -> None:
    """Fill the file, then print the largest deviations."""
    for sizes, layer in MESHES:
        for body in BODIES:
            found = stored()
            entries = found.setdefault(body.name, [])
            if any(entry["flank_m"] == sizes.flank for entry in entries):
                continue
            matrix, unknowns = by_tetrahedra(body, sizes, layer)
            entries.append({"flank_m": sizes.flank, "unknowns": unknowns, "compliance_m_per_N": matrix.tolist()})
            content = {"conditions": conditions(), "bodies": found}
            RESULTS.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    for body in BODIES:
        ours = by_sector(body)
        for entry in stored()[body.name]:
            change = ours / np.array(entry["compliance_m_per_N"]) - 1.0
            own = np.diag(change)
            print(
                f"{body.name}, {entry['unknowns']} unknowns: own {own.min():+.2%} to {own.max():+.2%}, all others "
                f"{change.min():+.2%} to {change.max():+.2%}"
            )


if __name__ == "__main__":
    main()
