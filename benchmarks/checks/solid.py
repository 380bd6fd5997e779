"""Mesh stiffness, model solid: contact solutions in space and in the plane."""

from __future__ import annotations

import json
import math
from functools import cache

import numpy as np

from benchmarks import added_by_cracks, gear_bodies
from benchmarks.checks.plane import PLANE_CONTACT, helical_checks
from benchmarks.checks.record import Check, Subject
from benchmarks.cracked_teeth import CASES
from benchmarks.gear_pairs import pair_of_17_and_43, thick_rimmed_pair
from benchmarks.peers.calculix_contact import POSITIONS_PER_CYCLE, RESULTS
from benchmarks.rig import read
from benchmarks.solid_contact import solve
from fem.contact.models.solid import Solid
from fem.contact.wheels.compliance import ContactCompliance


@cache
def helical() -> tuple[float, float]:
    """Approach normal to the flank (um) and secant stiffness (N/um) of z 17/43 at c = 0.1325 under 2 N m."""
    pair = pair_of_17_and_43()
    force = 2.0 / pair.pinion.base_radius
    state = solve(Solid().compliance(pair), np.arange(32), force=force)
    delta = float(np.interp(0.1325, state.cycle, state.approach))
    return 1e6 * delta * math.cos(pair.base_helix_angle), 1e-6 * force / delta


@cache
def _spur() -> ContactCompliance:
    return Solid(positions=8).compliance(thick_rimmed_pair(face_mm=30))


def single_pair(line_load: float) -> float:
    """c' (N/(mm um)) of the one pair that touches at the pitch point of the spur pair z 20/55, m 2 mm, b 30 mm."""
    state = solve(_spur(), np.array([0]), force=line_load * 30e-3)
    return line_load / float(state.approach[0]) / 1e9


def calculix_positions() -> list[tuple[float, bool, float]]:
    """Mesh cycle, whether wheel tooth 0 is missing, and the extrapolated approach (m) of each stored position."""
    places = json.loads(RESULTS.read_text(encoding="utf-8"))["positions"]
    return [(place["cycle"], place["missing"], place["extrapolated_m"]) for place in places]


@cache
def _stage_1() -> tuple[float, ContactCompliance]:
    machine = read()
    force = machine.facts.stages[0].mesh_force
    return force, Solid(positions=POSITIONS_PER_CYCLE).compliance(machine.layout.pairs[0])


def rig_approach(cycle: float, missing: bool) -> float:
    """Approach (m) of stage 1 of the rig under its nominal load."""
    force, record = _stage_1()
    index = np.array([round(cycle * POSITIONS_PER_CYCLE)])
    return float(solve(record, index, force=force, clearance={0: math.inf} if missing else None).approach[0])


def _calculix_check(cycle: float, missing: bool, approach: float) -> Check:
    return Check(
        f"approach δ, stage 1 of the rig, nominal load, c = {cycle:g}{', wheel tooth 0 missing' if missing else ''}",
        "CalculiX, extrapolated (`python -m benchmarks.peers.calculix_contact`)",
        "µm",
        (1e6 * approach,),
        2e-2,
        lambda: [1e6 * rig_approach(cycle, missing)],
        "test_solid_stiffness.py::test_whole_wheels_against_calculix",
    )


def _body_check(body: gear_bodies.Body) -> Check:
    return Check(
        f"deflection from the bore at six places of a flank, z 24, m_n 2 mm, b 12 mm, {body.name}",
        "ten-node tetrahedra of the whole gear (`python -m benchmarks.gear_bodies`)",
        "nm/N",
        tuple((1e9 * np.diag(gear_bodies.reference(body))).tolist()),
        3e-2,
        lambda: (1e9 * np.diag(gear_bodies.by_sector(body))).tolist(),
        "test_wheel_webs.py::test_deflection_at_six_places_against_tetrahedra",
    )


def _crack_check(name: str) -> Check:
    place, helix = name.removesuffix(" deg").split(", ")
    where = {"corner": "at a corner", "whole face": "over the whole face"}.get(place, f"over {place}")
    return Check(
        f"deflection added by a crack {where}, under a uniform load and three loads on a cracked half of the face, "
        f"z 20, m_n 2 mm, b 12 mm, β {helix}°",
        "ten-node tetrahedra, extrapolated (`python -m benchmarks.cracked_teeth`)",
        "nm/N",
        tuple(added_by_cracks.seen(added_by_cracks.reference(name))),
        5e-2,
        lambda: added_by_cracks.seen(added_by_cracks.by_surface(name)),
        "test_crack_surface.py::test_added_deflection_is_that_of_tetrahedra",
    )


SUBJECT = Subject(
    "Mesh stiffness, model solid",
    (
        *helical_checks(
            2e-2,
            helical,
            "test_solid_stiffness.py::test_approach_of_a_helical_pair_against_a_contact_solution_in_space",
        ),
        Check(
            "c' of a single pair at the pitch point, z 20/55, m 2 mm, spur, free end faces, 50, 100, 400 N/mm",
            PLANE_CONTACT,
            "N/(mm µm)",
            (15.090, 15.547, 16.550),
            2e-2,
            lambda: [single_pair(load) for load in (50e3, 100e3, 400e3)],
            "test_solid_stiffness.py::test_spur_pair_at_the_pitch_point_against_contact_in_the_plane",
        ),
        *(_calculix_check(*position) for position in calculix_positions()),
        *(_body_check(body) for body in gear_bodies.BODIES),
        *(_crack_check(name) for name in CASES),
    ),
    cheap=False,
)
