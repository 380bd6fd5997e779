"""Flanks of a scene in SI: modifications, misalignment, and damaged teeth with the numbers of their variants.

In scenes, the ends of the face are -y and +y of the global axis. The face coordinate of a mesh law is positive along
the rotation vector of the pinion in lifting. For a lifting sense of -1 the ends are therefore exchanged, and slopes
change their sign.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from fem.contact.faults.tooth_fault import ToothFault
from fem.gears.geometry import GearPair
from fem.gears.modifications import FlankModifications, Misalignment, PairModifications
from fem.gears.prescribed import PrescribedDeviations
from pipelines.machine.flanks_spec import FlanksSpec
from pipelines.scene.tables.faults import FaultTable
from pipelines.scene.tables.gears import GearTable
from pipelines.scene.tables.stages import StageTable

GEARS = ("pinion", "wheel")


@dataclass(frozen=True, kw_only=True)
class Fault:
    """A fault of a gear of a stage (from 1) on one tooth, or on all teeth if `tooth` is None."""

    stage: int
    gear: str
    tooth: int | None
    kind: str
    damage: ToothFault

    @property
    def name(self) -> str:
        """Kind and tooth, such as "missing-tooth 0" or "worn-tooth, all teeth"."""
        return f"{self.kind}, all teeth" if self.tooth is None else f"{self.kind} {self.tooth}"


def flanks_spec(pair: GearPair, modifications: PairModifications, faults: Sequence[Fault], stage: int) -> FlanksSpec:
    """Modifications, damage and wear of a stage, without backlash, on which no mesh law depends.

    Parameters
    ----------
    pair, modifications : the gears of the stage and the modifications of their flanks
    faults : of all stages
    stage : number of the stage, from 1
    """
    return FlanksSpec(
        pair=replace(pair, backlash_allowance=0.0),
        modifications=modifications,
        pinion_damage=tuple(damaged_teeth(faults, stage, "pinion").values()),
        wheel_damage=tuple(damaged_teeth(faults, stage, "wheel").values()),
        pinion_wear=common_wear(faults, stage, "pinion"),
        wheel_wear=common_wear(faults, stage, "wheel"),
    )


def modifications(stage: StageTable, sense: int) -> PairModifications:
    """Modifications and misalignment of a stage in the face coordinate of its mesh law."""
    width = stage.si.face_width
    return PairModifications(
        pinion=_gear_flanks(stage.pinion, sense),
        wheel=_gear_flanks(stage.wheel, sense),
        misalignment=Misalignment(
            in_plane=sense * stage.misalignment.si.in_plane / width,
            out_of_plane=sense * stage.misalignment.si.out_of_plane / width,
        ),
    )


def _gear_flanks(table: GearTable, sense: int) -> FlankModifications:
    made: FlankModifications = table.made_part(FlankModifications)
    return made if sense > 0 else made.turned


def prescribed_deviations(stage: StageTable, number: int, gear: str, sense: int) -> PrescribedDeviations | None:
    """The prescribed deviations of a gear in the face coordinate of its mesh law; None if there are none.

    Parameters
    ----------
    stage, number : the table of the stage and its number, from 1
    gear : "pinion" or "wheel"
    sense : lifting sense of the pinion

    Raises
    ------
    SceneError : a file of measured flanks that cannot be used
    """
    table = getattr(stage, gear).deviations
    if table.none:
        return None
    measured = None
    if table.flanks is not None:
        from pipelines.scene.measured_flanks import measured_flanks

        measured = measured_flanks(table.flanks.file, f"stages.{number}.{gear}.deviations.flanks", sense)
    return PrescribedDeviations(
        eccentricity=table.made(),
        waves=tuple(wave.made() for wave in table.waves),
        teeth=tuple(error.made() for error in table.teeth),
        measured=measured,
    )


def tooth_faults(tables: Iterable[FaultTable], senses: Sequence[int]) -> tuple[Fault, ...]:
    """All faults; `senses` are the lifting senses of the pinions, by stage."""
    return tuple(
        Fault(
            stage=table.stage,
            gear=table.gear,
            tooth=table.tooth,
            kind=table.kind,
            damage=damage(table, senses[table.stage - 1]),
        )
        for table in tables
    )


def damage(fault: FaultTable, sense: int) -> ToothFault:
    """The fault in SI, with its end or position in the face coordinate of the mesh law."""
    found: ToothFault = fault.made()
    turned: dict[str, Any] = {}
    if sense < 0 and hasattr(found, "end"):
        turned["end"] = {"-y": "+y", "+y": "-y"}[found.end]
    if sense < 0 and hasattr(found, "position"):
        turned["position"] = -found.position
    return replace(found, **turned)


def damaged_teeth(faults: Iterable[Fault], stage: int, gear: str) -> dict[int, tuple[ToothFault, ...]]:
    """Damage by tooth number of a gear of a stage (1-based); the n-th entry is variant n + 1 of its mesh law."""
    found: dict[int, tuple[ToothFault, ...]] = {}
    for fault in faults:
        if fault.stage == stage and fault.gear == gear and fault.tooth is not None and fault.damage.changes_flank:
            found[fault.tooth] = (*found.get(fault.tooth, ()), fault.damage)
    return found


def common_wear(faults: Iterable[Fault], stage: int, gear: str) -> tuple[ToothFault, ...]:
    """Faults that all teeth of a gear of a stage (from 1) have."""
    return tuple(fault.damage for fault in faults if (fault.stage, fault.gear, fault.tooth) == (stage, gear, None))


def first_tooth_fault(faults: Iterable[Fault], stage: int) -> Fault | None:
    """The fault that pictures of a stage (from 1) show: the first missing tooth, else the first of a single tooth."""
    single = [fault for fault in faults if fault.stage == stage and fault.tooth is not None]
    return next((fault for fault in single if fault.kind == "missing-tooth"), single[0] if single else None)
