"""Warnings: what a designer would question in a scene that can be run."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fem.casing.parts.casing_choices import MODES_OVER_BAND
from mbd.parts.rolling_catalogue import bore_of
from pipelines.machine.bearing_loads import load_directions
from pipelines.machine.checks.collisions import FARTHEST_SENSOR
from pipelines.machine.checks.flank_checks import flank_warnings
from pipelines.machine.checks.strength import strength_warnings
from pipelines.machine.checks.window_checks import bad_windows
from pipelines.machine.layout import TrainLayout
from pipelines.machine.machine_model import Drivetrain
from pipelines.machine.scene_bearings import placed_bearings
from pipelines.machine.scene_casing import dimensions
from pipelines.machine.scene_kinematics import STRIKES, kinematics_of
from pipelines.scene.merge import leaves
from pipelines.scene.scene import Scene
from pipelines.scene.shaft_faults import shaft_faults
from pipelines.scene.validation_messages import other_unit
from pipelines.signals.features.unresolved_passes import unresolved_passes

LOAD_ZONE = math.pi / 2  # from the direction of a radial load, without clearance or preload
MISTAKEN = {  # keys whose values are often in another unit
    *("elastic_modulus_GPa", "density_kg_m3", "rope_modulus_GPa", "helix_angle_deg"),
    *("amount_um", "length_mm", "depth_mm", "in_plane_um", "out_of_plane_um"),
}
HARMONICS = 5  # of the fastest mesh that a good record holds


def design_warnings(scene: Scene, machine: Drivetrain, diagnosed: bool = True) -> tuple[str, ...]:
    """All warnings, in the order of the scene's tables; those of the diagnosis only if the run is `diagnosed`."""
    layout = machine.layout
    return (
        *_unusual(scene),
        *_mounts(scene),
        *_sensors(scene, layout),
        *_gears(scene, layout),
        *flank_warnings(scene, machine),
        *strength_warnings(scene, layout),
        *_fits(scene, layout),
        *spall_warnings(machine),
        *_drive(scene, layout),
        *_record(scene, layout),
        *(_diagnosis(scene, machine) if diagnosed else ()),
    )


def _unusual(scene: Scene) -> Iterator[str]:
    """Values that look as if they were in another unit."""
    for path, value in leaves(scene.model_dump()).items():
        if path[-1] in MISTAKEN and (remedy := other_unit(path[-1], value)):
            yield f"{'.'.join(path)} = {value:g}: an unusual value. {remedy.rstrip('.')}"


def _mounts(scene: Scene) -> Iterator[str]:
    if getattr(scene.casing, "ground", "") == "fixed" and "mounts_N_per_um" in scene.casing.model_fields_set:
        yield (
            'casing.mounts_N_per_um is ignored with casing.ground = "fixed". Set casing.ground = "springs", or delete '
            "casing.mounts_N_per_um"
        )


def _sensors(scene: Scene, layout: TrainLayout) -> Iterator[str]:
    """Sensors at one place, and deep inside a parametric housing, as are positions in another unit."""
    box = None if scene.parametric is None else 1000 * np.array(dimensions(scene.parametric, layout).box)
    names: dict[tuple, str] = {}
    for number, sensor in enumerate(scene.sensors, 1):
        place = f"sensors.{number}.position_mm"
        other = names.setdefault((*sensor.position_mm, *sensor.axes), sensor.name)
        if other != sensor.name:
            yield f"{place}: {sensor.name} is at the place of {other}, so their signals are equal. Correct one of them"
        if box is not None and (depth := np.abs(box - sensor.position_mm).min()) > FARTHEST_SENSOR:
            yield (
                f"{place}: {sensor.name} is {depth:.0f} mm inside the outer walls, and measures at the nearest point "
                "of the surface. Correct the position, in mm"
            )


def _gears(scene: Scene, layout: TrainLayout) -> Iterator[str]:
    for number, (stage, pair, facts) in enumerate(zip(scene.stages, layout.pairs, layout.stages, strict=True), 1):
        place = f"stages.{number}"
        if facts.transverse_contact_ratio < 1.2:
            yield (
                f"{place}: the transverse contact ratio {facts.transverse_contact_ratio:.3f} is below 1.2. Raise the "
                "numbers "
                "of teeth or rack_addendum"
            )
        nearest = round(facts.overlap_ratio)
        if nearest >= 1 and abs(facts.overlap_ratio - nearest) < 0.05:
            yield (
                f"{place}: the overlap ratio {facts.overlap_ratio:.3f} is almost a whole number, so that the mesh "
                "excitation almost vanishes. This reduces noise, but hides faults; to see them correct face_width_mm "
                "or "
                "helix_angle_deg"
            )
        if stage.face_width_mm > 1.2 * pair.pinion.reference_radius * 2000:
            yield (
                f"{place}: face_width_mm = {stage.face_width_mm:g} is above 1.2 pinion diameters, so that the load is "
                "unevenly distributed over the face. Reduce it, or raise module_mm"
            )
        divisor = math.gcd(stage.pinion_teeth, stage.wheel_teeth)
        if divisor > 5:
            yield (
                f"{place}: {stage.pinion_teeth} and {stage.wheel_teeth} teeth have the common divisor {divisor}, so "
                "that "
                "the same teeth meet often and wear unevenly. Set numbers of teeth without a common divisor"
            )
        if facts.backlash < 0.02e-3 and layout.load_torque != 0.0:
            yield (
                f"{place}: the backlash of {facts.backlash * 1e6:.1f} um is small: with deviations both flanks may be "
                "in "
                "contact. Raise backlash_um"
            )


def _fits(scene: Scene, layout: TrainLayout) -> Iterator[str]:
    """Shafts that are thicker than the bore of a bearing or gear on them."""
    for one in placed_bearings(scene):
        table, on = one.table, scene.shafts[one.shaft]
        if table.model == "hertz" and table.designation is not None:
            y, bore = on.bearing_positions_mm[one.place], 1000 * bore_of(table.designation)
            # at a shoulder the bearing is on the thinner side
            sections = [(n, s) for n, s in enumerate(on.sections, 1) if s.start_mm <= y <= s.end_mm]
            number, section = min(sections, key=lambda found: found[1].diameter_mm)
            if section.diameter_mm > bore:
                yield (
                    f"shafts.{one.shaft + 1}.sections.{number}.diameter_mm = {section.diameter_mm:g}: the bore of "
                    f"bearing {one.place + 1} on it, {table.designation}, is {bore:g} mm (ISO 15); "
                    "reduce the diameter, or take a larger bearing"
                )
    for stage_number, (stage, pair, places) in enumerate(
        zip(scene.stages, layout.pairs, layout.pair_shafts, strict=True), 1
    ):
        low, high = stage.position_mm - stage.face_width_mm / 2, stage.position_mm + stage.face_width_mm / 2
        for name, shaft in zip(("pinion", "wheel"), places, strict=True):
            bore = 2000 * getattr(pair, name).bore_radius
            for number, section in enumerate(scene.shafts[shaft].sections, 1):
                if section.start_mm < high and section.end_mm > low and section.diameter_mm > bore * (1 + 1e-9):
                    yield (
                        f"shafts.{shaft + 1}.sections.{number}.diameter_mm = {section.diameter_mm:g}: the bore of the "
                        f"gear on it is {bore:g} mm; reduce the diameter, or set stages.{stage_number}.{name}_bore_mm "
                        f"= {section.diameter_mm:g}"
                    )


def spall_warnings(machine: Drivetrain) -> Iterator[str]:
    """Spalls of outer rings where no element is pressed against the ring."""
    directions = load_directions(machine)
    for fault in machine.spalls:
        load = directions[fault.bearing]
        if load is None or fault.spall.on != "outer-ring":
            continue
        if abs(math.remainder(fault.spall.angle - load, 2 * math.pi)) > LOAD_ZONE:
            yield (
                f"faults: the {fault.name} at angle_deg = {math.degrees(fault.spall.angle):.4g} is outside the load "
                f"zone: the load presses the elements against the ring around {math.degrees(load):.0f} deg, so that "
                f"the spall may have no effect. Set angle_deg = {math.degrees(load):.0f}"
            )


def _drive(scene: Scene, layout: TrainLayout) -> Iterator[str]:
    """Motors of a torque that the largest load overcomes at their greatest."""
    motors = scene.drive.torque_sources("", layout.motors)
    given, needed = sum(abs(motor.largest) for motor in motors), layout.input_torque
    if motors and given < needed:
        yield (
            f"drive: the motors give at most {given:.4g} N m, and the load takes {needed:.4g} N m at their shaft. "
            "Unless the load falls with the speed, it drives the machine backwards. Reduce the load, or set a stronger "
            "motor"
        )


def _record(scene: Scene, layout: TrainLayout) -> Iterator[str]:
    interval = 1e6 / scene.simulation.output_rate_Hz
    if scene.simulation.step_us > interval + 1e-6:
        yield (
            f"simulation.step_us = {scene.simulation.step_us:g} is above the sampling interval, so that the time step "
            f"is {interval:.6g} us. Set {interval:.6g} or less, or reduce simulation.output_rate_Hz"
        )
    band, highest = getattr(scene.casing, "band_Hz", None), scene.simulation.output_rate_Hz / 2
    if band is not None and highest > MODES_OVER_BAND * band:
        imported = getattr(scene.housing, "model", None) == "matrices"
        yield (
            f"casing.band_Hz = {band:g} keeps modes of the casing to {MODES_OVER_BAND * band:g} Hz, and the signals "
            f"reach {highest:g} Hz: levels above the band are those of a casing without modes there. Raise "
            f"casing.band_Hz to {math.ceil(highest / MODES_OVER_BAND)}"
            f"{' if the matrices have all modes of the casing to there' if imported else ''}, or reduce "
            "simulation.output_rate_Hz"
        )
    for number, facts in enumerate(layout.stages, 1):
        if scene.simulation.output_rate_Hz < 2 * HARMONICS * facts.mesh_frequency:
            yield (
                f"simulation.output_rate_Hz = {scene.simulation.output_rate_Hz:g} covers fewer than {HARMONICS} "
                f"harmonics of the mesh frequency of stage {number}, {facts.mesh_frequency:.1f} Hz. Raise it to "
                f"{4 * HARMONICS * facts.mesh_frequency:.0f}"
            )
    yield from load_warnings(scene, layout)


def load_warnings(scene: Scene, layout: TrainLayout) -> Iterator[str]:
    """A machine without load, whose gears rattle."""
    if not any(layout.resisting_torques):
        key, remedy = scene.load.without_load
        yield f"{key}: without load the teeth lose contact and rattle in their backlash. {remedy}"


def _diagnosis(scene: Scene, machine: Drivetrain) -> Iterator[str]:
    looked_at, on_teeth = (scene.diagnosis.stage, scene.diagnosis.gear), scene.tooth_faults.values()
    if on_teeth and scene.diagnosis.windows_s and looked_at not in {(f.stage, f.gear) for f in on_teeth}:
        yield (
            f"diagnosis: the stage {looked_at[0]} {looked_at[1]} is diagnosed, but has no fault. Set diagnosis.stage "
            "and "
            "diagnosis.gear to the faulty gear"
        )
    if machine.spalls and scene.diagnosis.windows_s and machine.layout.turns:
        longest = max(end - start for start, end in scene.diagnosis.windows_s.values())
        kinematics, speed = (
            kinematics_of(machine.layout, machine.rolling),
            machine.layout.turns * abs(machine.layout.shaft_ratios[0]),
        )
        reasons = unresolved_passes(kinematics, speed, longest, scene.simulation.output_rate_Hz)
        for one in machine.spalls:
            if reason := reasons.get(f"{one.bearing} {STRIKES[one.spall.on]}"):
                yield f"diagnosis.windows_s: the pass order of the {one.name} is not examined: {reason}"
    faulty = bool(scene.faults or shaft_faults(scene))
    if faulty and scene.control is None:
        for problem in bad_windows(scene, machine):
            yield f"{problem}"
    if faulty and not (scene.control and scene.diagnosis.windows_s):
        lacking, remedy = (
            ("has no control", 'Set control = "without-faults"')
            if not scene.control
            else (
                f"has no window in diagnosis.windows_s that ends by simulation.end_s = {scene.simulation.end_s:g}",
                "Set such a window, or raise simulation.end_s",
            )
        )
        yield f"the run has signals but no diagnosis, because the scene {lacking}. {remedy}"
