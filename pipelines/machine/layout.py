"""Layout of a scene in SI units: gear pairs, axes and speed ratios of the shafts, and the largest torques."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fem.elements.materials import Material
from fem.gears.gear import Gear
from fem.gears.gear_checks import GeometryError
from fem.gears.geometry import GearPair
from fem.gears.modifications import PairModifications, check_modifications
from fem.gears.rack import Rack
from mbd.parts.train import power_flow
from pipelines.io.errors import Problem, SceneError
from pipelines.machine.scene_flanks import modifications
from pipelines.scene.phases import mesh_cycles
from pipelines.scene.scene import Scene
from pipelines.scene.shaft_places import place_shafts, shaft_senses, stage_shafts
from pipelines.scene.tables.gears import GearTable
from pipelines.scene.tables.stages import StageTable

USUAL_BORE = 0.5  # of the root circle, if a scene gives no bore
USUAL_BACKLASH = 80e-6  # m, if a scene gives no centre distance, allowances or backlash
USUAL_LINE_LOAD = 100e3  # N/m, for which curves and contacts are shown if there is no load


def gear_pair(stage: StageTable, steel: Material, sense: int = 1) -> GearPair:
    """The gear pair of a stage, in SI; `sense` is the lifting sense of its pinion, +1 about +y.

    The face coordinate of a pair is positive along the rotation vector of its pinion in lifting. For sense = -1 it is
    therefore opposite to y. A given backlash is the total one, including those of centre distance and allowances.

    Raises
    ------
    GeometryError : the gears do not mesh, or the given backlash is less than that of centre distance and allowances
    """
    pinion_hand = stage.pinion_hand
    pair = GearPair(
        pinion=_named_gear(stage, "pinion", pinion_hand, sense),
        wheel=_named_gear(stage, "wheel", "left" if pinion_hand == "right" else "right", sense),
        centre_distance=stage.si.centre_distance,
        pinion_material=steel,
        wheel_material=steel,
    )
    allowances = stage.pinion.thickness_allowance_um, stage.wheel.thickness_allowance_um
    given = stage.centre_distance_mm is not None or any(allowances)
    backlash = stage.si.backlash if stage.backlash_um is not None else None if given else USUAL_BACKLASH
    if backlash is None:
        return pair
    if not given:  # exact: not changed by rounding of the centre distance
        return replace(pair, centre_distance=None, backlash_allowance=backlash)
    if backlash < pair.backlash - 1e-9:
        raise GeometryError(
            f"{pair.label}: backlash_um = {stage.backlash_um:g} is less than the {pair.backlash * 1e6:.1f} um of "
            "centre distance and thickness allowances. Raise it, delete it, or reduce centre_distance_mm"
        )
    return replace(pair, backlash_allowance=backlash - pair.backlash)


def _named_gear(stage: StageTable, name: str, hand: str, sense: int) -> Gear:
    try:
        return _gear(stage, name, hand, sense)
    except GeometryError as error:
        raise GeometryError(f"{name}: {error}") from error


def _gear(stage: StageTable, name: str, hand: str, sense: int) -> Gear:
    table: GearTable = getattr(stage, name)

    own = {name: getattr(table, f"rack_{name}") for name in ("addendum", "dedendum", "tip_radius")}
    values = {name: getattr(stage, f"rack_{name}") if value is None else value for name, value in own.items()}
    rack = Rack(**values, pressure_angle=stage.si.pressure_angle)
    solid: Gear = table.made_part(
        Gear,
        teeth=getattr(stage, f"{name}_teeth"),
        normal_module=stage.si.module,
        helix_angle=stage.si.helix_angle,
        face_width=stage.si.face_width,
        profile_shift=getattr(stage, f"{name}_profile_shift"),
        rack=rack,
        bore_radius=1e-6 * stage.si.module,
        hand=hand,
        web_offset=sense * table.si.web_offset + 0.0,  # no -0: equal pairs share a law
    )
    bore: float | None = getattr(stage.si, f"{name}_bore")
    if bore is None:
        return replace(solid, bore_radius=solid.root_radius * USUAL_BORE)
    if bore / 2 >= solid.root_radius:
        raise GeometryError(
            f"{name}_bore_mm = {1000 * bore:g} reaches the root circle, diameter {2000 * solid.root_radius:.6g} mm. "
            "Reduce it, or correct module_mm or the number of teeth. Without this key the bore diameter "
            "is half the root diameter"
        )
    return replace(solid, bore_radius=bore / 2)


@dataclass(frozen=True, kw_only=True)
class StageFacts:
    """Derived quantities of a stage at the highest motor speed and the largest load (SI)."""

    ratio: float
    centre_distance: float
    transverse_contact_ratio: float
    overlap_ratio: float
    mesh_frequency: float
    pinion_frequency: float
    wheel_frequency: float
    pinion_torque: float
    mesh_force: float
    shown_force: float  # for which curves and contacts are shown; without a load that of USUAL_LINE_LOAD
    line_load: float
    backlash: float


@dataclass(frozen=True, kw_only=True)
class TrainLayout:
    """Gear pairs and flank modifications of a scene by stage, and its axes, speeds and torques by shaft.

    Axes are (x, z) in m. Shafts are numbered from 0. Speed ratios are relative to the shaft ``driven`` of the motors,
    whose highest speed is ``turns`` (1/s). ``torques`` are those of greatest magnitude from load and external forces:
    shaft, y (m), and torque (N m, positive if it drives).
    """

    pairs: tuple[GearPair, ...]
    modifications: tuple[PairModifications, ...]
    axes: tuple[tuple[float, float], ...]
    senses: tuple[int, ...]  # lifting rotation about +y or -y; that of the first shaft is +1
    shaft_ratios: tuple[float, ...]  # speed of each shaft divided by that of the motors
    pair_shafts: tuple[tuple[int, int], ...]  # shafts of pinion and wheel, by stage
    cycles_at_start: tuple[float, ...]  # mesh cycle at t = 0, by stage
    coupling_shafts: tuple[tuple[int, int], ...]  # of the couplings that transmit rotation
    driven: int
    loaded: int  # the shaft that carries the load
    turns: float
    motors: tuple[float, ...]  # y of the motors on the driven shaft (m)
    torques: tuple[tuple[int, float, float], ...]

    @property
    def ratio(self) -> float:
        """Total ratio: speed of the motors divided by that of the loaded shaft."""
        return 1 / self.shaft_ratios[self.loaded]

    @cached_property
    def resisting_torques(self) -> tuple[float, ...]:
        """Torques (N m) of greatest magnitude that resist the rotation of each shaft; the motors share their power."""
        found = [0.0] * len(self.axes)
        for shaft, _, torque in self.torques:
            found[shaft] -= torque
        return tuple(found)

    @property
    def motor_speed(self) -> float:
        """Highest motor speed (rad/s)."""
        return self.turns * 2 * math.pi

    @property
    def input_torque(self) -> float:
        """Torque (N m) of the motors that balances all resisting torques, without losses."""
        return float(np.dot(self.resisting_torques, self.shaft_ratios))

    @cached_property
    def power_flows(self) -> list[float]:
        """Power divided by motor speed (N m) of each stage, then of each coupling, without losses.

        For parallel paths see `mbd.parts.train.power_flow`.
        """
        flows = [*self.pair_shafts, *self.coupling_shafts]
        powers = np.array(self.resisting_torques) * np.array(self.shaft_ratios)
        return power_flow(flows, [self.driven], powers)[: len(flows)].tolist()

    @cached_property
    def stages(self) -> tuple[StageFacts, ...]:
        """Every stage at the highest motor speed and the largest load."""
        stages = []
        for pair, (pinion, _), flow in zip(self.pairs, self.pair_shafts, self.power_flows, strict=False):
            pinion_speed = self.shaft_ratios[pinion]
            frequency = self.motor_speed * pinion_speed / (2 * math.pi)
            pinion_torque = flow / pinion_speed
            force = pinion_torque / pair.pinion.base_radius
            stages.append(
                StageFacts(
                    ratio=pair.ratio,
                    centre_distance=pair.axis_distance,
                    transverse_contact_ratio=pair.transverse_contact_ratio,
                    overlap_ratio=pair.overlap_ratio,
                    mesh_frequency=frequency * pair.pinion.teeth,
                    pinion_frequency=frequency,
                    wheel_frequency=frequency / pair.ratio,
                    pinion_torque=pinion_torque,
                    mesh_force=force,
                    shown_force=force or USUAL_LINE_LOAD * pair.face_width,
                    line_load=abs(pinion_torque) / pair.working_radii[0] / pair.face_width,
                    backlash=pair.backlash,
                )
            )
        return tuple(stages)

    @property
    def load_torque(self) -> float:
        """Torque (N m) that resists the rotation of the loaded shaft."""
        return self.resisting_torques[self.loaded]

    @property
    def pinion_senses(self) -> tuple[int, ...]:
        """Lifting sense of every pinion, by stage."""
        return tuple(self.senses[pinion] for pinion, _ in self.pair_shafts)


def lay_out(scene: Scene, source: str = "scene") -> TrainLayout:
    """Gear pairs and axes of a scene; `source` names it in errors.

    Raises
    ------
    SceneError : lists all gears that do not mesh, or shafts that are not connected
    """
    steel = scene.gear_material.made(name="gear steel")
    pairs, flanks, problems = [], [], []
    pair_shafts = stage_shafts(scene.stages)
    senses = shaft_senses(len(scene.shafts), scene.stages, scene.couplings)
    for number, (stage, (pinion, _)) in enumerate(zip(scene.stages, pair_shafts, strict=True), 1):
        sense = senses[pinion]
        try:
            pairs.append(gear_pair(stage, steel, sense))
            flanks.append(modifications(stage, sense))
            check_modifications(pairs[-1], flanks[-1])
        except GeometryError as error:
            problems.append(Problem(f"stages.{number}", str(error)))
    if problems:
        raise SceneError(source, problems)
    places, problems = place_shafts(len(scene.shafts), scene.stages, pairs, scene.couplings)
    cycles, phases = mesh_cycles(scene.stages, pairs, senses)
    if problems := problems or phases:
        raise SceneError(source, problems)
    driven, loaded = (scene.drive.shaft or 1) - 1, (scene.load.shaft or len(scene.shafts)) - 1
    return TrainLayout(
        pairs=tuple(pairs),
        modifications=tuple(flanks),
        axes=tuple((place.x, place.z) for place in places),
        senses=tuple(senses),
        shaft_ratios=tuple(place.speed / places[driven].speed for place in places),
        pair_shafts=tuple(pair_shafts),
        cycles_at_start=tuple(cycles),
        coupling_shafts=tuple(
            (table.shafts[0] - 1, table.shafts[1] - 1) for table in scene.couplings if table.turns_both
        ),
        driven=driven,
        loaded=loaded,
        turns=scene.drive.highest_turns,
        motors=scene.drive.motor_places(scene.shafts[driven]),
        torques=tuple(_torques(scene, loaded)),
    )


def _torques(scene: Scene, loaded: int) -> Iterator[tuple[int, float, float]]:
    """Torques of the load and of external torques: shaft, y (m), torque (N m)."""
    places = scene.load.places(scene.shafts[loaded])
    for y in places:
        yield loaded, y, -scene.load.torque / len(places)
    for number, force in enumerate(scene.forces, 1):
        if force.model == "torque":
            yield force.shaft - 1, force.si.position, sum(force.spec(number).largest_torques(0.0).values())
