"""Layout: a scene turned into SI objects - gear pairs, axis positions, housing, machine.

Units are converted here and nowhere else, by division by exact integers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from fem.gears.geometry import Gear, GearPair, GeometryError, Rack
from fem.materials import Material
from pipelines.errors import Problem, SceneError
from pipelines.scene import Scene
from pipelines.tables.base import MaterialTable
from pipelines.tables.gears import StageTable
from pipelines.train import place_shafts, stage_shafts


def material(name: str, table: MaterialTable) -> Material:
    """The material of a table, in SI."""
    return Material(
        name=name,
        elastic_modulus=table.elastic_modulus_GPa * 1e9,
        poisson_ratio=table.poisson_ratio,
        density=table.density_kg_m3,
    )


def gear_pair(stage: StageTable, steel: Material) -> GearPair:
    """The gear pair of a stage, in SI. Raises GeometryError with the reason when the gears do not work."""
    rack = Rack(
        addendum=stage.rack_addendum,
        dedendum=stage.rack_dedendum,
        tip_radius=stage.rack_tip_radius,
        pressure_angle=math.radians(stage.pressure_angle_deg),
    )
    wheel_hand = "left" if stage.pinion_hand == "right" else "right"

    def gear(teeth: int, shift: float, bore: float, hand: str) -> Gear:
        return Gear(
            teeth=teeth,
            normal_module=stage.module_mm / 1000,
            helix_angle=math.radians(stage.helix_angle_deg),
            face_width=stage.face_width_mm / 1000,
            profile_shift=shift,
            rack=rack,
            bore_radius=bore / 2000,
            hand=hand,
        )

    return GearPair(
        pinion=gear(stage.pinion_teeth, stage.pinion_profile_shift, stage.pinion_bore_mm, stage.pinion_hand),
        wheel=gear(stage.wheel_teeth, stage.wheel_profile_shift, stage.wheel_bore_mm, wheel_hand),
        backlash_allowance=stage.backlash_um / 1_000_000,
        pinion_material=steel,
        wheel_material=steel,
    )


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Where the gears and shafts of a scene are: pairs by stage; axes (x, z) in m, senses and speeds by shaft.

    Shafts are numbered from 0. Ratios of speeds are over that of shaft ``driven``, which the motors turn.
    """

    pairs: tuple[GearPair, ...]
    axes: tuple[tuple[float, float], ...]
    senses: tuple[int, ...]  # lifting rotation about +y or -y; that of the first shaft is +1
    shaft_ratios: tuple[float, ...]  # speed of each shaft over that of the motors
    pair_shafts: tuple[tuple[int, int], ...]  # shafts of pinion and wheel, by stage
    driven: int
    loaded: int  # the shaft that carries the drums

    @property
    def ratio(self) -> float:
        """Total ratio: turns of the input for one turn of the output."""
        return 1 / self.shaft_ratios[self.loaded]


def lay_out(scene: Scene, source: str = "scene") -> Layout:
    """Gear pairs and axes of a scene; `source` names it in errors.

    Raises
    ------
    SceneError : gears that do not work, a train that does not hang together, all of it listed
    """
    steel = material("gear steel", scene.gear_material)
    pairs, problems = [], []
    for number, stage in enumerate(scene.stages, 1):
        try:
            pairs.append(gear_pair(stage, steel))
        except GeometryError as error:
            problems.append(Problem(f"stages.{number}", str(error)))
    if problems:
        raise SceneError(source, problems)
    places, problems = place_shafts(len(scene.shafts), scene.stages, pairs, scene.couplings)
    if problems:
        raise SceneError(source, problems)
    driven = (scene.drive.shaft or 1) - 1
    return Layout(
        pairs=tuple(pairs),
        axes=tuple((place.x, place.z) for place in places),
        senses=tuple(place.sense for place in places),
        shaft_ratios=tuple(place.speed / places[driven].speed for place in places),
        pair_shafts=tuple(stage_shafts(scene.stages)),
        driven=driven,
        loaded=(scene.load.shaft or len(scene.shafts)) - 1,
    )
