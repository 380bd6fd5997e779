"""The bearings of a scene, in SI."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbd.bearing_faults.cage_slip import CageSlip
from mbd.bearing_faults.faulty_bearing import with_faults
from mbd.bearing_faults.spall import Spall
from mbd.parts.bearings import BearingSpec
from mbd.parts.rolling_elements import RollingElements
from pipelines.scene.scene import Scene
from pipelines.scene.tables.bearings import BearingModel
from pipelines.scene.tables.shafts import ShaftTable

if TYPE_CHECKING:
    from pipelines.plant.layout import Layout


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


def rolling_bearings(shafts: Sequence[ShaftTable], usual: BearingModel) -> tuple[RollingBearing, ...]:
    """The bearings whose rolling elements are known, in shaft order; `usual` where a shaft names none.

    MachineError if its elements do not fit."""
    found = []
    for name, number, place in bearing_names(shafts):
        if elements := bearing_table(shafts[number], usual, place).made().elements:
            found.append(RollingBearing(name=name, shaft=number, elements=elements))
    return tuple(found)


def bearing_specs(shafts: Sequence[ShaftTable], usual: BearingModel) -> tuple[BearingSpec, ...]:
    """All bearings in shaft order, from -y; `usual` where a shaft names none."""
    specs = []
    for name, number, place in bearing_names(shafts):
        model, y = bearing_table(shafts[number], usual, place).made(), shafts[number].si.bearing_positions[place]
        support = "ground" if name.startswith("ground") else "casing"
        specs.append(model.spec(name, (f"shaft_{number + 1}", y), support))
    return tuple(specs)


def bearing_faults(scene: Scene) -> tuple[BearingFault, ...]:
    """All spalls of the bearings. MachineError for one that does not fit."""
    return tuple(fault for _, fault in numbered_bearing_faults(scene))


def numbered_bearing_faults(scene: Scene) -> Iterator[tuple[int, BearingFault]]:
    """The spalls with their numbers in the scene, from 1."""
    names = {(shaft, place): name for name, shaft, place in bearing_names(scene.shafts)}
    for number, fault in scene.spalls.items():
        shaft, place = fault.shaft - 1, fault.bearing - 1
        table = bearing_table(scene.shafts[shaft], scene.bearings, place)
        slip = table.made().cage_slip
        yield number, BearingFault(bearing=names[shaft, place], shaft=shaft, spall=fault.made(), slip=slip)


def with_bearing_faults(scene: Scene, specs: Sequence[BearingSpec]) -> tuple[BearingSpec, ...]:
    """The bearings of a scene with their spalls and slipping cages; each cage has a sequence of its own.

    Raises
    ------
    MachineError : a spall that does not fit
    """
    spalls = bearing_faults(scene)
    found = []
    for spec, (name, shaft, place) in zip(specs, bearing_names(scene.shafts), strict=True):
        table = bearing_table(scene.shafts[shaft], scene.bearings, place)
        share, slip = table.made().cage_slip, None
        if share:
            slip = CageSlip(share=share, seed=(scene.deviations.seed, zlib.crc32(name.encode())))
        found.append(with_faults(spec, [fault.spall for fault in spalls if fault.bearing == name], slip))
    return tuple(found)


def bearing_table(shaft: ShaftTable, usual: BearingModel, place: int) -> BearingModel:
    """The table of the bearing at a place on a shaft (from 0); `usual` where the shaft names none."""
    return shaft.bearings[place] if shaft.bearings else usual
