"""Shafts that nothing holds: how a rigid shaft could move freely between its bearings, meshes and motors."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mbd.parts.bearings import BEARING_AXES
from mbd.parts.gear_mesh import contact_rows
from pipelines.io.errors import Problem
from pipelines.machine.plant import Plant
from pipelines.scene.scene import Scene

_AXES = ("ux", "uy", "uz", "rx", "ry", "rz")
_WORDS = {"uy": "move along its axis", "ry": "rotate", "rx": "tilt", "rz": "tilt"}
_ARM = 0.1  # m: by which rotations are counted beside displacements
_TAKES_PART = 0.25  # share of a direction of a shaft in free motions from which it is named
_FREE = 1e-9  # singular value over the largest, below which nothing holds a motion


def unheld(scene: Scene, plant: Plant) -> Iterator[Problem]:
    """The shafts that take part in motions that nothing holds, each with the direction in which it moves most."""
    rows = np.array(list(_springs(scene, plant)))
    scaled = rows * np.tile([1.0, 1.0, 1.0, 1 / _ARM, 1 / _ARM, 1 / _ARM], len(scene.shafts))
    scaled /= np.linalg.norm(scaled, axis=1)[:, None]
    _, sizes, motions = np.linalg.svd(scaled)
    held = int((sizes > _FREE * sizes[0]).sum())
    share = (motions[held:] ** 2).sum(axis=0).reshape(-1, 6)  # 1: moves by itself, 0: not at all
    for number, shares in enumerate(share, 1):
        if shares.max() < _TAKES_PART:
            continue
        axis = _AXES[int(np.argmax(shares))]
        yield Problem(
            f"shafts.{number}",
            f"shaft {number} can {_WORDS.get(axis, 'move across its axis')} freely",
            "Set a bearing that carries axial load (the NU types do not)"
            if axis == "uy"
            else "Set a second bearing, or one with tilt stiffness",
        )


def _springs(scene: Scene, plant: Plant) -> Iterator[np.ndarray]:
    """Rows (6 shafts) of everything that has stiffness, on the displacements and rotations of rigid shafts at y = 0."""

    def row(shaft: int, y: float, coefficients: np.ndarray) -> np.ndarray:
        found = np.zeros(6 * len(scene.shafts))
        x, _, z = coefficients[:3]
        found[6 * shaft : 6 * shaft + 6] = coefficients + [0.0, 0.0, 0.0, y * z, 0.0, -y * x]
        return found

    layout = plant.layout
    for bearing in plant.machine.bearings:
        shaft = int(bearing.shaft.removeprefix("shaft_")) - 1
        for axis, stiffness in zip(BEARING_AXES, bearing.stiffness, strict=True):
            if stiffness > 0.0:
                yield row(shaft, bearing.y, np.eye(6)[_AXES.index(axis)])
    yield row(layout.driven, 0.0, np.eye(6)[4])
    for coupling in scene.couplings:
        (one, other), (first, second) = coupling.shafts, coupling.si.positions
        radial, axial = coupling.radial_stiffness_N_per_um, coupling.axial_stiffness_N_per_um
        tilt, torsional = coupling.tilt_stiffness_N_m_per_rad, coupling.torsional_stiffness_N_m_per_rad
        strengths = radial, axial, radial, tilt, torsional, tilt
        for direction, strength in zip(np.eye(6), strengths, strict=True):
            if strength:
                yield row(one - 1, first, direction) - row(other - 1, second, direction)
    for stage, pair, (driving, driven) in zip(scene.stages, layout.pairs, layout.pair_shafts, strict=True):
        line = layout.axes[driven][0] - layout.axes[driving][0], layout.axes[driven][1] - layout.axes[driving][1]
        radii = pair.pinion.base_radius, pair.wheel.base_radius
        lead = pair.pinion.hand_sign * math.tan(pair.base_helix_angle)
        y = stage.si.position
        flank = contact_rows(line, radii, pair.working_pressure_angle, lead, layout.senses[driving])
        for contact in flank[: 2 if stage.mesh.slices > 1 else 1]:
            yield row(driving, y, contact[:6]) + row(driven, y, contact[6:])
