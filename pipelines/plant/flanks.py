"""Flanks of a scene in SI: modifications, misalignment, and damaged teeth with the numbers of their variants.

Scenes speak of the ends -y and +y of the global axis. The face coordinate of a mesh law points along the rotation of
the driving gear in lifting, so where its lifting sense is -1 the ends change places and slopes their sign.
"""

from __future__ import annotations

from fem.contact.faults.registry import tooth_fault
from fem.contact.faults.tooth_fault import ToothFault
from fem.gears.modifications import EndRelief, FlankModifications, Misalignment, PairModifications, Relief
from pipelines.plant.units import si_options
from pipelines.scene.scene import Scene
from pipelines.scene.tables.faults import FaultBase, FaultTable
from pipelines.scene.tables.gear_details import EndReliefTable, GearTable, ReliefTable
from pipelines.scene.tables.gears import StageTable
from pipelines.scene.train import shaft_senses, stage_shafts

GEARS = ("pinion", "wheel")


def lifting_sense(scene: Scene, stage: int) -> int:
    """Lifting sense of the pinion of a stage (from 1): +1 turns about +y."""
    pinion = stage_shafts(scene.stages)[stage - 1][0]
    return shaft_senses(len(scene.shafts), scene.stages, scene.couplings)[pinion]


def modifications(stage: StageTable, sense: int) -> PairModifications:
    """Modifications and misalignment of a stage in the face coordinate of its mesh law."""
    width = stage.face_width_mm / 1000
    return PairModifications(
        pinion=_gear_flanks(stage.pinion, sense),
        wheel=_gear_flanks(stage.wheel, sense),
        misalignment=Misalignment(
            in_plane=sense * stage.misalignment.in_plane_um / 1_000_000 / width,
            out_of_plane=sense * stage.misalignment.out_of_plane_um / 1_000_000 / width,
        ),
    )


def _gear_flanks(table: GearTable, sense: int) -> FlankModifications:
    low, high = table.end_relief_minus_y, table.end_relief_plus_y
    if sense < 0:
        low, high = high, low
    return FlankModifications(
        tip_relief=_relief(table.tip_relief),
        root_relief=_relief(table.root_relief),
        profile_crowning=table.profile_crowning_um / 1_000_000,
        lead_crowning=table.lead_crowning_um / 1_000_000,
        end_relief_low=_end_relief(low),
        end_relief_high=_end_relief(high),
        helix_slope=sense * table.helix_slope_um / 1_000_000,
    )


def _relief(table: ReliefTable | None) -> Relief | None:
    if table is None:
        return None
    return Relief(
        amount=table.amount_um / 1_000_000,
        length=None if table.length_mm is None else table.length_mm / 1000,
        diameter=None if table.diameter_mm is None else table.diameter_mm / 1000,
        shape=table.shape,
    )


def _end_relief(table: EndReliefTable | None) -> EndRelief | None:
    if table is None:
        return None
    return EndRelief(amount=table.amount_um / 1_000_000, length=table.length_mm / 1000, shape=table.shape)


def damage(fault: FaultTable, sense: int) -> ToothFault:
    """The fault in SI; its end of the face is that of the mesh law."""
    options = si_options(fault, without=FaultBase)
    if sense < 0 and "end" in options:
        options["end"] = {"-y": "+y", "+y": "-y"}[options["end"]]
    return tooth_fault(fault.kind, **options)


def damaged_teeth(scene: Scene, stage: int, gear: str) -> dict[int, tuple[ToothFault, ...]]:
    """Damage by tooth number of a gear of a stage (1-based); the n-th entry is variant n + 1 of its mesh law."""
    found: dict[int, tuple[ToothFault, ...]] = {}
    for fault in _faults_of(scene, stage, gear):
        one = damage(fault, lifting_sense(scene, stage))
        if fault.tooth is not None and one.changes_flank:
            found[fault.tooth] = (*found.get(fault.tooth, ()), one)
    return found


def common_wear(scene: Scene, stage: int, gear: str) -> tuple[ToothFault, ...]:
    """What all teeth of a gear of a stage (1-based) have."""
    sense = lifting_sense(scene, stage)
    return tuple(damage(fault, sense) for fault in _faults_of(scene, stage, gear) if fault.tooth is None)


def _faults_of(scene: Scene, stage: int, gear: str) -> list[FaultTable]:
    return [fault for fault in scene.faults if fault.stage == stage and fault.gear == gear]


def first_tooth_fault(scene: Scene, stage: int) -> FaultTable | None:
    """The fault that pictures of a stage (from 1) show: the first missing tooth, else the first of a single tooth."""
    single = [fault for fault in scene.faults if fault.stage == stage and fault.tooth is not None]
    return next((fault for fault in single if fault.kind == "missing-tooth"), single[0] if single else None)


def fault_name(fault: FaultTable) -> str:
    """Kind and tooth of a fault in words: "missing-tooth 0", "worn-tooth, all teeth"."""
    return f"{fault.kind}, all teeth" if fault.tooth is None else f"{fault.kind} {fault.tooth}"
