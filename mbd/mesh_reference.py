"""Quasi-static readings of a mesh law: approach at a load, no-load error, mean stiffness."""

from __future__ import annotations

import numpy as np

from fem.contact.evaluate import checked_teeth, evaluate, law_tables
from fem.contact.law import MeshLaw
from mbd.checks import EquilibriumError
from mbd.gear_mesh import MeshSpec
from mbd.load import StaticTorque
from mbd.machine import Machine

MIN_LINE_LOAD = 1e3  # N/m: reference stiffness is taken at this load at least
POSITIONS = 16  # cycle positions averaged
LARGEST_APPROACH = 1e-2  # m


def approach_at(
    law: MeshLaw, cycle: float, force: float, pinion: np.ndarray, wheel: np.ndarray, psi: float = 0.0
) -> float:
    """delta (m) at which the law carries ``force`` (N, > 0) at ``cycle`` and ``psi``; by bisection, F rises with delta.

    Raises
    ------
    EquilibriumError : no approach up to 10 mm carries the force (no tooth pair near mesh)
    """
    tables = law_tables(law)
    low, high = -1e-6, 1e-6
    while evaluate(tables, cycle, low, psi, pinion, wheel)[0] > force:
        low *= 4
        if low < -LARGEST_APPROACH:
            raise EquilibriumError(f"{law.model} law: carries more than {force:.3g} N at every approach above {low} m.")
    while evaluate(tables, cycle, high, psi, pinion, wheel)[0] < force:
        high *= 4
        if high > LARGEST_APPROACH:
            raise EquilibriumError(
                f"{law.model} law, {law.flank} flank, cycle {cycle:.3f}: no approach up to {LARGEST_APPROACH * 1e3:g} "
                f"mm carries {force:.4g} N. Too many teeth are missing (choose another mesh phase at the start), or "
                "the load is beyond the law."
            )
    for _ in range(200):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if evaluate(tables, cycle, middle, psi, pinion, wheel)[0] < force:
            low = middle
        else:
            high = middle
    return high


def touching_approach(law: MeshLaw, cycle: float, pinion: np.ndarray, wheel: np.ndarray, psi: float) -> float:
    """delta_0 (m): the largest approach without force, the no-load error at tilt ``psi``."""
    return approach_at(law, cycle, 1e-9, pinion, wheel, psi)


def mean_stiffness(law: MeshLaw, force: float) -> tuple[float, float]:
    """Mean over one cycle of dF/d delta (N/m) and dM/d psi (N m/rad) at ``force`` without deviations or tilt."""
    pinion, wheel = checked_teeth(law, None, None)
    tables = law_tables(law)
    total = np.zeros(2)
    for cycle in (np.arange(POSITIONS) + 0.5) / POSITIONS:
        delta = approach_at(law, cycle, force, pinion, wheel)
        _, _, _, f_d, _, m_p, _ = evaluate(tables, cycle, delta, 0.0, pinion, wheel)
        total += f_d, m_p
    return float(total[0] / POSITIONS), float(total[1] / POSITIONS)


def nominal_forces(machine: Machine) -> dict[str, float]:
    """Mesh force F = T1/r_b1 (N) by mesh name under the hanging load; 0 for a mesh outside the path of the load."""
    ratios, load = machine.ratios(), machine.load
    if isinstance(load, StaticTorque):
        torque = load.torque * len(load.drums)
    else:
        torque = load.container_mass * machine.gravity * load.travel_per_radian
    towards_motor = {m.driven: m for m in machine.meshes}
    forces = {m.name: 0.0 for m in machine.meshes}
    shaft = load.shaft
    while shaft in towards_motor:
        mesh = towards_motor[shaft]
        shaft = mesh.driving
        forces[mesh.name] = torque * ratios[load.shaft] / ratios[shaft] / mesh.base_radius_driving
    return forces


def reference_load(mesh: MeshSpec, nominal: float) -> float:
    """Load (N) at which the linear reference of a mesh is taken."""
    return max(abs(nominal), MIN_LINE_LOAD * float(mesh.drive.slice_width.sum()))
