"""The bearings of a scene, in SI."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Any

from mbd.excitations.cage_slip import CageSlip
from mbd.excitations.spall import Spall
from mbd.forces.bearing_models import Support
from mbd.parts.bearings import BearingSpec
from mbd.parts.rolling_elements import RollingElements
from pipelines.io.errors import Problems
from pipelines.machine.layout import TrainLayout
from pipelines.scene.scene import Scene
from pipelines.scene.tables.bearings import BearingModel


@dataclass(frozen=True, kw_only=True)
class RollingBearing:
    """A bearing on a shaft (from 0) whose rolling elements are known."""

    name: str
    shaft: int
    elements: RollingElements


@dataclass(frozen=True, kw_only=True)
class BearingFault:
    """A spall of a bearing on a shaft (from 0); `slip` is the random slip of the cage, relative to its speed."""

    bearing: str
    shaft: int
    spall: Spall
    slip: float

    @property
    def name(self) -> str:
        """Description such as "spall on the outer ring of bearing_3"."""
        return f"spall on the {self.spall.place} of {self.bearing}"


@dataclass(frozen=True, kw_only=True)
class PlacedBearing:
    """A bearing of a scene: its shaft and number on it (from 0), y in m, its table with its path, and its slip."""

    name: str
    shaft: int
    place: int
    y: float
    support: Support
    table: BearingModel
    path: str

    @property
    def slip(self) -> float:
        """Random slip of the cage, relative to its speed."""
        return getattr(self.table, "cage_slip", 0.0)


def placed_bearings(scene: Scene) -> list[PlacedBearing]:
    """All bearings.

    Those on the casing are bearing_1, bearing_2, ..., those on the ground ground_bearing_1, ..., numbered in the order
    of the shafts and from -y to +y.
    """
    found: list[PlacedBearing] = []
    counts = {"casing": 0, "ground": 0}
    for number, shaft in enumerate(scene.shafts):
        places = shaft.si.bearing_positions
        supports: Any = shaft.bearing_supports or ("casing",) * len(places)
        for place, support in enumerate(supports):
            counts[support] += 1
            found.append(
                PlacedBearing(
                    name=f"{'' if support == 'casing' else 'ground_'}bearing_{counts[support]}",
                    shaft=number,
                    place=place,
                    y=places[place],
                    support=support,
                    table=shaft.bearings[place] if shaft.bearings else scene.bearings,
                    path=f"shafts.{number + 1}.bearings.{place + 1}" if shaft.bearings else "bearings",
                )
            )
    return found


def bearing_points(scene: Scene, layout: TrainLayout) -> tuple[tuple[float, float, float], ...]:
    """(x, y, z) of the bearings on the casing, bearing_1, bearing_2, ..., m."""
    carried = (one for one in placed_bearings(scene) if one.support == "casing")
    return tuple((layout.axes[one.shaft][0], one.y, layout.axes[one.shaft][1]) for one in carried)


def rolling_bearings(scene: Scene) -> tuple[RollingBearing, ...]:
    """The bearings whose rolling elements are known, in shaft order."""
    made = ((one, one.table.made().elements) for one in placed_bearings(scene))
    return tuple(
        RollingBearing(name=one.name, shaft=one.shaft, elements=elements)
        for one, elements in made
        if elements is not None
    )


def bearing_faults(scene: Scene) -> dict[int, BearingFault]:
    """The spalls of the bearings by fault number in the scene, from 1."""
    placed = {(one.shaft, one.place): one for one in placed_bearings(scene)}
    found = {}
    for number, fault in scene.spalls.items():
        one = placed[fault.shaft - 1, fault.bearing - 1]
        found[number] = BearingFault(bearing=one.name, shaft=one.shaft, spall=fault.made(), slip=one.slip)
    return found


def bearing_specs(scene: Scene, problems: Problems) -> tuple[BearingSpec, ...]:
    """All bearings with their spalls and the slip of their cages, in the order of the shafts and from -y to +y.

    The slip of each cage is a separate random sequence.

    Parameters
    ----------
    scene : the scene
    problems : collects errors of bearings and spalls
    """
    faults = bearing_faults(scene)
    found = []
    for one in placed_bearings(scene):
        at, model = (f"shaft_{one.shaft + 1}", one.y), problems.made(one.path, one.table.made)
        spec: BearingSpec | None = model and problems.made(one.path, model.spec, one.name, at, one.support)
        if spec is None:
            continue
        own = {number: fault.spall for number, fault in faults.items() if fault.bearing == one.name}
        if not own and not one.slip:
            found.append(spec)
            continue
        from mbd.excitations.faulty_bearing import with_faults  # compiled code

        spalls: list[Spall] = []
        for number, spall in own.items():
            if problems.made(f"faults.{number}", with_faults, spec, [*spalls, spall]) is not None:
                spalls.append(spall)
        seed = scene.deviations.seed, zlib.crc32(one.name.encode())
        found.append(with_faults(spec, spalls, CageSlip(share=one.slip, seed=seed) if one.slip else None))
    return tuple(found)
