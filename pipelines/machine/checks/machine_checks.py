"""What is put beside the end of its shaft, and shafts of too many elements: known by places alone."""

from __future__ import annotations

from collections.abc import Iterator

from mbd.parts.checks import MachineError
from mbd.parts.shafts import shaft_nodes
from pipelines.io.errors import Problem
from pipelines.machine.layout import Layout
from pipelines.machine.loads import load_places
from pipelines.machine.parts import MachineParts
from pipelines.scene.scene import Scene
from pipelines.scene.tables.motion import LoadBase


def off_shaft(scene: Scene, layout: Layout) -> Iterator[Problem]:
    """What is put beside the end of its shaft."""
    placed = [(f"probes.{n}.position_mm", p.shaft - 1, p.position_mm) for n, p in enumerate(scene.probes, 1)]
    placed += [(f"disks.{n}.position_mm", d.shaft - 1, d.position_mm) for n, d in enumerate(scene.disks, 1)]
    for number, (stage, pair) in enumerate(zip(scene.stages, layout.pair_shafts, strict=True), 1):
        placed += [(f"stages.{number}.position_mm", shaft, stage.position_mm) for shaft in pair]
    for number, coupling in enumerate(scene.couplings, 1):
        for shaft, y in zip(coupling.shafts, coupling.positions_mm, strict=True):
            placed.append((f"couplings.{number}.positions_mm", shaft - 1, y))
    key = "load.drum_positions_mm" if isinstance(scene.load, LoadBase) else "load.position_mm"
    load = load_places(scene.load, scene.shafts[layout.loaded])
    placed += [(key, layout.loaded, 1000 * y) for y in load]
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


def long_shafts(scene: Scene, machine: MachineParts) -> Iterator[Problem]:
    """Shafts of too many elements."""
    for number, spec in enumerate(machine.shafts, 1):
        on = [mesh.y for mesh in machine.meshes if spec.name in (mesh.driving, mesh.driven)]
        on += [bearing.y for bearing in machine.bearings if bearing.shaft == spec.name]
        try:
            shaft_nodes(spec, tuple(on))
        except MachineError as error:
            yield Problem(f"shafts.{number}", str(error))
