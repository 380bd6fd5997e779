"""REXS document: components with attributes, and the relations between them, from any version of the file.

Attributes have a unit in the file; `RexsComponent.number` converts them to the requested unit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from pipelines.io.errors import InputError
from pipelines.io.shown_text import number_of, shown

_UNITS = {  # unit: (quantity, factor to the first unit of that quantity)
    "mm": ("length", 1.0),
    "mum": ("length", 1e-3),
    "m": ("length", 1000.0),
    "deg": ("angle", 1.0),
    "°": ("angle", 1.0),
    "rad": ("angle", 180 / math.pi),
    "1 / min": ("speed", 1.0),
    "rad / s": ("speed", 30 / math.pi),
    "N m": ("torque", 1.0),
    "N": ("force", 1.0),
    "kN": ("force", 1000.0),
    "N / m": ("stiffness", 1.0),
    "N / mm": ("stiffness", 1000.0),
    "N mm / rad": ("tilt stiffness", 1.0),
    "N / mm^2": ("pressure", 1.0),
    "MPa": ("pressure", 1.0),
    "kg / dm^3": ("density", 1.0),
    "%": ("share", 1.0),
    "none": ("number", 1.0),
    "": ("number", 1.0),
}


class RexsError(InputError):
    """A REXS file cannot be converted to a scene; gives the place, the cause and the remedy."""


@dataclass(frozen=True)
class Attribute:
    """A value of the file: its text, or the numbers of an array."""

    text: str = ""
    numbers: tuple[float, ...] = ()
    unit: str = "none"


@dataclass(frozen=True)
class RexsComponent:
    """A part of the gear unit."""

    number_in_file: int
    kind: str
    name: str
    attributes: Mapping[str, Attribute]
    source: str  # of the file, for messages

    @property
    def label(self) -> str:
        """Name of the component in messages and comments."""
        return f"{shown(self.name or self.kind, 60)} (id {self.number_in_file})"

    def error(self, message: str) -> RexsError:
        """Error of this component."""
        return RexsError(f"{self.source}: {shown(self.kind)} {self.label}: {message}")

    def text(self, key: str) -> str:
        """Text of an attribute, "" without one."""
        found = self.attributes.get(key)
        return found.text.strip() if found else ""

    def optional(self, key: str, unit: str = "none") -> float | None:
        """Number of an attribute in `unit`, None if it is missing.

        Raises
        ------
        RexsError : not a finite number, or a unit of another quantity
        """
        found = self.attributes.get(key)
        if found is None or not (text := found.text.strip()):
            return None
        value = number_of(text)
        if not math.isfinite(value):
            raise self.error(f'{key} = "{shown(text)}" is not a finite number. Correct it.')
        return value * self._factor(key, found.unit, unit)

    def number(self, key: str, unit: str = "none") -> float:
        """Number of an attribute in `unit`; RexsError also if it is missing."""
        value = self.optional(key, unit)
        if value is None:
            raise self.error(f"{key} is missing. Add it.")
        return value

    def vector(self, key: str) -> tuple[float, float, float] | None:
        """A length (mm) along u, v, w, None if it is missing; RexsError if it has not three finite numbers."""
        found = self.attributes.get(key)
        if found is None:
            return None
        if len(found.numbers) != 3 or not all(map(math.isfinite, found.numbers)):
            raise self.error(f"{key} has {len(found.numbers)} numbers, and must have 3 finite ones. Correct it.")
        factor = self._factor(key, found.unit, "mm")
        u, v, w = (factor * value for value in found.numbers)
        return u, v, w

    def _factor(self, key: str, given: str, wanted: str) -> float:
        kind, factor = _UNITS.get(given.strip(), ("", math.nan))
        wanted_kind, unit = _UNITS[wanted]
        if kind != wanted_kind:
            raise self.error(f'{key} has the unit "{shown(given)}" instead of one like "{wanted}". Correct the unit.')
        return factor / unit


@dataclass(frozen=True)
class Relation:
    """Relation between components: role -> component."""

    kind: str
    roles: Mapping[str, int]


@dataclass(frozen=True)
class Document:
    """Content of a REXS file. `load_cases` are the attributes by load case and component."""

    source: str
    version: str
    written_by: str
    components: Mapping[int, RexsComponent]
    relations: tuple[Relation, ...]
    load_cases: Mapping[int, Mapping[int, Mapping[str, Attribute]]]

    def of_kind(self, *kinds: str) -> list[RexsComponent]:
        """All components of some kinds, in the order of the file."""
        return [component for component in self.components.values() if component.kind in kinds]

    def parts(self, whole: RexsComponent, kind: str) -> list[RexsComponent]:
        """The components of a kind that are assembled into another one, in the order of the file."""
        found = [
            self.components.get(relation.roles.get("part", -1))
            for relation in self.relations
            if relation.kind in ("assembly", "ordered_assembly")
            and relation.roles.get("assembly") == whole.number_in_file
        ]
        return [part for part in found if part is not None and part.kind == kind]

    def role(self, relation: Relation, name: str) -> RexsComponent:
        """Component in a role; RexsError if there is none."""
        component = self.components.get(relation.roles.get(name, -1))
        if component is None:
            raise RexsError(
                f"{self.source}: a relation {shown(relation.kind)} names no component as {name}. Correct it."
            )
        return component

    def in_load_case(self, case: int) -> Document:
        """The document with the attributes of a load case in place of those of its components."""
        over = self.load_cases[case]
        components = {
            number: replace(component, attributes={**component.attributes, **over.get(number, {})})
            for number, component in self.components.items()
        }
        return replace(self, components=components)


def by_number(components: Iterable[RexsComponent], source: str) -> dict[int, RexsComponent]:
    """Components by their number in the file; RexsError for a duplicate number."""
    found: dict[int, RexsComponent] = {}
    for component in components:
        number = component.number_in_file
        if number in found:
            raise RexsError(
                f"{source}: {found[number].label} and {component.label} have the same id. Correct one of them."
            )
        found[number] = component
    return found
