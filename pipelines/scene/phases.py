"""Phases of meshes that share a gear: an idler, a gear with several mates, a closed loop.

With the sense s about +y in which its shaft rotates, the middle of tooth 0 of a gear is, in teeth, at

    T_1 = z_1 a_1 / (2 pi) + c - tau_1 / 2,    a_1 = -s_1 D            as the pinion of a stage,
    T_2 = z_2 a_2 / (2 pi) + c + tau_2 / 2,    a_2 = -s_2 (D + pi)     as its wheel,

where c is the mesh cycle, D the direction from pinion axis to wheel axis, and tau = s_w / p_wt the tooth thickness on
the operating pitch circle divided by the pitch. At c = 0 the leading flank of tooth 0 of the pinion touches the
trailing flank of tooth 0 of the wheel at the pitch point. A gear has one T, so the cycle of one of its stages
determines those of the others. Around a closed loop of shared gears they must agree, which is the condition of assembly
of planet gears. A gear with only one mate may be mounted at any angle on its shaft: its phase is free.

References
----------
Parker & Lin (2004), Mesh phasing relationships in planetary and epicyclic gears, J. Mech. Design 126, 365-370.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from fem.gears.geometry import GearPair
from pipelines.io.errors import Problem
from pipelines.scene.shaft_places import stage_shafts
from pipelines.scene.tables.stages import StageTable

LOOP = 0.01  # mesh cycles, tolerance of a closed loop, since directions are given with few digits
GIVEN = 1e-3  # mesh cycles, tolerance of a given phase
Gear = tuple[int, int, float, float]  # shaft, teeth, position and tip radius


def mesh_cycles(
    stages: Sequence[StageTable], pairs: Sequence[GearPair], senses: Sequence[int]
) -> tuple[list[float], list[Problem]]:
    """Mesh cycle of every stage at t = 0, in [0, 1), and contradictions between given values.

    Parameters
    ----------
    stages, pairs : tables of the stages, and the gear pair of each
    senses : of the shafts, +1 or -1 about +y
    """
    offsets = [dict(_teeth(*item, senses)) for item in zip(stages, pairs, stage_shafts(stages), strict=True)]
    cycles: list[float] = [0.0] * len(stages)
    problems: list[Problem] = []
    done: set[int] = set()
    for first in range(len(stages)):
        if first in done:
            continue
        found, loops = _linked_cycles(first, offsets)
        problems += loops
        given = [number for number in sorted(found) if stages[number].cycle_at_start is not None]
        anchor = given[0] if given else first
        start = (stages[anchor].cycle_at_start or 0.0) - found[anchor]
        for number, cycle in found.items():
            cycles[number] = _whole(cycle + start) % 1.0 if number != anchor else (stages[anchor].cycle_at_start or 0.0)
        problems += [] if loops else _contradictions(stages, given, cycles, anchor)
        done |= found.keys()
    return cycles, problems


def _teeth(
    stage: StageTable, pair: GearPair, shafts: tuple[int, int], senses: Sequence[int]
) -> Iterator[tuple[Gear, float]]:
    """T - c of both gears of a stage."""
    direction, pitch = stage.si.direction, 2 * math.pi
    thicknesses = (thickness / pair.working_pitch for thickness in pair.working_thicknesses)
    sides = ((pair.pinion, direction, -1), (pair.wheel, direction + math.pi, 1))
    for (gear, towards, side), shaft, thickness in zip(sides, shafts, thicknesses, strict=True):
        place = -senses[shaft] * towards
        key = (shaft, gear.teeth, round(stage.position_mm, 6), round(gear.tip_radius, 9))
        yield key, gear.teeth * place / pitch + side * thickness / 2


def _linked_cycles(first: int, offsets: Sequence[dict[Gear, float]]) -> tuple[dict[int, float], list[Problem]]:
    """Cycles, relative to that of the first, of the stages linked to it by shared gears; loops that do not agree."""
    found, waiting, problems = {first: 0.0}, [first], []
    while waiting:
        known = waiting.pop(0)
        for number, other in enumerate(offsets):
            for gear in sorted(other.keys() & offsets[known].keys()) if number != known else ():
                cycle = found[known] + offsets[known][gear] - other[gear]
                if number not in found:
                    found[number] = cycle
                    waiting.append(number)
                elif number > known and abs(miss := _difference(cycle, found[number])) > LOOP:
                    problems.append(
                        Problem(
                            f"stages.{number + 1}",
                            f"closes a loop of gears that cannot be assembled: on shaft {gear[0] + 1} the teeth are "
                            f"displaced by {abs(miss):.3f} of a pitch (limit {LOOP:g})",
                            "Correct the numbers of teeth or direction_deg, or move one of the gears along its shaft "
                            "(position_mm)",
                        )
                    )
    return found, problems


def _contradictions(
    stages: Sequence[StageTable], given: Sequence[int], cycles: Sequence[float], anchor: int
) -> Iterator[Problem]:
    for number in given:
        requested = stages[number].cycle_at_start
        if requested is not None and abs(_difference(requested, cycles[number])) > GIVEN:
            yield Problem(
                f"stages.{number + 1}.cycle_at_start",
                f"must be {cycles[number]:.4f}, because a gear of this stage also meshes in stage {anchor + 1}, whose "
                "cycle_at_start determines it",
                "Delete one of the two",
                f"{requested:g}",
            )


def _difference(one: float, other: float) -> float:
    """Difference of two cycles from the nearest whole number, in [-0.5, 0.5]."""
    return (one - other) - round(one - other)


def _whole(cycle: float) -> float:
    """The cycle, rounded if it is a whole number except for round-off."""
    return float(round(cycle)) if abs(_difference(cycle, 0.0)) < 1e-12 else cycle
