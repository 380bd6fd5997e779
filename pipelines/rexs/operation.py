"""Operation of a unit: where power enters and leaves, the load case, and the order of shafts and stages between.

External loads that transmit torque are the input and output. Power T omega > 0 enters; without a torque the shaft
that defines the speed is the input.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pipelines.rexs.document import Document, RexsComponent, RexsError
from pipelines.rexs.gear_unit import LoadCase, Note

Gears = tuple[RexsComponent, RexsComponent]


@dataclass(frozen=True, kw_only=True)
class Operation:
    """A load case with the order of the power flow; `sense` is +1 if the input turns about +y in the file."""

    document: Document  # with the attributes of the load case
    shafts: list[RexsComponent]
    stages: list[tuple[RexsComponent, Gears]]  # driving gear first
    output: RexsComponent
    output_load: RexsComponent | None
    sense: int
    load_case: LoadCase
    other_cases: tuple[LoadCase, ...]
    notes: tuple[Note, ...]


def read_operation(document: Document, carried: Mapping[int, int], senses: Mapping[int, int]) -> Operation:
    """Read the operation of the unit of a document.

    Parameters
    ----------
    document : the file
    carried : the shaft of each gear, by numbers of the file
    senses : +1 if the axis of a shaft points along y, -1 against it, by number

    Raises
    ------
    RexsError : power splits, shafts that no stage reaches, units that change gear
    """
    for unit in document.of_kind("gear_unit"):
        if (unit.optional("number_of_gears") or 1) > 1:
            raise unit.error("has several gears to change between. Write the file in one gear, with number_of_gears 1.")
    train = _Train(document, carried, senses)
    cases = {number: document.in_load_case(number) for number in document.load_cases} or {0: document}
    chosen = max(cases, key=lambda number: (_share(cases[number]), -number))
    ends = train.ends(cases[chosen])
    source, sink, guessed = train.direction(cases[chosen], ends)
    sense = train.sense(cases[chosen], source)
    described = {
        number: train.case(_name(number, cases[number]), cases[number], source, sink, sense) for number in cases
    }
    shafts, stages = train.order(source)
    notes = [*guessed]
    if len(cases) > 1:
        reason = f"the most frequent of {len(cases)} load cases; the others are comments at [drive]"
        notes.append(Note(kind="assumed", where="load case", value=described[chosen].name, reason=reason))
    loads = train.loads(document, sink)
    return Operation(
        document=cases[chosen],
        shafts=shafts,
        stages=stages,
        output=sink,
        output_load=loads[0] if loads else None,
        sense=sense,
        load_case=described[chosen],
        other_cases=tuple(case for number, case in described.items() if number != chosen),
        notes=tuple(notes),
    )


class _Train:
    """Shafts and stages of a document, and the speed ratios between shafts."""

    def __init__(self, document: Document, carried: Mapping[int, int], senses: Mapping[int, int]) -> None:
        self.source = document.source
        self.shafts = {shaft.number_in_file: shaft for shaft in document.of_kind("shaft")}
        self.senses = senses
        self.carried = carried
        self.stages = [(stage, _gears(document, stage)) for stage in document.of_kind("cylindrical_stage")]
        if not self.stages:
            raise RexsError(f"{document.source}: has no cylindrical_stage. Give a file of a gear unit.")
        touched = [self._pair(gears) for _, gears in self.stages]
        self.meshes = {number: sum(number in pair for pair in touched) for number in self.shafts}

    def _pair(self, gears: Gears) -> tuple[int, int]:
        one, other = (self.carried[gear.number_in_file] for gear in gears)
        return one, other

    def order(self, source: RexsComponent) -> tuple[list[RexsComponent], list[tuple[RexsComponent, Gears]]]:
        """Shafts and stages outwards from a shaft, the driving gear of each stage first."""
        reached, stages, waiting = [source.number_in_file], [], list(self.stages)
        while ready := next((one for one in waiting if set(self._pair(one[1])) & set(reached)), None):
            waiting.remove(ready)
            stage, gears = ready
            driving, driven = self._pair(gears)
            if driving not in reached or (driven in reached and reached.index(driven) < reached.index(driving)):
                gears, driven = gears[::-1], driving
            stages.append((stage, gears))
            reached += [driven] if driven not in reached else []
        for number, shaft in self.shafts.items():
            if number not in reached:
                raise shaft.error(f"no stage connects it to {source.label}. Leave it out or give the stage.")
        return [self.shafts[number] for number in reached], stages

    def ratios(self, source: RexsComponent) -> dict[int, float]:
        """Signed speed of every shaft divided by that of a shaft, about one direction."""
        found = {source.number_in_file: 1.0}
        for _, (pinion, wheel) in self.order(source)[1]:
            driving, driven = self._pair((pinion, wheel))
            turn = -pinion.number("number_of_teeth") / wheel.number("number_of_teeth")
            found.setdefault(driven, found[driving] * turn)
        return found

    def ends(self, document: Document) -> tuple[RexsComponent, RexsComponent]:
        """The two shafts with external torques; RexsError if they are not two."""
        loaded = [shaft for shaft in self.shafts.values() if self.loads(document, shaft)]
        free = [shaft for number, shaft in self.shafts.items() if self.meshes[number] == 1 and shaft not in loaded]
        if len(loaded) < 2 and len(loaded) + len(free) == 2:
            loaded += free
        if len(loaded) != 2:
            raise RexsError(
                f"{self.source}: {len(loaded)} shafts have an external_load that transmits torque; a scene has one "
                "input and one output. Give transmits_torque = true at these two alone."
            )
        return loaded[0], loaded[1]

    def direction(
        self, document: Document, ends: tuple[RexsComponent, RexsComponent]
    ) -> tuple[RexsComponent, RexsComponent, list[Note]]:
        """The ends as input and output, with a note on the assumption if no torque determines them."""
        for one, other in (ends, ends[::-1]):
            torque = self._torque(document, one)
            if torque is not None and torque != 0:
                drives = torque * (self._speed(document, one) or 1.0) > 0
                return (one, other, []) if drives else (other, one, [])
        named = [end for end in ends if document.components[end.number_in_file].text("defines_speed") == "true"]
        source = named[0] if named else ends[0]
        sink = ends[1] if source is ends[0] else ends[0]
        reason = "no torque determines where power enters; taken because " + (
            "this shaft defines the speed" if named else "it is the first in the file"
        )
        return source, sink, [Note(kind="assumed", where="input", value=source.label, reason=reason)]

    def sense(self, document: Document, source: RexsComponent) -> int:
        """Sense of the input in a load case, about y."""
        return -1 if (self._speed(document, source) or 1.0) < 0 else 1

    def case(self, name: str, document: Document, source: RexsComponent, sink: RexsComponent, sense: int) -> LoadCase:
        """Speed of the input and torque into it, positive as in the chosen case."""
        speed, torque = self._speed(document, source), self._torque(document, source)
        if torque is None and (leaving := self._torque(document, sink)) is not None:
            torque = -leaving * self.ratios(source)[sink.number_in_file]
        return LoadCase(
            name=name,
            speed=None if not speed else sense * speed,
            torque=None if torque is None else sense * torque,
        )

    def _speed(self, document: Document, shaft: RexsComponent) -> float | None:
        """Speed of a shaft about y (1/min), from the shaft whose speed is in the file; None without one."""
        given = {
            number: one.optional("rotational_speed", "1 / min")
            for number, one in document.components.items()
            if number in self.shafts
        }
        known = [number for number, speed in given.items() if speed]
        known.sort(key=lambda number: document.components[number].text("defines_speed") != "true")
        if not known:
            return None
        speed = (given[known[0]] or 0.0) * self.senses[known[0]]
        return speed * self.ratios(self.shafts[known[0]])[shaft.number_in_file]

    def loads(self, document: Document, shaft: RexsComponent) -> list[RexsComponent]:
        """The external loads of a shaft that transmit torque."""
        loads = document.parts(shaft, "external_load")
        return [load for load in loads if load.text("transmits_torque") != "false"]

    def _torque(self, document: Document, shaft: RexsComponent) -> float | None:
        """Sum of the external torques on a shaft about y (N m); None if the file gives none."""
        torques = [load.optional("torque_around_u_axis", "N m") for load in self.loads(document, shaft)]
        given = [torque for torque in torques if torque is not None]
        return self.senses[shaft.number_in_file] * sum(given) if given else None


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


def _name(number: int, document: Document) -> str:
    share = _share(document)
    return f"{number}" + (f" ({share:g} % of the time)" if share else "")
