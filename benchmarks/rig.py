"""The shipped scenes as objects of the library: what the measured parts have in common."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

from fem.casing.geometry.housing import Housing
from fem.casing.models.stage import body_of
from fem.casing.reduced.reduced_body import ReducedBody
from fem.contact.law import MeshLaw
from fem.contact.models.plane import Plane
from fem.elements.materials import Material
from fem.gears.geometry import GearPair
from mbd.system.system import System
from pipelines.machine.machine_conversion import make_machine
from pipelines.machine.machine_model import MachineModel
from pipelines.machine.system_assembly import assemble_machine, assemble_system
from pipelines.scene.load_scene import load_scene

SCENE = "rig-healthy"
RAMP = {"drive.times_s": [0.0, 0.05, 5.0], "drive.speeds_rpm": [0.0, 900.0, 900.0]}  # so that a short run moves
Laws = tuple[MeshLaw, MeshLaw]


class MissingPart(RuntimeError):
    """A part that an earlier measurement should have left behind is not there."""


def read(name: str = SCENE, **settings: Any) -> MachineModel:
    """The plant of a shipped scene with settings (``casing__model="rigid"`` for casing.model)."""
    return make_machine(load_scene(name, {key.replace("__", "."): value for key, value in settings.items()}).scene)


def moving(name: str = SCENE, **settings: Any) -> MachineModel:
    """The same with a motor that reaches 900 rpm after 0.05 s."""
    return read(name, **{key.replace(".", "__"): value for key, value in RAMP.items()}, **settings)


def stage_law(machine: MachineModel, stage: int) -> Laws:
    """The laws of one stage (0-based) by the model of the scene."""
    return machine.laws[stage].laws()


def plane_law(pair: GearPair, slices: int = 15, refinement: float = 1.0) -> Laws:
    """The laws of model plane."""
    return Plane(slices=slices, refinement=refinement).laws(pair)


def casing_parts(machine: MachineModel) -> tuple[Housing, Material]:
    """Housing with its sensors, and its material."""
    box, material = machine.structure.housing, machine.structure.material
    assert isinstance(box, Housing)
    assert material is not None
    return box, material


def casing_body(machine: MachineModel) -> ReducedBody:
    """The casing of a plant by its model."""
    return body_of(machine.casing.stages(machine.structure))


def system(machine: MachineModel, laws: list[Laws], body: ReducedBody) -> System:
    """The assembled machine with all channels of the plant."""
    return assemble_system(assemble_machine(machine.parts, laws), body, machine.recorded)


def keep(folder: Path, name: str, value: Any) -> None:
    """Leave a result for later parts of the same benchmark."""
    (folder / f"{name}.pickle").write_bytes(pickle.dumps(value))


def kept(folder: Path, name: str) -> Any:
    """What an earlier part of this benchmark left in its own folder; MissingPart if it was skipped."""
    path = folder / f"{name}.pickle"
    if not path.exists():
        raise MissingPart(f"needs the result {name!r} of a part that was skipped")
    return pickle.loads(path.read_bytes())
