"""Checks and warnings of gears, modifications, deviations and faults that need no computation of a mesh law."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fem.gears.deviations import GRADES, pitch_tolerance
from fem.gears.flank_deviations import flank_tolerance
from fem.gears.gear_checks import GeometryError
from fem.gears.prescribed import check_prescribed
from pipelines.io.errors import Problem, Problems
from pipelines.machine.layout import TrainLayout
from pipelines.machine.machine_model import Drivetrain
from pipelines.machine.scene_flanks import GEARS, Fault
from pipelines.scene.presets import most_slices
from pipelines.scene.scene import Scene

THIN_TIP = 0.2  # modules; the usual least tip thickness of through-hardened teeth
LEAST_POSITIONS = 64  # grid points per base pitch of models without such a key
TYPICAL_STIFFNESS = 18e9  # N/m2: c_gamma of steel pairs, for orders of magnitude only


def bad_flanks(scene: Scene, train: Drivetrain) -> list[Problem]:
    """Faults that do not fit on their teeth, and deviations that are not possible or are outside ISO 1328-1."""
    pairs, problems = train.layout.pairs, Problems(GeometryError)
    for number, fault in zip(scene.tooth_faults, train.faults, strict=True):
        problems.made(f"faults.{number}", fault.damage.check, getattr(pairs[fault.stage - 1], fault.gear))
    if not scene.deviations.enabled:
        return problems
    for number, (stage, mesh) in enumerate(zip(scene.stages, train.parts.meshes, strict=True), 1):
        for name in GEARS:
            gear, given = getattr(mesh.pair, name), getattr(mesh, name).prescribed
            if given is not None:
                positions = getattr(stage.mesh, "positions", LEAST_POSITIONS)
                problems.made(f"stages.{number}.{name}.deviations", check_prescribed, gear, given, positions)
            try:
                pitch_tolerance(gear, scene.deviations.iso_grade)
                if set(scene.deviations.include) & {"profile", "helix"}:
                    flank_tolerance(gear, scene.deviations.iso_grade)
            except GeometryError as error:
                remedy = "Set deviations.enabled = false, or delete items of deviations.include."
                problems.append(Problem(f"stages.{number}", f"{name}: {error}", remedy))
    return problems


def _prescribed_warnings(scene: Scene, layout: TrainLayout) -> Iterator[str]:
    """Warnings of prescribed deviations that are disabled, and of run-out beyond the coarsest tolerance class."""
    for number, (stage, pair) in enumerate(zip(scene.stages, layout.pairs, strict=True), 1):
        for name in GEARS:
            table, place = getattr(stage, name).deviations, f"stages.{number}.{name}.deviations"
            if table.none:
                continue
            if not scene.deviations.enabled:
                yield (
                    f"{place}: these keys have no effect, because deviations.enabled = false. Set deviations.enabled = "
                    "true, and deviations.include = [] for no further deviations"
                )
                continue
            try:
                runout = 1e6 * pitch_tolerance(getattr(pair, name), GRADES[-1]).runout
            except GeometryError:
                continue  # no tolerances for a gear of that size
            if 2 * table.eccentricity_um > runout:
                yield (
                    f"{place}.eccentricity_um = {table.eccentricity_um:g}: the run-out of "
                    f"{2 * table.eccentricity_um:g} "
                    f"um is more than class {GRADES[-1]} of ISO 1328-1 allows, {runout:.0f} um. Correct it if the unit "
                    "is wrong"
                )


def flank_warnings(scene: Scene, train: Drivetrain) -> Iterator[str]:
    """Warnings of unusual gear design, and of settings that hide a fault."""
    layout = train.layout
    yield from _prescribed_warnings(scene, layout)
    for number, (spec, pair, modification) in enumerate(
        zip(train.laws, layout.pairs, layout.modifications, strict=True), 1
    ):
        place = f"stages.{number}"
        for name, short in zip(GEARS, pair.shortened_by_undercut, strict=True):
            gear = getattr(pair, name)
            if short:
                yield (
                    f"{place}: the {name} (z {gear.teeth}, x {gear.profile_shift:g}) is undercut and has lost part of "
                    f"its involute; the contact ratio eps_alpha is {pair.transverse_contact_ratio:.3f}. Raise "
                    f"{name}_profile_shift"
                )
            if gear.tip_thickness < THIN_TIP * gear.normal_module:
                yield (
                    f"{place}: the {name} is almost pointed: its tip is {gear.tip_thickness * 1000:.3f} mm thick "
                    f"({gear.tip_thickness / gear.normal_module:.2f} m_n, usual is at least {THIN_TIP} m_n). Reduce "
                    f"{name}_profile_shift"
                )
            if gear.web_offset and not spec.mesh.places_webs:
                yield (
                    f"{place}.{name}.web_offset_mm: has no effect in this mesh model, which considers only the "
                    f'thickness of a web. Set {place}.mesh.model = "solid"'
                )
        yield from (f"{place}: {text}" for text in spec.mesh.warnings(modification))
    for number, fault in zip(scene.tooth_faults, train.faults, strict=True):
        stage, pair = scene.stages[fault.stage - 1], layout.pairs[fault.stage - 1]
        width = pair.face_width / stage.mesh.slices
        name, fine = ("length", 10) if fault.kind == "spalled-tooth" else ("extent", 4)  # slices over the damage
        extent, key = getattr(fault.damage, name, None), f"{name}_mm"
        if extent is not None and extent < 2 * width:
            yield (
                f"faults.{number}: {key} = {1000 * extent:g} is resolved coarsely by slices of {width * 1000:.2f} mm. "
                + _finer(fault.stage, stage.mesh.slices, fine * pair.face_width / extent, key)
            )
        yield from _hidden(scene, layout, number, fault)


def _finer(stage: int, slices: int, needed: float, key: str) -> str:
    """Remedy for a fault that is small compared with the slices of a mesh."""
    if slices >= (most := most_slices()):
        return f"Raise {key}, or reduce face_width_mm"
    limit = f"{most}, the most that a mesh has" if needed > most else f"{math.ceil(needed - 1e-9)}"
    return f"Raise stages.{stage}.mesh.slices to {limit}"


def _hidden(scene: Scene, layout: TrainLayout, number: int, fault: Fault) -> Iterator[str]:
    """Warning of a fault whose change of the transmission error is small compared with the single pitch tolerance.

    The change is estimated only for faults for which it follows from their size.
    """
    if not scene.deviations.enabled:
        return
    pair = layout.pairs[fault.stage - 1]
    approach = layout.stages[fault.stage - 1].mesh_force / pair.face_width / TYPICAL_STIFFNESS
    change = fault.damage.movement(pair, approach, alone=fault.tooth is not None)
    if change is None:
        return
    tolerance = pitch_tolerance(getattr(pair, fault.gear), scene.deviations.iso_grade).single
    if change < tolerance:
        basis = "estimate from extent_mm, for any depth_mm" if fault.kind == "chipped-tooth" else "estimate"
        yield (
            f"faults.{number}: the {fault.kind.replace('-', ' ')} changes the transmission error by up to "
            f"{abs(change) * 1e6:.3g} um ({basis}); pitch deviations of class "
            f"{scene.deviations.iso_grade} change it by up to {tolerance * 1e6:.3g} um and may hide the fault. "
            "Raise the load, or reduce deviations.iso_grade"
        )
