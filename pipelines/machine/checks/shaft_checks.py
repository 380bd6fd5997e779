"""Checks of shafts: parts beyond their ends, too many elements, and shafts that are not supported.

Unsupported shafts are found by the rigid-body motions of the shafts on their bearings, meshes and motors.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from mbd.parts.bearings import BEARING_AXES
from mbd.parts.part_checks import MachineError
from mbd.parts.shafts import AXES, shaft_nodes
from pipelines.io.errors import Problem, Problems
from pipelines.machine.bearing_loads import flank_rows, rigid_row
from pipelines.machine.layout import TrainLayout
from pipelines.machine.machine_model import MachineModel
from pipelines.machine.machine_parts import MachineParts
from pipelines.scene.scene import Scene

_WORDS = {"uy": "move along its axis", "ry": "rotate", "rx": "tilt", "rz": "tilt"}
_ARM = 0.1  # m, lever arm that makes rotations comparable with displacements
_TAKES_PART = 0.25  # share of a direction of a shaft in free motions from which it is reported
_FREE = 1e-9  # singular value relative to the largest, below which a motion is free


def off_shaft(scene: Scene, layout: TrainLayout) -> Iterator[Problem]:
    """Parts that are beyond the ends of their shaft."""
    placed = [(f"probes.{n}.position_mm", p.shaft - 1, p.position_mm) for n, p in enumerate(scene.probes, 1)]
    placed += [(f"disks.{n}.position_mm", d.shaft - 1, d.position_mm) for n, d in enumerate(scene.disks, 1)]
    for number, force in enumerate(scene.forces, 1):
        placed += [(f"forces.{number}.{key}", force.shaft - 1, y) for key, y in force.positions.items()]
    for number, (stage, pair) in enumerate(zip(scene.stages, layout.pair_shafts, strict=True), 1):
        placed += [(f"stages.{number}.position_mm", shaft, stage.position_mm) for shaft in pair]
    for number, coupling in enumerate(scene.couplings, 1):
        for shaft, y in zip(coupling.shafts, coupling.positions_mm, strict=True):
            placed.append((f"couplings.{number}.positions_mm", shaft - 1, y))
    placed += [(scene.load.places_key, layout.loaded, 1000 * y) for y in scene.load.places(scene.shafts[layout.loaded])]
    placed += [("drive.position_mm", layout.driven, 1000 * y) for y in layout.motors]
    for path, number, y in placed:
        sections = scene.shafts[number].sections
        start, end = sections[0].start_mm, sections[-1].end_mm
        if not start - 1e-6 <= y <= end + 1e-6:
            yield Problem(
                path,
                f"y = {y:g} mm is not on shaft {number + 1}, which extends from {start:g} to {end:g} mm",
                "Correct it, or make the shaft longer (sections)",
            )


def long_shafts(machine: MachineParts) -> list[Problem]:
    """Shafts with too many elements."""
    problems = Problems(MachineError)
    for number, spec in enumerate(machine.shafts, 1):
        on = [mesh.y for mesh in machine.meshes if spec.name in (mesh.driving, mesh.driven)]
        on += [bearing.y for bearing in machine.bearings if bearing.shaft == spec.name]
        problems.made(f"shafts.{number}", shaft_nodes, spec, tuple(on))
    return problems


def unheld(machine: MachineModel) -> Iterator[Problem]:
    """The shafts that take part in free motions, each with the direction in which it moves most."""
    rows = np.array(list(_springs(machine)))
    scaled = rows * np.tile([1.0, 1.0, 1.0, 1 / _ARM, 1 / _ARM, 1 / _ARM], len(machine.parts.shafts))
    scaled /= np.linalg.norm(scaled, axis=1)[:, None]
    _, sizes, motions = np.linalg.svd(scaled)
    held = int((sizes > _FREE * sizes[0]).sum())
    share = (motions[held:] ** 2).sum(axis=0).reshape(-1, 6)  # 1: moves by itself, 0: not at all
    for number, shares in enumerate(share, 1):
        if shares.max() < _TAKES_PART:
            continue
        axis = AXES[int(np.argmax(shares))]
        yield Problem(
            f"shafts.{number}",
            f"shaft {number} can {_WORDS.get(axis, 'move across its axis')} freely",
            "Set a bearing that carries axial load (the NU types do not)"
            if axis == "uy"
            else "Set a second bearing, or one with tilt stiffness",
        )


def _springs(machine: MachineModel) -> Iterator[np.ndarray]:
    """Rows (6 shafts) of all springs, for the displacements and rotations of rigid shafts at y = 0."""
    layout, parts = machine.layout, machine.parts
    numbers = {shaft.name: number for number, shaft in enumerate(parts.shafts)}

    row = partial(rigid_row, len(numbers))
    for bearing in parts.bearings:
        for axis, stiffness in zip(BEARING_AXES, bearing.stiffness, strict=True):
            if stiffness > 0.0:
                yield row(numbers[bearing.shaft], bearing.y, np.eye(6)[AXES.index(axis)])
    yield row(layout.driven, 0.0, np.eye(6)[4])
    for coupling in parts.shaft_couplings:
        one, other = (numbers[shaft] for shaft in coupling.shafts)
        for direction, strength in zip(np.eye(6), coupling.stiffness, strict=True):
            if strength:
                yield row(one, coupling.y[0], direction) - row(other, coupling.y[1], direction)
    for number, (mesh, law, (driving, driven)) in enumerate(
        zip(parts.meshes, machine.laws, layout.pair_shafts, strict=True)
    ):
        for contact in flank_rows(layout, number)[: 2 if law.mesh.slices > 1 else 1]:
            yield row(driving, mesh.y, contact[:6]) + row(driven, mesh.y, contact[6:])
