"""The multibody description of a scene: shafts with gear bodies, bearings, meshes, drive and load, in SI."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.contact.law import MeshLaw
from fem.gears.geometry import Gear
from mbd.bearings import BearingSpec, hertz_bearing, rigid_bearing
from mbd.couplings import ShaftCoupling
from mbd.drive import CouplingSpec, SpeedProfile
from mbd.gear_mesh import MeshSpec
from mbd.load import Load, Rope, StaticTorque
from mbd.machine import Machine
from mbd.shafts import Disk, Section, ShaftSpec
from pipelines.derived import bearing_names, output_torque
from pipelines.layout import Layout
from pipelines.scene import Scene
from pipelines.tables.bearings import HertzBearings, LinearBearings, RigidBearings
from pipelines.tables.motion import RopeTable


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshInput:
    """What one stage brings to the machine: its laws and the clearances (tooth,) of both gears on both flanks (m)."""

    drive: MeshLaw
    coast: MeshLaw
    drive_clearance_pinion: np.ndarray
    drive_clearance_wheel: np.ndarray
    coast_clearance_pinion: np.ndarray
    coast_clearance_wheel: np.ndarray


def annulus(name: str, y: float, inner: float, outer: float, width: float, density: float) -> Disk:
    """A ring of rectangular section as a rigid disk: m, J = m (R^2 + r^2)/2 and m (3 (R^2 + r^2) + b^2)/12."""
    mass = density * math.pi * (outer**2 - inner**2) * width
    square = outer**2 + inner**2
    return Disk(
        name=name,
        y=y,
        mass=mass,
        polar_inertia=mass * square / 2,
        diametral_inertia=mass * (3 * square + width**2) / 12,
    )


def gear_disk(name: str, y: float, gear: Gear, density: float) -> Disk:
    """The gear body from its bore to its reference circle."""
    return annulus(name, y, gear.bore_radius, gear.reference_radius, gear.face_width, density)


def _disks(scene: Scene, layout: Layout, shaft: int) -> list[Disk]:
    density = scene.gear_material.density_kg_m3
    found = []
    for number, (stage, pair) in enumerate(zip(scene.stages, layout.pairs, strict=True)):
        y = stage.position_mm / 1000
        for name, gear, place in zip(("pinion", "wheel"), (pair.pinion, pair.wheel), layout.pair_shafts[number], strict=True):
            if place == shaft:
                found.append(gear_disk(f"{name}_{number + 1}", y, gear, density))
    for number, table in enumerate(scene.disks, 1):
        if table.shaft == shaft + 1:
            found.append(
                Disk(
                    name=f"disk_{number}",
                    y=table.position_mm / 1000,
                    mass=table.mass_kg,
                    polar_inertia=table.polar_inertia_kg_m2,
                    diametral_inertia=table.diametral_inertia_kg_m2,
                )
            )
    if shaft == layout.loaded:
        load = scene.load
        radius = load.drum_radius_mm / 1000
        for number, y in enumerate(drums(scene, layout), 1):
            # a drum is a thin shell: diametral inertia half the polar one, its length neglected
            found.append(
                Disk(
                    name=f"drum_{number}",
                    y=y,
                    mass=load.drum_mass_kg,
                    polar_inertia=load.drum_inertia_kg_m2,
                    diametral_inertia=min(load.drum_inertia_kg_m2, load.drum_mass_kg * radius**2) / 2,
                )
            )
    return found


def drums(scene: Scene, layout: Layout) -> tuple[float, ...]:
    """y of the drums (m)."""
    given = tuple(y / 1000 for y in scene.load.drum_positions_mm)
    return given or _ends(scene, layout.loaded)


def _ends(scene: Scene, shaft: int) -> tuple[float, float]:
    """y of the two ends of a shaft (m)."""
    sections = scene.shafts[shaft].sections
    return sections[0].start_mm / 1000, sections[-1].end_mm / 1000


def shaft_specs(scene: Scene, layout: Layout) -> tuple[ShaftSpec, ...]:
    """All shafts; shaft 1 lifts about +y, those that mesh with it turn the other way."""
    steel = scene.gear_material
    specs = []
    for number, (table, (x, z)) in enumerate(zip(scene.shafts, layout.axes, strict=True)):
        specs.append(
            ShaftSpec(
                name=f"shaft_{number + 1}",
                x=x,
                z=z,
                sense=layout.senses[number],
                sections=tuple(
                    Section(
                        y_start=section.start_mm / 1000,
                        y_end=section.end_mm / 1000,
                        outer_diameter=section.diameter_mm / 1000,
                        inner_diameter=section.bore_mm / 1000,
                    )
                    for section in table.sections
                ),
                disks=tuple(_disks(scene, layout, number)),
                elastic_modulus=steel.elastic_modulus_GPa * 1e9,
                poisson_ratio=steel.poisson_ratio,
                density=steel.density_kg_m3,
                damping_time=scene.shaft_model.damping_time_us / 1_000_000,
                element_length=scene.shaft_model.element_length_mm / 1000,
                model=scene.shaft_model.model,
            )
        )
    return tuple(specs)


def bearing_specs(scene: Scene) -> tuple[BearingSpec, ...]:
    """All bearings in shaft order, from -y."""
    specs = []
    for name, number, place in bearing_names(scene):
        shaft = scene.shafts[number]
        table = shaft.bearings[place] if shaft.bearings else scene.bearings
        at = f"shaft_{number + 1}", shaft.bearing_positions_mm[place] / 1000
        support: Literal["casing", "ground"] = "ground" if name.startswith("ground") else "casing"
        specs.append(_bearing(table, name, *at, support))
    return tuple(specs)


def _bearing(
    table: RigidBearings | LinearBearings | HertzBearings, name: str, shaft: str, y: float,
    support: Literal["casing", "ground"],
) -> BearingSpec:  # fmt: skip
    if isinstance(table, RigidBearings):
        return rigid_bearing(name, shaft, y, support)
    if isinstance(table, HertzBearings):
        return hertz_bearing(name, shaft, y, rolling_elements(table), table.damping_time_us / 1_000_000, support)
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


def coupling_specs(scene: Scene) -> tuple[ShaftCoupling, ...]:
    """Couplings between shafts."""
    return tuple(
        ShaftCoupling(
            name=f"coupling_{number}",
            shafts=(f"shaft_{table.shafts[0]}", f"shaft_{table.shafts[1]}"),
            y=(table.positions_mm[0] / 1000, table.positions_mm[1] / 1000),
            torsional_stiffness=table.torsional_stiffness_N_m_per_rad,
            radial_stiffness=table.radial_stiffness_N_per_um * 1e6,
            axial_stiffness=table.axial_stiffness_N_per_um * 1e6,
            tilt_stiffness=table.tilt_stiffness_N_m_per_rad,
            damping_time=table.damping_time_us / 1_000_000,
        )
        for number, table in enumerate(scene.couplings, 1)
    )


def mesh_specs(scene: Scene, layout: Layout, inputs: Sequence[MeshInput]) -> tuple[MeshSpec, ...]:
    """All meshes."""
    return tuple(
        MeshSpec(
            name=f"mesh_{number + 1}",
            driving=f"shaft_{layout.pair_shafts[number][0] + 1}",
            driven=f"shaft_{layout.pair_shafts[number][1] + 1}",
            y=stage.position_mm / 1000,
            base_radius_driving=pair.pinion.base_radius,
            base_radius_driven=pair.wheel.base_radius,
            pressure_angle=pair.working_pressure_angle,
            base_helix_angle=pair.base_helix_angle,
            backlash=pair.backlash,
            damping_time=stage.mesh_damping_time_us / 1_000_000,
            drive=given.drive,
            coast=given.coast,
            drive_clearance_pinion=given.drive_clearance_pinion,
            drive_clearance_wheel=given.drive_clearance_wheel,
            coast_clearance_pinion=given.coast_clearance_pinion,
            coast_clearance_wheel=given.coast_clearance_wheel,
            cycle_at_start=stage.cycle_at_start,
        )
        for number, (stage, pair, given) in enumerate(zip(scene.stages, layout.pairs, inputs, strict=True))
    )


def load_spec(scene: Scene, layout: Layout) -> Load:
    """The load on the drums."""
    table, shaft, places = scene.load, f"shaft_{layout.loaded + 1}", drums(scene, layout)
    if isinstance(table, RopeTable) and table.container_kg > 0:
        area = table.rope_fill_factor * math.pi / 4 * (table.rope_diameter_mm / 1000) ** 2
        return Rope(
            shaft=shaft,
            drums=places,
            container_mass=table.container_kg,
            drum_radius=table.drum_radius_mm / 1000,
            falls=table.rope_falls,
            axial_stiffness=table.rope_modulus_GPa * 1e9 * area,
            length=table.rope_length_m,
            reeving=table.reeving_ratio,
            damping_ratio=table.rope_damping_ratio,
        )
    return StaticTorque(shaft=shaft, drums=places, torque=output_torque(scene) / len(places))


def machine(scene: Scene, layout: Layout, inputs: Sequence[MeshInput]) -> Machine:
    """Everything the multibody run needs but the casing. `MachineError` names what does not fit."""
    rates = np.array(scene.drive.speeds_rpm) / 60 * 2 * math.pi
    ends = _ends(scene, layout.driven)[: scene.drive.motors]
    return Machine(
        shafts=shaft_specs(scene, layout),
        bearings=bearing_specs(scene),
        meshes=mesh_specs(scene, layout, inputs),
        couplings=tuple(
            CouplingSpec(
                name=f"motor_{number}",
                shaft=f"shaft_{layout.driven + 1}",
                y=y,
                stiffness=scene.drive.coupling_stiffness_N_m_per_rad,
                damping=scene.drive.coupling_damping_N_m_s_per_rad,
            )
            for number, y in enumerate(ends, 1)
        ),
        profile=SpeedProfile(times=np.array(scene.drive.times_s), speeds=rates),
        load=load_spec(scene, layout),
        shaft_couplings=coupling_specs(scene),
    )
