"""Parts of the machine that refuse the values of a scene: every cheap one is made here, and its reason told by key."""

from __future__ import annotations

import difflib
import functools
from collections.abc import Iterator

from fem.contact.frame import ModelError
from fem.contact.models.mesh_model import LawSpec
from fem.gears.geometry import GeometryError
from mbd.bearing_faults.spall import check_apart
from mbd.parts.checks import MachineError
from mbd.parts.rolling_catalogue import designations
from mbd.parts.shafts import shaft_nodes
from pipelines.border.errors import Problem
from pipelines.plant.bearings import (
    BearingFault,
    numbered_bearing_faults,
    rolling_bearings,
)
from pipelines.plant.checks.held_shafts import unheld
from pipelines.plant.layout import Layout
from pipelines.plant.machine import shaft_specs
from pipelines.plant.plant import law_specs
from pipelines.plant.torques.drives import motor_places, motor_torques, speed_profile
from pipelines.plant.torques.loads import hanging_load, load_places, torque_load
from pipelines.scene.scene import Scene
from pipelines.scene.tables.bearings import BearingModel
from pipelines.scene.tables.motion import LoadBase, SpeedDrive


def bad_machine(scene: Scene, layout: Layout) -> Iterator[Problem]:
    """Everything that the parts of the machine refuse."""
    bearings = [*_bad_bearings(scene)]
    yield from bearings
    stations = [*_off_shaft(scene, layout)]
    yield from stations
    if not stations:
        yield from _bad_shafts(scene, layout)
    yield from _bad_load(scene, layout)
    if not bearings:
        yield from unheld(scene, layout)
        yield from _bad_spalls(scene)


def _bad_bearings(scene: Scene) -> Iterator[Problem]:
    if any(not shaft.bearings for shaft in scene.shafts):
        yield from _bad_bearing("bearings", scene.bearings)
    for number, shaft in enumerate(scene.shafts, 1):
        for place, table in enumerate(shaft.bearings, 1):
            yield from _bad_bearing(f"shafts.{number}.bearings.{place}", table)


def _bad_bearing(path: str, table: BearingModel) -> Iterator[Problem]:
    known = designations()
    if table.model == "hertz" and table.designation is not None and table.designation not in known:
        wanted = table.designation.replace(" ", "").upper()
        near = [name for name in known if wanted.startswith(name)]
        near += [name for name in difflib.get_close_matches(wanted, known, n=4) if name not in near]
        hint = f"Similar: {', '.join(near)}. " if near else ""
        yield Problem(
            f"{path}.designation",
            f"is not in the catalogue ({', '.join(known)})",
            f"{hint}Set one of these, or instead of designation the geometry (kind, elements, element_diameter_mm, "
            "pitch_diameter_mm)",
            f'"{table.designation}"',
        )
        return
    try:
        model = table.made()
        if model.elements is None:
            model.spec("bearing", ("shaft", 0.0), "casing")
        elif not model.elements.stiffness > 0.0:
            yield Problem(path, "the rolling elements have no stiffness", "Raise element_diameter_mm")
    except MachineError as error:
        yield Problem(path, str(error))


def _bad_spalls(scene: Scene) -> Iterator[Problem]:
    """Spalls that do not fit into their bearings, each with those before it."""
    elements = {bearing.name: bearing.elements for bearing in rolling_bearings(scene.shafts, scene.bearings)}
    before: list[BearingFault] = []
    for number, fault in numbered_bearing_faults(scene):
        inside, others = elements[fault.bearing], [one.spall for one in before if one.bearing == fault.bearing]
        try:
            fault.spall.check(inside)
            check_apart([*others, fault.spall], inside)
        except MachineError as error:
            yield Problem(f"faults.{number}", str(error))
        else:
            before.append(fault)


def _off_shaft(scene: Scene, layout: Layout) -> Iterator[Problem]:
    """What is put beside the end of its shaft."""
    placed = [(f"probes.{n}.position_mm", p.shaft - 1, p.position_mm) for n, p in enumerate(scene.probes, 1)]
    placed += [(f"disks.{n}.position_mm", d.shaft - 1, d.position_mm) for n, d in enumerate(scene.disks, 1)]
    for number, (stage, pair) in enumerate(zip(scene.stages, layout.pair_shafts, strict=True), 1):
        placed += [(f"stages.{number}.position_mm", shaft, stage.position_mm) for shaft in pair]
    for number, coupling in enumerate(scene.couplings, 1):
        for shaft, y in zip(coupling.shafts, coupling.positions_mm, strict=True):
            placed.append((f"couplings.{number}.positions_mm", shaft - 1, y))
    key = "load.drum_positions_mm" if isinstance(scene.load, LoadBase) else "load.position_mm"
    placed += [(key, layout.loaded, 1000 * y) for y in load_places(scene.load, scene.shafts[layout.loaded])]
    motors = motor_places(scene.drive, scene.shafts[layout.driven])
    placed += [("drive.position_mm", layout.driven, 1000 * y) for y in motors]
    for path, number, y in placed:
        sections = scene.shafts[number].sections
        start, end = sections[0].start_mm, sections[-1].end_mm
        if not start - 1e-6 <= y <= end + 1e-6:
            yield Problem(
                path,
                f"y = {y:g} mm is not on shaft {number + 1}, which extends from {start:g} to {end:g} mm",
                "Correct it, or make the shaft longer (sections)",
            )


def _bad_shafts(scene: Scene, layout: Layout) -> Iterator[Problem]:
    try:
        specs = shaft_specs(scene, layout)
    except MachineError as error:
        yield Problem("shafts", str(error))
        return
    for number, spec in enumerate(specs, 1):
        try:
            shaft_nodes(spec, _stations(scene, layout, number - 1))
        except MachineError as error:
            yield Problem(f"shafts.{number}", str(error))


def _stations(scene: Scene, layout: Layout, shaft: int) -> tuple[float, ...]:
    stages = [s.si.position for s, pair in zip(scene.stages, layout.pair_shafts, strict=True) if shaft in pair]
    return (*scene.shafts[shaft].si.bearing_positions, *stages)


def _bad_load(scene: Scene, layout: Layout) -> Iterator[Problem]:
    places = load_places(scene.load, scene.shafts[layout.loaded])
    try:
        _ = torque_load(scene.load, layout.loaded, places)
        load = hanging_load(scene.load, layout.loaded, places)
        if load is not None and isinstance(scene.drive, SpeedDrive):
            load.check_run(speed_profile(scene.drive), layout.shaft_ratios[layout.loaded], scene.simulation.end_s)
    except MachineError as error:
        yield Problem("load", str(error))
    try:
        _ = motor_torques(scene.drive, layout.driven, (0.0,))
    except MachineError as error:
        yield Problem("drive", str(error))
    for number, force in enumerate(scene.forces, 1):
        try:
            _ = force.spec(number)
        except MachineError as error:
            yield Problem(f"forces.{number}", str(error))


def bad_laws(scene: Scene, layout: Layout) -> Iterator[Problem]:
    """Mesh models that refuse their pair; those of finite elements are asked for their settings and path of contact."""
    for number, spec in enumerate(law_specs(scene, layout), 1):
        if reason := _law_refusal(spec):
            yield Problem(f"stages.{number}.mesh", reason)


@functools.lru_cache(maxsize=64)
def _law_refusal(spec: LawSpec) -> str:
    """Why a law cannot be built, "" where nothing is known against it."""
    try:
        spec.mesh.check(spec.pair)
    except (ModelError, GeometryError) as error:
        return str(error)
    return ""
