"""Quasi-static results of a mesh law: approach at a load, no-load error, mean stiffness."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from fem.contact.evaluation.evaluator import LawEvaluator, Teeth
from fem.contact.law import MeshLaw
from fem.contact.teeth import LawError
from mbd.elements.element import LARGEST_APPROACH
from mbd.parts.gear_mesh import MeshSpec
from mbd.parts.machine import Machine
from mbd.parts.part_checks import EquilibriumError
from mbd.parts.train import power_flow

MIN_LINE_LOAD = 1e3  # N/m: lower limit of the load for the reference stiffness
POSITIONS = 16  # positions in the mesh cycle for averages
SHARE_POSITIONS = 64  # positions in the mesh cycle for the sliding shares


def approach_at(
    evaluator: LawEvaluator, cycle: float, force: float, pinion: Teeth = None, wheel: Teeth = None, psi: float = 0.0
) -> float:
    """Approach delta (m) at which a law carries a force; for 0 N the approach at which the first pair touches.

    Parameters
    ----------
    evaluator : of the law of one flank
    cycle : mesh cycle
    force : N
    pinion, wheel : (tooth,) clearances, m, or (tooth, 6) tooth terms, see `fem.contact.teeth`; None: no deviations
    psi : tilt in the plane of action, rad

    Raises
    ------
    EquilibriumError : no approach up to 10 mm carries the force (no tooth pair near mesh)
    """
    law, reason = evaluator.law, f"no approach up to {LARGEST_APPROACH * 1e3:g} mm carries {force:.4g} N"
    try:
        if force > 0.0:
            found = float(evaluator.approach_at(force, cycle, psi, pinion, wheel)[0])
        else:
            found = float(evaluator.no_load(cycle, psi, pinion, wheel)[0])
        if abs(found) <= LARGEST_APPROACH:
            return found
        cause = None
    except LawError as error:
        reason, cause = f"{reason} ({error})", error
    raise EquilibriumError(
        f"{law.model} law, {law.flank} flank, cycle {cycle:.3f}: {reason}. Too many teeth are missing (set another "
        "stages.cycle_at_start), or the load is beyond the law (reduce it)."
    ) from cause


def mean_stiffness(evaluator: LawEvaluator, force: float) -> tuple[float, float]:
    """Mean over one cycle of dF/d delta (N/m) and dM/d psi (N m/rad) at ``force`` without deviations or tilt."""
    cycles = (np.arange(POSITIONS) + 0.5) / POSITIONS
    delta = np.array([approach_at(evaluator, cycle, force) for cycle in cycles])
    response = evaluator.evaluate(cycles, delta)
    return float(response.stiffness.mean()), float(response.tilt_stiffness.mean())


def nominal_forces(
    machine: Machine, torques: Mapping[str, float] | None = None, inertias: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Mesh force F = T1/r_b1 (N) by mesh name under external torques, without losses; 0 without power flow.

    Parallel paths share the power as in `mbd.parts.train.power_flow`. A free train accelerates by the unbalanced
    torque, of which every shaft takes a share in proportion to its inertia.

    Parameters
    ----------
    machine : the machine
    torques : N m by name of the shaft, positive in its positive sense; None: the largest
    inertias : moment of inertia (kg m2) by name of the shaft, for a free train
    """
    ratios = machine.ratios()
    acting = machine.largest_torques() if torques is None else torques
    at = {shaft.name: i for i, shaft in enumerate(machine.shafts)}
    flows = [(at[link.first], at[link.second]) for link in machine.links]  # meshes first
    drawn = np.zeros(len(at))  # power per speed of the first drive
    for name, torque in acting.items():
        drawn[at[name]] -= ratios[name] * torque
    if machine.free:
        taken = np.array([(inertias or {}).get(name, 1.0) * ratios[name] ** 2 for name in at])
        drawn -= drawn.sum() * taken / taken.sum()
    share = power_flow(flows, [at[c.shaft] for c in machine.couplings], drawn)
    return {
        m.name: float(part / ratios[m.driving] / m.base_radius_driving)
        for m, part in zip(machine.meshes, share, strict=False)
    }


def reference_load(mesh: MeshSpec, nominal: float) -> float:
    """Load (N) for the linear reference of a mesh."""
    return max(abs(nominal), MIN_LINE_LOAD * float(mesh.drive.slice_width.sum()))


def sliding_shares(law: MeshLaw, force: float) -> np.ndarray:
    """Tables (2, SHARE_POSITIONS) of the sums of share x sign(xi) and of share x |xi| (m) over all pairs and slices.

    xi is the distance from the pitch point along the path, over one mesh cycle at ``force`` (N), without deviations or
    tilt. Each slice is evaluated alone at the approach of the whole face, without coupling between slices.
    """
    evaluator = LawEvaluator(law)
    lone = [LawEvaluator(_one_slice(law, s)) for s in range(len(law.slice_width))]
    tables = np.zeros((2, SHARE_POSITIONS))
    for i in range(SHARE_POSITIONS):
        cycle = i / SHARE_POSITIONS
        delta, total = approach_at(evaluator, cycle, force), 0.0
        for part, shift in zip(lone, law.cycle_shift, strict=True):
            number, load = part.shares(cycle, delta)
            xi = law.cycle_sign * cycle + law.cycle_offset + shift - number
            tables[0, i] += float(load @ np.sign(xi))
            tables[1, i] += float(load @ abs(xi)) * law.base_pitch
            total += float(load.sum())
        tables[:, i] /= total
    return tables


def _one_slice(law: MeshLaw, s: int) -> MeshLaw:
    """Law of slice ``s`` alone."""
    changes: dict[str, Any] = {
        field.name: np.take(getattr(law, field.name), [s], axis=field.metadata["dims"].index("slice"))
        for field in fields(law)
        if "slice" in field.metadata.get("dims", ())
    }
    return replace(law, **changes)
