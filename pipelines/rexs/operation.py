"""Operation of a unit: where power enters and leaves, the load case, and the order of shafts and stages between.

External loads that transmit torque are the input and output. Power T omega > 0 enters; without a torque the shaft
that defines the speed is the input.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipelines.rexs.document import Document, RexsComponent, RexsError
from pipelines.rexs.gear_unit import LoadCase, Note

Gears = tuple[RexsComponent, RexsComponent]


class Operation:
    """The most frequent load case of a document, with the shafts and stages in the order of its power flow.

    Parameters
    ----------
    document : the file
    carried : the shaft of each gear, by numbers of the file
    senses : +1 if the axis of a shaft points along y, -1 against it, by number

    Attributes
    ----------
    document : with the attributes of the load case
    shafts, stages : in the order of the power flow, stages with their gears, the driving one first
    output, output_load : the shaft where power leaves, and the external load on it, if there is one
    sense : +1 if the input turns about +y in the file
    load_case, other_cases : speed of the input and torque into it
    notes : assumptions made

    Raises
    ------
    RexsError : power splits, shafts that no stage reaches, units that change gear
    """

    def __init__(self, document: Document, carried: Mapping[int, int], senses: Mapping[int, int]) -> None:
        for unit in document.of_kind("gear_unit"):
            if (unit.optional("number_of_gears") or 1) > 1:
                raise unit.error(
                    "has several gears to change between. Write the file in one gear, with number_of_gears 1."
                )
        self._carried, self._senses = carried, senses
        self._shafts = {shaft.number_in_file: shaft for shaft in document.of_kind("shaft")}
        self._stages = [(stage, _gears(document, stage)) for stage in document.of_kind("cylindrical_stage")]
        if not self._stages:
            raise RexsError(f"{document.source}: has no cylindrical_stage. Give a file of a gear unit.")
        cases = {number: document.in_load_case(number) for number in document.load_cases} or {0: document}
        chosen = max(cases, key=lambda number: (_share(cases[number]), -number))
        self.document, self.notes = cases[chosen], list[Note]()
        source, self.output = self._ends(self.document)
        self.sense = -1 if (self._speed(self.document, source) or 1.0) < 0 else 1
        described = {number: self._case(number, case, source) for number, case in cases.items()}
        self.shafts, self.stages = self._order(source)
        self.load_case = described.pop(chosen)
        self.other_cases = tuple(described.values())
        self.output_load = next(iter(self._loads(self.document, self.output)), None)
        if described:
            reason = f"the most frequent of {len(cases)} load cases; the others are comments at [drive]"
            self.notes.append(Note("assumed", "load case", self.load_case.name, reason))

    def _pair(self, gears: Gears) -> tuple[int, int]:
        one, other = (self._carried[gear.number_in_file] for gear in gears)
        return one, other

    def _order(self, source: RexsComponent) -> tuple[list[RexsComponent], list[tuple[RexsComponent, Gears]]]:
        """Shafts and stages outwards from a shaft, the driving gear of each stage first."""
        reached, stages, waiting = [source.number_in_file], [], list(self._stages)
        while ready := next((one for one in waiting if set(self._pair(one[1])) & set(reached)), None):
            waiting.remove(ready)
            stage, gears = ready
            driving, driven = self._pair(gears)
            if driving not in reached or (driven in reached and reached.index(driven) < reached.index(driving)):
                gears, driven = gears[::-1], driving
            stages.append((stage, gears))
            reached += [driven] if driven not in reached else []
        for number, shaft in self._shafts.items():
            if number not in reached:
                raise shaft.error(f"no stage connects it to {source.label}. Leave it out or give the stage.")
        return [self._shafts[number] for number in reached], stages

    def _ratios(self, source: RexsComponent) -> dict[int, float]:
        """Signed speed of every shaft divided by that of a shaft, about one direction."""
        found = {source.number_in_file: 1.0}
        for _, (pinion, wheel) in self._order(source)[1]:
            driving, driven = self._pair((pinion, wheel))
            turn = -pinion.number("number_of_teeth") / wheel.number("number_of_teeth")
            found.setdefault(driven, found[driving] * turn)
        return found

    def _ends(self, document: Document) -> tuple[RexsComponent, RexsComponent]:
        """The two shafts with external torques as input and output, with a note if no torque determines which."""
        touched = [number for _, gears in self._stages for number in self._pair(gears)]
        ends = [shaft for shaft in self._shafts.values() if self._loads(document, shaft)]
        free = [shaft for number, shaft in self._shafts.items() if touched.count(number) == 1 and shaft not in ends]
        if len(ends) < 2 and len(ends) + len(free) == 2:
            ends += free
        if len(ends) != 2:
            raise RexsError(
                f"{document.source}: {len(ends)} shafts have an external_load that transmits torque; a scene has one "
                "input and one output. Give transmits_torque = true at these two alone."
            )
        for one, other in (ends, ends[::-1]):
            if torque := self._torque(document, one):
                drives = torque * (self._speed(document, one) or 1.0) > 0
                return (one, other) if drives else (other, one)
        named = [end for end in ends if document.components[end.number_in_file].text("defines_speed") == "true"]
        source, sink = ends[::-1] if named[:1] == ends[1:] else ends
        reason = "no torque determines where power enters; taken because " + (
            "this shaft defines the speed" if named else "it is the first in the file"
        )
        self.notes.append(Note("assumed", "input", source.label, reason))
        return source, sink

    def _case(self, number: int, document: Document, source: RexsComponent) -> LoadCase:
        """Speed of the input and torque into it, positive as in the chosen case."""
        speed, torque, share = self._speed(document, source), self._torque(document, source), _share(document)
        if torque is None and (leaving := self._torque(document, self.output)) is not None:
            torque = -leaving * self._ratios(source)[self.output.number_in_file]
        return LoadCase(
            name=f"{number}" + (f" ({share:g} % of the time)" if share else ""),
            speed=None if not speed else self.sense * speed,
            torque=None if torque is None else self.sense * torque,
        )

    def _speed(self, document: Document, shaft: RexsComponent) -> float | None:
        """Speed of a shaft about y (1/min), from the shaft whose speed is in the file; None without one."""
        given = {
            number: one.optional("rotational_speed", "1 / min")
            for number, one in document.components.items()
            if number in self._shafts
        }
        known = [number for number, speed in given.items() if speed]
        known.sort(key=lambda number: document.components[number].text("defines_speed") != "true")
        if not known:
            return None
        speed = (given[known[0]] or 0.0) * self._senses[known[0]]
        return speed * self._ratios(self._shafts[known[0]])[shaft.number_in_file]

    def _loads(self, document: Document, shaft: RexsComponent) -> list[RexsComponent]:
        """The external loads of a shaft that transmit torque."""
        loads = document.parts(shaft, "external_load")
        return [load for load in loads if load.text("transmits_torque") != "false"]

    def _torque(self, document: Document, shaft: RexsComponent) -> float | None:
        """Sum of the external torques on a shaft about y (N m); None if the file gives none."""
        torques = [load.optional("torque_around_u_axis", "N m") for load in self._loads(document, shaft)]
        given = [torque for torque in torques if torque is not None]
        return self._senses[shaft.number_in_file] * sum(given) if given else None


def _gears(document: Document, stage: RexsComponent) -> Gears:
    for relation in document.relations:
        if relation.kind == "stage" and relation.roles.get("stage") == stage.number_in_file:
            gears = document.role(relation, "gear_1"), document.role(relation, "gear_2")
            for gear in gears:
                if gear.kind != "cylindrical_gear":
                    raise gear.error("is a gear of a cylindrical stage. Only external cylindrical gears are read.")
            return gears
    raise stage.error("names no gears. Add the relation stage with gear_1 and gear_2.")


def _share(document: Document) -> float:
    """Share of the time of a load case (%)."""
    keys: Sequence[str] = ("load_duration_fraction", "operating_time_fraction")  # to version 1.2, from 1.3
    found = [unit.optional(key, "%") for unit in document.of_kind("gear_unit") for key in keys]
    return max((share for share in found if share is not None), default=0.0)
