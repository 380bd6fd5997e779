"""The bearings of a scene, in SI."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from mbd.bearing_faults.cage_slip import CageSlip
from mbd.bearing_faults.faulty_bearing import with_faults
from mbd.bearing_faults.spall import Spall
from mbd.forces.rolling_bearing import hertz_bearing
from mbd.parts.bearings import BearingSpec, rigid_bearing
from mbd.parts.checks import MachineError
from mbd.parts.rolling_catalogue import by_designation
from mbd.parts.rolling_elements import RollingElements
from pipelines.scene.scene import Scene
from pipelines.scene.tables.bearings import BearingModel, HertzBearings, LinearBearings, RigidBearings
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
        (layout.axes[shaft][0], shafts[shaft].bearing_positions_mm[place] / 1000, layout.axes[shaft][1])
        for name, shaft, place in bearing_names(shafts)
        if not name.startswith("ground")
    )


def rolling_bearings(shafts: Sequence[ShaftTable], usual: BearingModel) -> tuple[RollingBearing, ...]:
    """The bearings whose rolling elements are known, in shaft order; `usual` where a shaft names none.

    MachineError if its elements do not fit."""
    found = []
    for name, number, place in bearing_names(shafts):
        table = bearing_table(shafts[number], usual, place)
        if isinstance(table, HertzBearings):
            found.append(RollingBearing(name=name, shaft=number, elements=rolling_elements(table)))
    return tuple(found)


def bearing_specs(shafts: Sequence[ShaftTable], usual: BearingModel) -> tuple[BearingSpec, ...]:
    """All bearings in shaft order, from -y; `usual` where a shaft names none."""
    specs = []
    for name, number, place in bearing_names(shafts):
        at = f"shaft_{number + 1}", shafts[number].bearing_positions_mm[place] / 1000
        support: Literal["casing", "ground"] = "ground" if name.startswith("ground") else "casing"
        specs.append(_bearing(bearing_table(shafts[number], usual, place), name, *at, support))
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
        slip = table.cage_slip if isinstance(table, HertzBearings) else 0.0
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
        slip = None
        if isinstance(table, HertzBearings) and table.cage_slip:
            slip = CageSlip(share=table.cage_slip, seed=(scene.deviations.seed, zlib.crc32(name.encode())))
        found.append(with_faults(spec, [fault.spall for fault in spalls if fault.bearing == name], slip))
    return tuple(found)


def bearing_table(shaft: ShaftTable, usual: BearingModel, place: int) -> BearingModel:
    """The table of the bearing at a place on a shaft (from 0); `usual` where the shaft names none."""
    return shaft.bearings[place] if shaft.bearings else usual


def _bearing(
    table: RigidBearings | LinearBearings | HertzBearings, name: str, shaft: str, y: float,
    support: Literal["casing", "ground"],
) -> BearingSpec:  # fmt: skip
    if isinstance(table, RigidBearings):
        return rigid_bearing(name, shaft, y, support)
    if isinstance(table, HertzBearings):
        return hertz_bearing(name, shaft, y, rolling_elements(table), table.damping_time_us / 1_000_000, support)
    return linear_bearing(table, name, shaft, y, support)


def linear_bearing(
    table: LinearBearings, name: str, shaft: str, y: float, support: Literal["casing", "ground"]
) -> BearingSpec:
    """A bearing of springs and dampers.

    Parameters
    ----------
    table : its table of the scene
    name, shaft : names of the bearing and of the shaft in it
    y : m, place on the shaft
    support : what carries the bearing

    Raises
    ------
    MachineError : the cross terms outweigh the others
    """
    radial, vertical = table.radial_stiffness_N_per_um, table.vertical_stiffness_N_per_um
    cross = table.cross_stiffness_N_per_um * 1e6
    return BearingSpec(
        name=name,
        shaft=shaft,
        y=y,
        stiffness_x=radial * 1e6,
        stiffness_z=(radial if vertical is None else vertical) * 1e6,
        stiffness_axial=table.axial_stiffness_N_per_um * 1e6,
        stiffness_tilt_x=table.tilt_stiffness_N_m_per_rad,
        stiffness_tilt_z=table.tilt_stiffness_N_m_per_rad,
        cross=(("ux", "uz", cross),) if cross else (),
        damping_time=table.damping_time_us / 1_000_000,
        support=support,
    )


def rolling_elements(table: HertzBearings) -> RollingElements:
    """The inside of a rolling bearing, from the catalogue or as given. MachineError if its elements do not fit."""
    given = {
        "contact_angle": None if table.contact_angle_deg is None else math.radians(table.contact_angle_deg),
        "length": None if table.roller_length_mm is None else table.roller_length_mm / 1000,
        "inner_conformity": table.inner_conformity,
        "outer_conformity": table.outer_conformity,
        "clearance": table.radial_clearance_um / 1_000_000,
        "preload": table.axial_preload_um / 1_000_000,
        "cage_start": math.radians(table.cage_start_deg),
    }
    changes: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    if table.designation is not None:
        return replace(by_designation(table.designation), **changes)
    if table.kind is None or table.elements is None or table.element_diameter_mm is None:
        raise MachineError("bearings: set designation, or kind, elements, element_diameter_mm and pitch_diameter_mm.")
    return RollingElements(
        kind=table.kind,
        count=table.elements,
        diameter=table.element_diameter_mm / 1000,
        pitch_diameter=(table.pitch_diameter_mm or 0.0) / 1000,
        **changes,
    )
