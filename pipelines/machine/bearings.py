"""The bearings of a scene, in SI."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from mbd.excitations.cage_slip import CageSlip
from mbd.excitations.faulty_bearing import with_faults
from mbd.excitations.spall import Spall
from mbd.forces.bearing_models import Support
from mbd.parts.bearings import BearingSpec
from mbd.parts.rolling_elements import RollingElements
from pipelines.io.errors import Problems
from pipelines.machine.layout import Layout
from pipelines.scene.scene import Scene
from pipelines.scene.tables.bearings import BearingModel
from pipelines.scene.tables.shafts import ShaftTable


@dataclass(frozen=True, kw_only=True)
class RollingBearing:
    """A bearing on a shaft (from 0) whose rolling elements are known."""

    name: str
    shaft: int
    elements: RollingElements


@dataclass(frozen=True, kw_only=True)
class BearingFault:
    """A spall of a bearing on a shaft (from 0), and the share of speed by which the cage slips at random."""

    bearing: str
    shaft: int
    spall: Spall
    slip: float

    @property
    def name(self) -> str:
        """In words: "spall on the outer ring of bearing_3"."""
        return f"spall on the {self.spall.place} of {self.bearing}"


def bearing_names(shafts: Sequence[ShaftTable]) -> list[tuple[str, int, int]]:
    """Name, shaft and place on it (0-based) of every bearing: bearing_1, bearing_2, ... carried by the casing, numbered
    in shaft order from -y; ground_bearing_1, ... by the ground."""
    found: list[tuple[str, int, int]] = []
    counts = {"casing": 0, "ground": 0}
    for number, shaft in enumerate(shafts):
        supports = shaft.bearing_supports or ("casing",) * len(shaft.bearing_positions_mm)
        for place, support in enumerate(supports):
            counts[support] += 1
            found.append((f"{'' if support == 'casing' else 'ground_'}bearing_{counts[support]}", number, place))
    return found


def bearing_points(shafts: Sequence[ShaftTable], layout: Layout) -> tuple[tuple[float, float, float], ...]:
    """(x, y, z) of bearing_1, bearing_2, ... (m), those that the casing carries."""
    return tuple(
        (layout.axes[shaft][0], shafts[shaft].si.bearing_positions[place], layout.axes[shaft][1])
        for name, shaft, place in bearing_names(shafts)
        if not name.startswith("ground")
    )


@dataclass(frozen=True, kw_only=True)
class _Placed:
    """A bearing of a scene: shaft and place on it from 0, y in m, its options, the path of its table."""

    name: str
    shaft: int
    place: int
    y: float
    model: Any
    path: str

    @property
    def support(self) -> Support:
        """What carries it."""
        return "ground" if self.name.startswith("ground") else "casing"


def _placed(scene: Scene) -> list[_Placed]:
    found = []
    for name, shaft, place in bearing_names(scene.shafts):
        table = scene.shafts[shaft]
        found.append(
            _Placed(
                name=name,
                shaft=shaft,
                place=place,
                y=table.si.bearing_positions[place],
                model=bearing_table(table, scene.bearings, place).made(),
                path=f"shafts.{shaft + 1}.bearings.{place + 1}" if table.bearings else "bearings",
            )
        )
    return found


def rolling_bearings(scene: Scene) -> tuple[RollingBearing, ...]:
    """The bearings whose rolling elements are known, in shaft order."""
    return tuple(
        RollingBearing(name=one.name, shaft=one.shaft, elements=one.model.elements)
        for one in _placed(scene)
        if one.model.elements is not None
    )


def bearing_faults(scene: Scene) -> dict[int, BearingFault]:
    """The spalls of the bearings by their numbers in the scene, from 1."""
    placed = {(one.shaft, one.place): one for one in _placed(scene)}
    found = {}
    for number, fault in scene.spalls.items():
        one = placed[fault.shaft - 1, fault.bearing - 1]
        found[number] = BearingFault(bearing=one.name, shaft=one.shaft, spall=fault.made(), slip=one.model.cage_slip)
    return found


def bearing_specs(scene: Scene, problems: Problems) -> tuple[BearingSpec, ...]:
    """All bearings in shaft order, from -y, with their spalls and slipping cages; each cage has a sequence of its own.

    Parameters
    ----------
    scene : the scene
    problems : take the bearings and spalls that do not fit
    """
    faults = bearing_faults(scene)
    found = []
    for one in _placed(scene):
        at = (f"shaft_{one.shaft + 1}", one.y)
        spec: BearingSpec | None = problems.made(one.path, one.model.spec, one.name, at, one.support)
        if spec is None:
            continue
        spalls: list[Spall] = []
        for number, fault in faults.items():
            if fault.bearing == one.name:
                path = f"faults.{number}"
                if problems.made(path, with_faults, spec, [*spalls, fault.spall]) is not None:
                    spalls.append(fault.spall)
        slip = None
        if one.model.cage_slip:
            slip = CageSlip(share=one.model.cage_slip, seed=(scene.deviations.seed, zlib.crc32(one.name.encode())))
        found.append(with_faults(spec, spalls, slip))
    return tuple(found)


def bearing_table(shaft: ShaftTable, usual: BearingModel, place: int) -> BearingModel:
    """The table of the bearing at a place on a shaft (from 0); `usual` where the shaft names none."""
    return shaft.bearings[place] if shaft.bearings else usual
