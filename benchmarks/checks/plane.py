"""Rung plane: tooth compliances, a contact solution in the section, and one in space."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cache

import numpy as np
from scipy import sparse

from benchmarks.checks.record import Check, Values
from fem.contact.evaluation.curves import stiffness_curve
from fem.contact.law import MeshLaw
from fem.contact.models.plane import Plane
from fem.contact.wheels import ring
from fem.elements.sections import shape_functions
from fem.gears.geometry import Gear, GearPair
from fem.gears.sector import SectorMesh, sector_mesh

SUBJECT = "Mesh stiffness, rung plane"
YOUNG, POISSON = 206e9, 0.3


def _gear(
    teeth: int, module: float, helix: float = 0.0, face: float = 0.03, hand: str = "right", bore: float | None = None
) -> Gear:
    """Standard gear, bore at r_f / 1.4 unless given (m)."""
    root = (teeth / math.cos(helix) / 2 - 1.25) * module
    return Gear(
        teeth=teeth,
        normal_module=module,
        helix_angle=helix,
        face_width=face,
        hand=hand,
        bore_radius=root / 1.4 if bore is None else bore,
    )


@cache
def _spur_law() -> MeshLaw:
    pair = GearPair(pinion=_gear(20, 2e-3), wheel=_gear(55, 2e-3, hand="left"))
    return Plane(slices=1).law(pair, "drive")


def _single_pair(line_load: float) -> Callable[[], Values]:
    """c' = f / x (N/(mm um)) at the pitch point."""

    def compute() -> Values:
        law = _spur_law()
        at = law.position_start + law.position_step * np.arange(law.compliance.size)
        c, b = np.interp(0.0, at, law.compliance), np.interp(0.0, at, law.contact_offset)
        return [float(1.0 / (c + law.contact_slope * (b - math.log(line_load)))) / 1e9]

    return compute


@cache
def _helical_state() -> tuple[float, float]:
    """Approach normal to the flank (um) and secant stiffness (N/um)."""
    beta = math.radians(20.0)
    pair = GearPair(
        pinion=_gear(17, 1e-3, beta, 10e-3, bore=5.568e-3),
        wheel=_gear(43, 1e-3, beta, 10e-3, "left", bore=15.450e-3),
        centre_distance=31.925333e-3,
    )
    force = 2.0 / pair.pinion.base_radius
    curve = stiffness_curve(Plane(slices=31).law(pair, "drive"), force, np.array([0.1325]))
    return float(curve.transmission_error[0]) * math.cos(pair.base_helix_angle) * 1e6, float(curve.secant[0]) / 1e6


def _tooth(teeth: int, radius_mm: float) -> Callable[[], Values]:
    """Displacement (um per N/mm) where the load line crosses the tooth centre line; module 1 mm."""

    def compute() -> Values:
        gear = _gear(teeth, 1e-3)
        mesh, radius = sector_mesh(gear, refinement=2.0), radius_mm / 1000
        arc = (radius**2 - gear.base_radius**2) / (2 * gear.base_radius)
        flank = ring.FlankCompliance(arc=mesh.flank_arc, tip_arc=mesh.tip_arc, matrix={})
        load = ring.flank_loads(mesh) @ flank.patches(np.array([arc]), 0.04e-3)[0].T
        slope = gear.pressure_angle_at(radius) - gear.half_thickness_angle(radius)
        seen = _point_load(
            mesh, np.array([gear.base_radius / math.cos(slope), 0.0]), -np.array([math.sin(slope), math.cos(slope)])
        )
        both = sparse.csc_matrix(np.column_stack([load.ravel(), seen]))
        response = ring.ring_response(ring.reduce_sector(mesh, YOUNG, POISSON, both))
        return [float(response[0][1, 0]) * 1e9]

    return compute


def _point_load(mesh: SectorMesh, place: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Load vector of a unit force at a point inside the mesh."""
    nearest = np.argsort(np.linalg.norm(mesh.points[mesh.elements[:, 4]] - place, axis=1))[:20]
    for element in mesh.elements[nearest]:
        corners, local = mesh.points[element], np.zeros(2)
        for _ in range(20):
            values, slopes = shape_functions(np.clip(local, -2, 2)[None])
            local = np.clip(local, -2, 2) - np.linalg.solve(corners.T @ slopes[0], values[0] @ corners - place)
        if np.abs(local).max() <= 1 + 1e-9:
            out = np.zeros((len(mesh.points), 2))
            out[element] = shape_functions(local[None])[0][0][:, None] * direction
            return out.ravel()
    raise RuntimeError(f"{place} m is not in the sector mesh")


def checks() -> Iterator[Check]:
    """All rows of this subject."""
    for teeth, radius, value in (
        (17, 8.0023, 0.01626),
        (17, 8.5, 0.02226),
        (43, 21.5, 0.02085),
        (43, 22.4434, 0.05411),
    ):
        yield Check(
            subject=SUBJECT,
            quantity=f"tooth compliance seen on its centre line, z {teeth}, m 1 mm, load at r = {radius} mm",
            source="two independent plane strain FE solutions of the whole ring",
            unit="µm/(N/mm)",
            reference=(value,),
            gate=5e-3,
            compute=_tooth(teeth, radius),
            test="test_plane_stiffness.py::test_tooth_compliance_seen_on_the_centre_line",
            cheap=False,
        )
    for load, value in ((50, 15.090), (100, 15.547), (400, 16.550)):
        yield Check(
            subject=SUBJECT,
            quantity=f"c' of a single pair at the pitch point, z 20/55, m 2 mm, spur, {load} N/mm",
            source="independent plane strain contact FE of the real flanks",
            unit="N/(mm µm)",
            reference=(value,),
            gate=1e-2,
            compute=_single_pair(load * 1e3),
            test="test_plane_stiffness.py::test_single_pair_stiffness_against_a_contact_solution",
            cheap=False,
        )
    yield from helical_rows(
        SUBJECT,
        3e-2,
        _helical_state,
        "test_plane_stiffness.py::test_helical_approach_against_a_contact_solution_in_space",
    )


def helical_rows(subject: str, gate: float, state: Callable[[], tuple[float, float]], test: str) -> Iterator[Check]:
    """Rows of a helical pair against contact in space; ``state`` returns approach (um) and stiffness (N/um)."""
    for quantity, unit, value, index in (
        ("approach normal to the flank", "µm", 1.222, 0),
        ("secant stiffness k_s", "N/µm", 183.7, 1),
    ):
        yield Check(
            subject=subject,
            quantity=f"{quantity}, z 17/43, m_n 1 mm, β 20°, b 10 mm, 2 N m, c = 0.1325",
            source="independent 3-D contact FE",
            unit=unit,
            reference=(value,),
            gate=gate,
            compute=lambda i=index: [state()[i]],
            test=test,
            cheap=False,
        )
