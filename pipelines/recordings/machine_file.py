"""Machine of a recording: its kinematics, and the rules for reading the file.

It is described by a machine file (`pipelines.recordings.machine_table.MachineTable`) or by a scene.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pipelines.io.errors import InputError, Problem, SceneError
from pipelines.io.not_a_scene import MACHINE_KEYS, SCENE_KEYS
from pipelines.io.shown_text import shown
from pipelines.recordings.machine_table import BearingTable, MachineTable
from pipelines.signals.orders.kinematics import Bearing, Gear, Kinematics, Shaft


@dataclass(frozen=True, kw_only=True)
class MeasuredMachine:
    """Kinematics, and the `table` by which the channels of a file become signals in m/s2.

    A machine from a scene has the table of a machine file without such settings: every channel is a sensor.
    """

    kinematics: Kinematics
    table: MachineTable = field(default_factory=MachineTable.model_construct)


def read_machine(source: str | Path) -> MeasuredMachine:
    """Read the machine from a machine file or scene file (both end in .toml), or a shipped scene by its name.

    Raises
    ------
    SceneError : with all problems of the file
    InputError : there is no such file or scene, or it is not valid TOML
    """
    from pipelines.machine.layout import lay_out
    from pipelines.machine.scene_bearings import rolling_bearings
    from pipelines.machine.scene_kinematics import kinematics_of
    from pipelines.scene.load_scene import find_source, load_scene, parse, validate
    from pipelines.scene.merge import Merged

    if Path(source).suffix not in ("", ".toml"):
        raise InputError(
            f"{shown(source)}: a machine file must end in .toml. Give a machine file, a scene file, or the name of a "
            "shipped scene."
        )
    found = find_source(source)
    tree = parse(found)
    if found.folder is None or any(key in tree for key in SCENE_KEYS):
        if tree.keys() == {"stages"}:
            raise InputError(
                f"{found.shown}: holds stages alone. For a machine file replace them by teeth = [[25, 62]], a pair of "
                "numbers for each stage, and set speed_rpm. For a scene set its other tables, or extends."
            )
        if measured := ", ".join(key for key in MACHINE_KEYS if key in tree):
            raise InputError(
                f"{found.shown}: {measured} can only be in a machine file, {' and '.join(SCENE_KEYS)} only in a scene. "
                "For a machine file replace stages by teeth = [[25, 62]], a pair of numbers for each stage. For a "
                f"scene delete {measured}."
            )
        loaded = load_scene(source)
        layout = lay_out(loaded.scene, loaded.source.shown)
        return MeasuredMachine(kinematics=kinematics_of(layout, rolling_bearings(loaded.scene)))
    table, _ = validate(Merged(tree), MachineTable, found.shown)
    shafts, problems = _shafts(table)
    bearings, misfits = _bearings(table)
    if problems + misfits:
        raise SceneError(found.shown, problems + misfits)
    kinematics = Kinematics(
        shafts=tuple(shafts),
        gears=tuple(
            Gear(name=f"stage {stage} {gear}", shaft=shaft_name(number), stage=stage, teeth=teeth)
            for stage, (pair, numbers) in enumerate(zip(table.teeth, _pairs(table), strict=True), 1)
            for gear, teeth, number in zip(("pinion", "wheel"), pair, numbers, strict=True)
        ),
        bearings=tuple(bearings),
        frequency=None if table.speed_rpm is None else table.speed_rpm / 60,
    )
    return MeasuredMachine(kinematics=kinematics, table=table)


def shaft_name(number: int) -> str:
    """Name of a shaft from its number in the machine file."""
    return f"shaft_{number}"


def _pairs(table: MachineTable) -> Sequence[tuple[int, int]]:
    """Numbers of the shafts of each pair; in series unless they are given."""
    return table.shafts or [(number, number + 1) for number in range(1, len(table.teeth) + 1)]


def _shafts(table: MachineTable) -> tuple[list[Shaft], list[Problem]]:
    """Shafts with their speeds divided by that of shaft 1, and contradictions."""
    speeds = dict(enumerate(table.ratios, 1)) or {1: 1.0}
    problems = []
    waiting = {
        stage: (pair, *teeth) for stage, (pair, teeth) in enumerate(zip(_pairs(table), table.teeth, strict=True), 1)
    }
    while ready := next((s for s, (pair, *_) in waiting.items() if pair[0] in speeds or pair[1] in speeds), None):
        (one, other), driving, driven = waiting.pop(ready)
        if one not in speeds:
            one, other, driving, driven = other, one, driven, driving
        speed = speeds[one] * driving / driven
        if not math.isclose(speeds.setdefault(other, speed), speed, rel_tol=1e-9):
            problems.append(
                Problem(
                    f"teeth.{ready}",
                    f"gives shaft {other} a speed of {speed:.6g} over shaft 1, other pairs give {speeds[other]:.6g}",
                    "Correct teeth or shafts",
                )
            )
    problems += [
        Problem(
            f"shafts.{stage}",
            f"no pair connects shafts {one} and {other} to shaft 1",
            "Connect them by a pair in teeth, or delete them",
        )
        for stage, ((one, other), *_) in waiting.items()
    ]
    missing = sorted(set(range(1, max(speeds) + 1)) - speeds.keys()) if not waiting else []
    if missing:
        problems.append(Problem("shafts", f"shaft {missing[0]} is in no pair", "Number the shafts 1, 2, 3, ..."))
    named = [(f"bearings.{number}.shaft", bearing.shaft) for number, bearing in enumerate(table.bearings, 1)]
    sources = {"tachometer": table.tachometer, "speed": table.speed}
    named += [(f"{key}.shaft", source.shaft) for key, source in sources.items() if source is not None]
    problems += [
        Problem(path, f"there is no shaft {shaft}, allowed are 1 to {len(speeds)}", "Correct the number")
        for path, shaft in named
        if shaft not in speeds
    ]
    return [Shaft(name=shaft_name(number), ratio=speeds[number]) for number in sorted(speeds)], problems


def _bearings(table: MachineTable) -> tuple[list[Bearing], list[Problem]]:
    """Bearings with their pass orders, and problems of those whose rolling elements do not fit."""
    from mbd.parts.part_checks import MachineError

    found, problems = [], []
    for number, bearing in enumerate(table.bearings, 1):
        try:
            orders = bearing.orders() or _geometric_orders(bearing)
            found.append(Bearing(name=bearing.name, shaft=shaft_name(bearing.shaft), orders=orders))
        except MachineError as error:
            problems.append(Problem(f"bearings.{number}", str(error), "Correct its numbers"))
    return found, problems


def _geometric_orders(table: BearingTable) -> dict[str, float]:
    from mbd.parts.rolling_elements import RollingElements
    from pipelines.machine.scene_kinematics import pass_orders

    return pass_orders(
        RollingElements(
            kind="ball",  # rollers have the same kinematics
            count=table.elements or 0,
            diameter=(table.element_diameter_mm or 0.0) / 1000,
            pitch_diameter=(table.pitch_diameter_mm or 0.0) / 1000,
            contact_angle=table.si.contact_angle,
        )
    )
