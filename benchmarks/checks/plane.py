"""Model plane: tooth compliances, a contact solution in the section, and one in space."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from scipy import sparse

from benchmarks.checks.record import Check, Subject, Values
from benchmarks.gear_pairs import gear, pair_of_17_and_43, thick_rimmed_pair
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.law import MeshLaw
from fem.contact.models.plane import Plane
from fem.contact.wheels import ring
from fem.elements.sections import shape_functions
from fem.gears.sector_mesh import SectorMesh, sector_mesh

PLANE_CONTACT = "independent plane strain contact FE of the real flanks"
YOUNG, POISSON = 206e9, 0.3


def approach(law: MeshLaw, line_load: float, xi: float = 0.0) -> float:
    """Approach (m) of a single pair at the local position xi under a line load (N/m)."""
    at = law.position_start + law.position_step * np.arange(law.compliance.size)
    c, b = np.interp(xi, at, law.compliance), np.interp(xi, at, law.contact_offset)
    return float(c * line_load + law.contact_slope * line_load * (b - math.log(line_load)))


@cache
def _spur_law() -> MeshLaw:
    return Plane(slices=1).law(thick_rimmed_pair(face_mm=30), "drive")


def _single_pair(line_load: float) -> Values:
    """c' = f / x (N/(mm um)) at the pitch point."""
    return [line_load / approach(_spur_law(), line_load) / 1e9]


@cache
def helical_state() -> tuple[float, float]:
    """Approach normal to the flank (um) and secant stiffness (N/um) of z 17/43 at c = 0.1325 under 2 N m."""
    pair = pair_of_17_and_43()
    force = 2.0 / pair.pinion.base_radius
    curve = stiffness_curve(Plane(slices=31).law(pair, "drive"), force, np.array([0.1325]))
    return float(curve.transmission_error[0]) * math.cos(pair.base_helix_angle) * 1e6, float(curve.secant[0]) / 1e6


def tooth_compliance(teeth: int, radius_mm: float) -> float:
    """Displacement (um per N/mm) where the load line crosses the tooth centre line; module 1 mm.

    The load is a line load, here on a narrow patch.
    """
    wheel, radius = gear(teeth, 1), radius_mm / 1000
    mesh = sector_mesh(wheel, refinement=2.0)
    arc = (radius**2 - wheel.base_radius**2) / (2 * wheel.base_radius)
    flank = ring.FlankCompliance(arc=mesh.flank_arc, tip_arc=mesh.tip_arc, matrix={})
    load = ring.flank_loads(mesh) @ flank.patches(np.array([arc]), 0.04e-3)[0].T
    slope = wheel.pressure_angle_at(radius) - wheel.half_thickness_angle(radius)
    seen = _point_load(
        mesh, np.array([wheel.base_radius / math.cos(slope), 0.0]), -np.array([math.sin(slope), math.cos(slope)])
    )
    both = sparse.csc_matrix(np.column_stack([load.ravel(), seen]))
    response = ring.ring_response(ring.reduce_sector(mesh, YOUNG, POISSON, both))
    return float(response[0][1, 0]) * 1e9


def _point_load(mesh: SectorMesh, place: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Load vector of a unit force at a point inside the mesh."""
    nearest = np.argsort(np.linalg.norm(mesh.points[mesh.elements[:, 4]] - place, axis=1))[:20]
    for element in mesh.elements[nearest]:
        corners, local = mesh.points[element], np.full(2, 0.5)
        for _ in range(20):
            values, slopes = shape_functions(np.clip(local, -0.5, 1.5)[None])
            local = np.clip(local, -0.5, 1.5) - np.linalg.solve(corners.T @ slopes[0], values[0] @ corners - place)
        if np.abs(local - 0.5).max() <= 0.5 + 1e-9:
            out = np.zeros((len(mesh.points), 2))
            out[element] = shape_functions(local[None])[0][0][:, None] * direction
            return out.ravel()
    raise RuntimeError(f"{place} m is not in the sector mesh")


def helical_checks(gate: float, state: Callable[[], tuple[float, float]], test: str) -> tuple[Check, Check]:
    """Rows of a helical pair against contact in space; `state` returns approach (um) and stiffness (N/um)."""
    place, source = "z 17/43, m_n 1 mm, β 20°, b 10 mm, 2 N m, c = 0.1325", "independent 3-D contact FE"
    return (
        Check(f"approach normal to the flank, {place}", source, "µm", (1.222,), gate, lambda: state()[:1], test),
        Check(f"secant stiffness k_s, {place}", source, "N/µm", (183.7,), gate, lambda: state()[1:], test),
    )


def _tooth_check(teeth: int, radius_mm: float, reference: float) -> Check:
    return Check(
        f"compliance of a tooth on its centre line, z {teeth}, m 1 mm, load at r = {radius_mm} mm",
        "two independent plane strain FE solutions",
        "µm/(N/mm)",
        (reference,),
        5e-3,
        lambda: [tooth_compliance(teeth, radius_mm)],
        "test_plane_stiffness.py::test_tooth_compliance_seen_on_the_centre_line",
    )


def _single_pair_check(load: int, reference: float) -> Check:
    return Check(
        f"c' of a single pair at the pitch point, z 20/55, m 2 mm, spur, {load} N/mm",
        PLANE_CONTACT,
        "N/(mm µm)",
        (reference,),
        1e-2,
        lambda: _single_pair(load * 1e3),
        "test_plane_stiffness.py::test_single_pair_stiffness_against_a_contact_solution",
    )


SUBJECT = Subject(
    "Mesh stiffness, model plane",
    (
        _tooth_check(17, 8.0023, 0.01626),
        _tooth_check(17, 8.5, 0.02226),
        _tooth_check(43, 21.5, 0.02085),
        _tooth_check(43, 22.4434, 0.05411),
        _single_pair_check(50, 15.090),
        _single_pair_check(100, 15.547),
        _single_pair_check(400, 16.550),
        *helical_checks(
            3e-2,
            helical_state,
            "test_plane_stiffness.py::test_helical_approach_against_a_contact_solution_in_space",
        ),
    ),
    cheap=False,
)
