"""Gear flank: the contact of the driving and the driven gear on one side of the teeth, by a mesh law.

Rows are delta (approach along the transverse line of action) and psi (tilt in the plane of action), see
`mbd.parts.gear_mesh`; the rotation of the driving gear is observed, because it turns the mesh cycle. The law gives
U(c, delta, psi) with F = dU/d delta, M = dU/d psi. With damping the force is F_t = max(0, F + tau k_t d),
k_t = dF/d delta, d = delta' + (M/F) psi', and M_t = M F_t/F.

dU/dc jumps wherever a tooth enters a new cell of the law's tables, so that its parametric work is audited
(`mbd.elements.element`). The damping stiffness k_t jumps where a pair of teeth touches; it may be held
(`mbd.elements.newton`).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.kernel import evaluate
from fem.contact.teeth import least_clearance
from fem.numerics.inner_functions import UNCOUNTED, inner
from mbd.elements.element import ENERGY, FROZEN_ENERGY, Contact, Element, Signal, rule
from mbd.elements.mode_words import ModeWords
from mbd.parts.gear_mesh import MeshSpec, mesh_channels, mesh_rows
from mbd.parts.linear_reference import Assembly
from mbd.parts.mesh_reference import approach_at, mean_stiffness

BACKLASH, FLOOR, REACH, TAU, CYCLE_START, CYCLE_RATE, RATIO, PINION, WHEEL, LAW = range(10)
TERMS = 6  # columns of tooth terms
SIDES = ("drive", "coast")
WORDS = ModeWords("mesh", "meshes")


@inner(inline="always")
def touches(values, delta, psi):
    """False if the flank is clear of contact everywhere."""
    return delta - values[BACKLASH] + abs(psi) * values[REACH] > values[FLOOR]


@inner()
def _store(energy_at, force, stiffness, log, found):
    """Spread F, M, U, dF/d delta, dF/d psi, dM/d psi."""
    force[0], force[1], log[energy_at] = found[0], found[1], found[2]
    stiffness[0, 0], stiffness[0, 1] = found[3], found[4]
    stiffness[1, 0], stiffness[1, 1] = found[4], found[5]


@rule(__file__, **UNCOUNTED)
def flank_rule(values, motion, answer):
    """Force of one flank; ``values`` by the numbers above, then the law and the tooth terms of pinion and wheel."""
    delta, psi, before = motion.u[0], motion.u[1], motion.before
    asked = len(before) > 0
    if not touches(values, delta, psi) and not (asked and touches(values, before[0], before[1])):
        return
    turned = values[RATIO] * motion.angle + motion.seen[0]
    cycle = values[CYCLE_START] + values[CYCLE_RATE] * turned
    wheel = len(values) - TERMS * int(values[WHEEL])
    pinion = wheel - TERMS * int(values[PINION])
    law = values[LAW:pinion]
    pinion_terms = values[pinion:wheel].reshape((int(values[PINION]), TERMS))
    wheel_terms = values[wheel:].reshape((int(values[WHEEL]), TERMS))
    back = values[BACKLASH]
    found = evaluate(law, cycle, delta - back, psi, pinion_terms, wheel_terms)
    _store(ENERGY, answer.elastic, answer.stiffness, answer.log, found)
    if asked:
        found = evaluate(law, cycle, before[0] - back, before[1], pinion_terms, wheel_terms)
        _store(FROZEN_ENERGY, answer.frozen, answer.frozen_stiffness, answer.log, found)
    if answer.elastic[0] > 0.0:
        damp(values, motion, answer)


@inner()
def damp(values, motion, answer):
    """The damping part of the force, so that the sum never pulls."""
    force, moment, stiffness = answer.elastic[0], answer.elastic[1], answer.stiffness
    arm = moment / force
    held = stiffness[0, 0] if len(motion.held) == 0 else motion.held[0, 0]
    damper = values[TAU] * held
    loss = damper * (motion.v[0] + arm * motion.v[1])
    if force + loss > 0.0:
        share = loss / force
        answer.lost[0], answer.lost[1] = loss, arm * (force + loss) - moment
        answer.lost_by_u[1, 0] = share * (stiffness[1, 0] - arm * stiffness[0, 0])
        answer.lost_by_u[1, 1] = share * (stiffness[1, 1] - arm * stiffness[0, 1])
        answer.lost_by_v[0, 0], answer.lost_by_v[0, 1] = damper, damper * arm
        answer.lost_by_v[1, 0], answer.lost_by_v[1, 1] = damper * arm, damper * arm * arm
    else:
        answer.lost[0], answer.lost[1] = -force, -moment
        for i in range(2):
            for j in range(2):
                answer.lost_by_u[i, j] = -stiffness[i, j]


def flank_name(mesh: str, side: int) -> str:
    """Name of the element; side 0 drive, 1 coast."""
    return f"{mesh}:{SIDES[side]}"


def elements(assembly: Assembly) -> Iterator[Element]:
    """Drive and coast flank of every mesh; the linear reference is the mean stiffness of the drive flank."""
    lay, machine = assembly.layout, assembly.machine
    for mesh in machine.meshes:
        load = assembly.mesh_loads[mesh.name]
        evaluators = LawEvaluator(mesh.drive), LawEvaluator(mesh.coast)
        springs = mean_stiffness(evaluators[0], load)
        ends = mesh_rows(mesh, machine.shaft(mesh.driving), machine.shaft(mesh.driven))
        rows = np.array(
            [lay.node_row(mesh.driving, mesh.y, r[:6]) + lay.node_row(mesh.driven, mesh.y, r[6:]) for r in ends]
        )
        delta, psi, *forces = mesh_channels(mesh.name)
        width = float(mesh.drive.slice_width.sum())
        for side in (0, 1):
            motions = () if side else (Signal(delta, "m", motion=(1.0, 0.0)), Signal(psi, "rad", motion=(0.0, 1.0)))
            yield Element(
                kind="flank",
                name=flank_name(mesh.name, side),
                part=mesh.name,
                words=WORDS,
                rule=flank_rule,
                values=_values(evaluators[side], mesh, side, lay.ratios[mesh.driving]),
                rows=rows[2 * side : 2 * side + 2],
                row_names=("delta", "psi"),
                scale=(load, load * width),
                stiffness=(0.0, 0.0) if side else springs,
                damping=(0.0, 0.0) if side else (mesh.damping_time * springs[0], 0.0),
                seen=lay.angle_row(mesh.driving, mesh.y)[None],
                opens=True,
                audited=True,
                contact=Contact(
                    name=mesh.name,
                    side=side,
                    nominal=assembly.contact_loads[mesh.name],
                    touching=partial(_touching, evaluators[side], mesh, side),
                ),
                signals=(*motions, Signal(forces[side], "N", force=(1.0, 0.0))),
                contact_lost="" if side else f"{mesh.name}:contact_losses",
                contact_made=f"{mesh.name}:coast_contacts" if side else "",
            )


def _values(evaluator: LawEvaluator, mesh: MeshSpec, side: int, ratio: float) -> np.ndarray:
    """Numbers of the rule, the law's among them."""
    law, (pinion, wheel) = evaluator.law, mesh.terms[side]
    numbers = np.zeros(LAW)
    numbers[BACKLASH] = mesh.backlash if side else 0.0
    numbers[FLOOR] = least_clearance(law, pinion, wheel)
    numbers[REACH] = abs(law.face_coordinate).max()
    numbers[TAU] = mesh.damping_time
    numbers[CYCLE_START], numbers[CYCLE_RATE] = mesh.cycle_at_start, mesh.cycles_per_radian
    numbers[RATIO], numbers[PINION], numbers[WHEEL] = ratio, len(pinion), len(wheel)
    return np.concatenate([numbers, evaluator.packed, pinion.ravel(), wheel.ravel()])


def _touching(evaluator: LawEvaluator, mesh: MeshSpec, side: int, seen: np.ndarray, rows: np.ndarray) -> float:
    """delta (m) at which a flank just touches, at the rotation (rad) of the driving gear since t = 0 and the tilt."""
    cycle = mesh.cycle_at_start + mesh.cycles_per_radian * float(seen[0])
    touching = approach_at(evaluator, cycle, 0.0, *mesh.terms[side], psi=float(rows[1]))
    return touching + (mesh.backlash if side else 0.0)
