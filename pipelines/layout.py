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
    """Where the gears and shafts of a scene are: pairs by stage, axes (x, z) by shaft, in m."""

    pairs: tuple[GearPair, ...]
    axes: tuple[tuple[float, float], ...]

    @property
    def ratio(self) -> float:
        """Total ratio: turns of the input for one turn of the output."""
        return math.prod(pair.ratio for pair in self.pairs)

    @property
    def shaft_ratios(self) -> tuple[float, ...]:
        """Speed of each shaft over the speed of the input."""
        return tuple(1 / math.prod(p.ratio for p in self.pairs[:i]) for i in range(len(self.pairs) + 1))


def lay_out(scene: Scene, source: str = "scene") -> Layout:
    """Gear pairs and axes of a scene; `source` names it in errors.

    Raises
    ------
    SceneError : gears that do not work, all stages listed
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
    axes = [(0.0, 0.0)]
    for stage, pair in zip(scene.stages, pairs, strict=True):
        angle, (x, z) = math.radians(stage.direction_deg), axes[-1]
        axes.append((x + pair.axis_distance * math.cos(angle), z + pair.axis_distance * math.sin(angle)))
    return Layout(pairs=tuple(pairs), axes=tuple(axes))
