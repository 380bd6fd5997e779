"""The bearings of a scene, in SI."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

from mbd.excitations.cage_slip import CageSlip
from mbd.excitations.spall import Spall
from mbd.forces.bearing_models import Support
from mbd.parts.bearings import BearingSpec
from mbd.parts.rolling_elements import RollingElements
from pipelines.io.errors import Problems
from pipelines.machine.layout import TrainLayout
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
    """A spall of a bearing on a shaft (from 0); `slip` is the random slip of the cage, relative to its speed."""

    bearing: str
    shaft: int
    spall: Spall
    slip: float

    @property
    def name(self) -> str:
        """Description such as "spall on the outer ring of bearing_3"."""
        return f"spall on the {self.spall.place} of {self.bearing}"


def bearing_names(shafts: Sequence[ShaftTable]) -> list[tuple[str, int, int]]:
    """Name, shaft and number on the shaft (both from 0) of every bearing.

    Bearings on the casing are bearing_1, bearing_2, ..., those on the ground ground_bearing_1, ..., numbered in the
    order of the shafts and from -y to +y.
    """
    found: list[tuple[str, int, int]] = []
    counts = {"casing": 0, "ground": 0}
    for number, shaft in enumerate(shafts):
        supports = shaft.bearing_supports or ("casing",) * len(shaft.bearing_positions_mm)
        for place, support in enumerate(supports):
            counts[support] += 1
            found.append((f"{'' if support == 'casing' else 'ground_'}bearing_{counts[support]}", number, place))
    return found


def bearing_points(shafts: Sequence[ShaftTable], layout: TrainLayout) -> tuple[tuple[float, float, float], ...]:
    """(x, y, z) of the bearings on the casing, bearing_1, bearing_2, ..., m."""
    return tuple(
        (layout.axes[shaft][0], shafts[shaft].si.bearing_positions[place], layout.axes[shaft][1])
        for name, shaft, place in bearing_names(shafts)
        if not name.startswith("ground")
    )


@dataclass(frozen=True, kw_only=True)
class _Placed:
    """A bearing of a scene: its shaft and number on it (from 0), y in m, its table with its path, and its slip."""

    name: str
    shaft: int
    place: int
    y: float
    table: BearingModel
    path: str

    @property
    def slip(self) -> float:
        """Random slip of the cage, relative to its speed."""
        return getattr(self.table, "cage_slip", 0.0)


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
                table=bearing_table(table, scene.bearings, place),
                path=f"shafts.{shaft + 1}.bearings.{place + 1}" if table.bearings else "bearings",
            )
        )
    return found


def rolling_bearings(scene: Scene) -> tuple[RollingBearing, ...]:
    """The bearings whose rolling elements are known, in shaft order."""
    made = ((one, one.table.made().elements) for one in _placed(scene))
    return tuple(
        RollingBearing(name=one.name, shaft=one.shaft, elements=elements)
        for one, elements in made
        if elements is not None
    )


def bearing_faults(scene: Scene) -> dict[int, BearingFault]:
    """The spalls of the bearings by fault number in the scene, from 1."""
    placed = {(one.shaft, one.place): one for one in _placed(scene)}
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
    for one in _placed(scene):
        at = (f"shaft_{one.shaft + 1}", one.y)
        support: Support = "ground" if one.name.startswith("ground") else "casing"
        model = problems.made(one.path, one.table.made)
        spec: BearingSpec | None = model and problems.made(one.path, model.spec, one.name, at, support)
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
        slip = None
        if one.slip:
            slip = CageSlip(share=one.slip, seed=(scene.deviations.seed, zlib.crc32(one.name.encode())))
        found.append(with_faults(spec, spalls, slip))
    return tuple(found)


def bearing_table(shaft: ShaftTable, usual: BearingModel, place: int) -> BearingModel:
    """The table of a bearing by its number on a shaft (from 0); `usual` if the shaft has no tables of bearings."""
    return shaft.bearings[place] if shaft.bearings else usual
