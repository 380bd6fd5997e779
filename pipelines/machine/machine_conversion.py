"""Conversion of a scene into the machine model in SI: shafts, gears, bearings, meshes, drive, load, losses and casing.

Every part is made once. Its errors are collected, so that all problems of a scene are listed at once.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from fem.casing.geometry.dimensions import HousingError
from fem.contact.models.mesh_model import LawSpec
from fem.contact.models.mesh_model_registry import loaded_model
from fem.contact.slice_frame import ModelError
from fem.gears.gear import Gear
from fem.gears.gear_checks import GeometryError
from fem.gears.geometry import GearPair
from mbd.parts.channels import further_channels
from mbd.parts.losses import Brake
from mbd.parts.oil_film import Film
from mbd.parts.part_checks import MachineError
from mbd.parts.shafts import Disk, ShaftSpec
from pipelines.io.errors import InputError, Problems
from pipelines.machine.layout import TrainLayout, lay_out
from pipelines.machine.machine_model import Drivetrain, MachineModel, labels
from pipelines.machine.machine_parts import GearMesh, GearTeeth, MachineParts, Recorded
from pipelines.machine.scene_bearings import bearing_faults, bearing_points, bearing_specs, rolling_bearings
from pipelines.machine.scene_casing import casing
from pipelines.machine.scene_flanks import GEARS, Fault, damaged_teeth, flanks_spec, prescribed_deviations, tooth_faults
from pipelines.scene.scene import Scene
from pipelines.scene.shaft_faults import shaft_faults
from pipelines.scene.tables.losses import FilmModel

REFUSALS = (MachineError, GeometryError, ModelError, HousingError, InputError)


def make_machine(scene: Scene, source: str = "scene") -> MachineModel:
    """The machine model of a scene, without the further checks of `checked_machine`.

    Raises
    ------
    SceneError : lists all errors of the parts; `source` is the name of the scene in the message
    """
    problems = Problems(*REFUSALS)
    machine = in_casing(drivetrain(scene, lay_out(scene, source), problems), scene, problems)
    if machine is None:
        raise problems.error(source)
    return machine


def make_drivetrain(scene: Scene, source: str = "scene") -> Drivetrain:
    """The machine model of a scene without its casing; SceneError as for `make_machine`."""
    problems = Problems(*REFUSALS)
    train = drivetrain(scene, lay_out(scene, source), problems)
    if problems:
        raise problems.error(source)
    return train


def in_casing(train: Drivetrain, scene: Scene, problems: Problems) -> MachineModel | None:
    """The drivetrain in its casing; None if there are problems.

    Parameters
    ----------
    train, scene : the drivetrain, and the scene that it was made from
    problems : problems of the drivetrain; collects errors of its mesh laws and its casing
    """
    made = problems.made("casing.housing", casing, scene, train.layout, train.parts)
    for number, spec in enumerate(train.laws, 1):
        problems.made(f"stages.{number}.mesh", _check_law, spec)
    return None if problems else MachineModel(**vars(train), casing=made[0], structure=made[1])


def drivetrain(scene: Scene, layout: TrainLayout, problems: Problems) -> Drivetrain:
    """The machine model without its casing; `problems` collects errors of its parts. With errors it is not complete."""
    faults = tooth_faults(scene.tooth_faults.values(), layout.pinion_senses)
    return Drivetrain(
        title=scene.title,
        labels=labels(scene),
        models=scene.models(),
        layout=layout,
        laws=tuple(  # without modifications and damage of the flanks
            LawSpec(pair=replace(pair, backlash_allowance=0.0), mesh=loaded_model(stage.mesh.made(), facts.line_load))
            for stage, pair, facts in zip(scene.stages, layout.pairs, layout.stages, strict=True)
        ),
        flanks=tuple(
            flanks_spec(pair, modifications, faults, number)
            for number, (pair, modifications) in enumerate(zip(layout.pairs, layout.modifications, strict=True), 1)
        ),
        parts=machine_parts(scene, layout, faults, problems),
        hoist=scene.load.suspended,
        rolling=() if problems else rolling_bearings(scene),
        faults=faults,
        spalls=tuple(bearing_faults(scene).values()),
        shaft_faults=shaft_faults(scene),
        bearing_points=bearing_points(scene, layout),
        casing_modes=scene.casing.made_of.added_modes,
        recorded=Recorded(
            sensors=tuple(sensor.name for sensor in scene.sensors),
            journals=scene.housing is None,
        ),
        motion=scene.simulation.made(),
        monitored=scene.diagnosis.made(
            sensor=scene.diagnosis.sensor or (scene.sensors[0].name if scene.sensors else ""),
            windows=dict(scene.diagnosis.windows_s),
            possible=bool(scene.diagnosis.windows_s and scene.sensors),
            speed_is_known=scene.drive.speed_is_known,
        ),
    )


@functools.lru_cache(maxsize=64)
def _check_law(spec: LawSpec) -> None:
    """ModelError or GeometryError if the settings or the path of contact do not allow a mesh law."""
    spec.mesh.check(spec.pair)


def gear_disk(name: str, y: float, gear: Gear, density: float) -> Disk:
    """The gear body from its bore to its reference circle as a rigid hollow cylinder.

    J_p = m (R^2 + r^2)/2 is the polar, J_d = m (3 (R^2 + r^2) + b^2)/12 the diametral moment of inertia.

    Parameters
    ----------
    name : of the disk
    y : m, place on the shaft
    gear : the gear
    density : kg/m3
    """
    inner, outer, width = gear.bore_radius, gear.reference_radius, gear.face_width
    mass = density * math.pi * (outer**2 - inner**2) * width
    square = outer**2 + inner**2
    return Disk(
        name=name,
        y=y,
        mass=mass,
        polar_inertia=mass * square / 2,
        diametral_inertia=mass * (3 * square + width**2) / 12,
    )


def _disks(scene: Scene, layout: TrainLayout, shaft: int) -> list[Disk]:
    density = scene.gear_material.density_kg_m3
    found: list[Disk] = []
    for number, (stage, pair) in enumerate(zip(scene.stages, layout.pairs, strict=True)):
        y = stage.si.position
        for name, gear, place in zip(
            ("pinion", "wheel"), (pair.pinion, pair.wheel), layout.pair_shafts[number], strict=True
        ):
            if place == shaft and y not in {disk.y for disk in found}:  # one gear may be in two stages
                found.append(gear_disk(f"{name}_{number + 1}", y, gear, density))
    found += [table.made(name=f"disk_{n}") for n, table in enumerate(scene.disks, 1) if table.shaft == shaft + 1]
    hoist = scene.load.suspended
    if shaft == layout.loaded and hoist is not None:
        found += [  # a drum is a thin shell: diametral inertia half the polar one, its length neglected
            Disk(
                name=f"drum_{number}",
                y=y,
                mass=hoist.drum_mass,
                polar_inertia=hoist.drum_inertia,
                diametral_inertia=min(hoist.drum_inertia, hoist.drum_mass * hoist.drum_radius**2) / 2,
            )
            for number, y in enumerate(scene.load.places(scene.shafts[shaft]), 1)
        ]
    return found


def shaft_specs(scene: Scene, layout: TrainLayout) -> tuple[ShaftSpec, ...]:
    """All shafts; in lifting, shaft 1 rotates about +y and the shafts that mesh with it about -y."""
    steel = scene.gear_material
    return tuple(
        scene.shaft_model.made_part(
            ShaftSpec,
            name=f"shaft_{number + 1}",
            x=x,
            z=z,
            sense=layout.senses[number],
            sections=tuple(section.made() for section in table.sections),
            disks=tuple(_disks(scene, layout, number)),
            elastic_modulus=steel.si.elastic_modulus,
            poisson_ratio=steel.poisson_ratio,
            density=steel.density_kg_m3,
        )
        for number, (table, (x, z)) in enumerate(zip(scene.shafts, layout.axes, strict=True))
    )


def gear_teeth(
    scene: Scene, faults: Sequence[Fault], problems: Problems, stage: int, gear: str, sense: int
) -> GearTeeth:
    """The teeth of one gear. If sampled deviations are disabled, prescribed ones are disabled, too.

    Parameters
    ----------
    scene, faults : the scene, and the faults of all stages
    problems : collects errors of files of measured flanks
    stage, gear : number of the stage, from 1, and "pinion" or "wheel"
    sense : lifting sense of the pinion
    """
    table, deviations = scene.deviations, None
    prescribed = problems.made(f"stages.{stage}", prescribed_deviations, scene.stages[stage - 1], stage, gear, sense)
    if table.enabled and table.include:
        seed = 1000 * table.seed + 2 * (stage - 1) + GEARS.index(gear)  # a separate sequence for each gear
        deviations = table.made(seed=seed)
    own = [fault for fault in faults if fault.stage == stage and fault.gear == gear]
    return GearTeeth(
        deviations=deviations,
        prescribed=prescribed if table.enabled else None,
        clearances=tuple((f.tooth, f.damage.clearance) for f in own if f.tooth is not None and f.damage.clearance),
        damaged=tuple(damaged_teeth(own, stage, gear)),
    )


def gear_meshes(scene: Scene, layout: TrainLayout, faults: Sequence[Fault], problems: Problems) -> tuple[GearMesh, ...]:
    """All gear meshes.

    Parameters
    ----------
    scene, layout : the scene, and its layout
    faults : of the teeth
    problems : collects errors of files of measured flanks
    """
    return tuple(
        GearMesh(
            name=f"mesh_{number}",
            driving=f"shaft_{driving + 1}",
            driven=f"shaft_{driven + 1}",
            y=stage.si.position,
            pair=pair,
            pinion=gear_teeth(scene, faults, problems, number, "pinion", sense),
            wheel=gear_teeth(scene, faults, problems, number, "wheel", sense),
            damping_time=stage.si.mesh_damping_time,
            cycle_at_start=layout.cycles_at_start[number - 1],
            film=film_spec(scene.film, pair),
        )
        for number, (stage, pair, (driving, driven), sense) in enumerate(
            zip(scene.stages, layout.pairs, layout.pair_shafts, layout.pinion_senses, strict=True), 1
        )
    )


def film_spec(table: FilmModel, pair: GearPair) -> Film | None:
    """The oil film between the flanks of a pair, with the relative curvature radius at the pitch point and the mean
    length of the contact lines."""
    slope = math.tan(pair.working_pressure_angle)
    pinion, wheel = pair.pinion.base_radius * slope, pair.wheel.base_radius * slope
    lead = math.cos(pair.base_helix_angle)
    return table.made(
        radius=pinion * wheel / (pinion + wheel) / lead,
        length=pair.transverse_contact_ratio * pair.face_width / lead,
    )


def machine_parts(scene: Scene, layout: TrainLayout, faults: Sequence[Fault], problems: Problems) -> MachineParts:
    """All parts of the machine of a scene.

    Parameters
    ----------
    scene, layout : the scene, and its layout
    faults : of the teeth
    problems : collects errors of the parts; with errors, the parts are not complete
    """
    drive, driven, loaded = scene.drive, f"shaft_{layout.driven + 1}", f"shaft_{layout.loaded + 1}"
    ends = layout.motors
    places = scene.load.places(scene.shafts[layout.loaded])
    profile, load = (
        problems.made("drive", drive.profile),
        problems.made("load", scene.load.hanging_load, loaded, places),
    )
    if load is not None and profile is not None and drive.speed_is_known:
        problems.made("load", load.check_run, profile, layout.shaft_ratios[layout.loaded], scene.simulation.end_s)
    bearings = bearing_specs(scene, problems)
    return MachineParts(
        shafts=problems.made("shafts", shaft_specs, scene, layout) or (),
        bearings=bearings,
        meshes=gear_meshes(scene, layout, faults, problems),
        couplings=drive.couplings(driven, ends),
        input_shaft=driven,
        profile=profile,
        load=load,
        shaft_couplings=problems.each(
            "couplings", (partial(table.spec, n) for n, table in enumerate(scene.couplings, 1))
        ),
        forces=(
            *(problems.made("drive", drive.torque_sources, driven, ends) or ()),
            *(problems.made("load", scene.load.torque_sources, loaded, places) or ()),
            *problems.each("forces", (partial(table.spec, n) for n, table in enumerate(scene.forces, 1))),
            *(force for number, table in enumerate(scene.disks, 1) for force in table.unbalances(number)),
        ),
        losses=scene.losses.made(),
        brake=Brake(shaft=driven, y=ends[0], torque=drive.brake_torque) if drive.brake_torque else None,
        gyroscopic=scene.shaft_model.gyroscopic,
        probes=(
            *(table.made(shaft=f"shaft_{table.shaft}") for table in scene.probes),
            *further_channels(scene.simulation.channels, bearings=bearings),
        ),
    )
