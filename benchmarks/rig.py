"""The shipped scenes as objects of the library: what the measured parts have in common."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

from fem.casing.geometry.housing import Housing
from fem.casing.reduced.body import ReducedBody
from fem.casing.reduced.models import CraigBamptonCasing, NoCasing, RigidCasing, StaticCasing
from fem.contact.law import MeshLaw
from fem.contact.models.plane import Plane
from fem.elements.materials import Material
from fem.gears.geometry import GearPair
from mbd.system.system import System, assemble
from pipelines.plant.channels import wanted_channels
from pipelines.plant.facts import bearing_points
from pipelines.plant.housing import housing
from pipelines.plant.layout import Layout, lay_out, material
from pipelines.plant.machine import machine
from pipelines.plant.mesh_models import mesh_models
from pipelines.plant.teeth import mesh_inputs
from pipelines.scene.file import load_scene
from pipelines.scene.scene import Scene
from pipelines.scene.tables.casing import NoCasingTable, RigidCasingTable

SCENE = "rig-healthy"
RAMP = {"drive.times_s": [0.0, 0.05, 5.0], "drive.speeds_rpm": [0.0, 900.0, 900.0]}  # so that a short run moves
Laws = tuple[MeshLaw, MeshLaw]


class MissingPart(RuntimeError):
    """A part that an earlier measurement should have left behind is not there."""


def read(name: str = SCENE, **settings: Any) -> tuple[Scene, Layout]:
    """A shipped scene with settings (``casing__model="rigid"`` for casing.model) and its layout."""
    scene = load_scene(name, {key.replace("__", "."): value for key, value in settings.items()}).scene
    return scene, lay_out(scene)


def moving(name: str = SCENE, **settings: Any) -> tuple[Scene, Layout]:
    """The scene with a motor that reaches 900 rpm after 0.05 s."""
    return read(name, **{key.replace(".", "__"): value for key, value in RAMP.items()}, **settings)


def stage_law(scene: Scene, layout: Layout, stage: int) -> Laws:
    """The laws of one stage (0-based) by the rung of the scene."""
    return mesh_models(scene, layout)[stage].laws(layout.pairs[stage])


def plane_law(pair: GearPair, slices: int = 15, refinement: float = 1.0) -> Laws:
    """The laws of rung plane."""
    return Plane(slices=slices, refinement=refinement).laws(pair)


def casing_parts(scene: Scene, layout: Layout) -> tuple[Housing, Material]:
    """Housing with its sensors, and its material."""
    table = scene.casing
    assert not isinstance(table, NoCasingTable)
    return housing(scene, table.housing, layout), material("casing", table.material)


def casing_rung(scene: Scene) -> RigidCasing | StaticCasing | CraigBamptonCasing:
    """The rung of a scene with a housing."""
    table = scene.casing
    assert not isinstance(table, NoCasingTable)
    if isinstance(table, RigidCasingTable):
        return RigidCasing(
            mount_stiffness=table.mount_stiffness_N_per_um * 1e6,
            damping_ratio=table.damping_ratio,
        )
    if table.model == "static":
        return StaticCasing(element_size=table.element_size_mm / 1000, damping=table.damping_ratio)
    return CraigBamptonCasing(
        band=table.band_Hz, element_size=table.element_size_mm / 1000, damping=table.damping_ratio
    )


def casing_body(scene: Scene, layout: Layout) -> ReducedBody:
    """The casing of a scene by its rung."""
    if isinstance(scene.casing, NoCasingTable):
        return NoCasing().reduce({f"bearing_{n}": p for n, p in enumerate(bearing_points(scene, layout), 1)})
    return casing_rung(scene).reduce(*casing_parts(scene, layout))


def system(scene: Scene, layout: Layout, laws: list[Laws], body: ReducedBody) -> System:
    """The assembled machine with all channels of the scene."""
    train = machine(scene, layout, mesh_inputs(scene, layout, laws))
    return assemble(train, body, wanted_channels(scene, train))


def keep(folder: Path, name: str, value: Any) -> None:
    """Leave a result for later parts of the same benchmark."""
    (folder / f"{name}.pickle").write_bytes(pickle.dumps(value))


def kept(folder: Path, name: str) -> Any:
    """What an earlier part of this benchmark left in its own folder; MissingPart if it was skipped."""
    path = folder / f"{name}.pickle"
    if not path.exists():
        raise MissingPart(f"needs the result {name!r} of a part that was skipped")
    return pickle.loads(path.read_bytes())
