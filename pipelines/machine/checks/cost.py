"""What a run costs before it is run: time steps, samples, seconds, memory and disk; and what is too much.

The seconds follow from the loop benchmark (docs/benchmarks.md): for a time step 4 us, 0.06 us per mode, and 4 us per
sixteen slices of every stage, on one core of the machine it was measured on; twice as much where that is busy. Casings
of finite elements add about as many modes as the shipped rig's.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from fem.storage.cache_folder import cache_root
from mbd.elements.reading import further_class
from mbd.parts.checks import MachineError
from pipelines.io.errors import Problem, SceneError
from pipelines.io.shown import duration
from pipelines.scene.scene import Scene
from pipelines.scene.tables.casing import FlexibleBase

MOST_STEPS = 1e9  # of one simulation: half a day
MOST_VALUES = 1e9  # samples times channels of one simulation: 8 GB
_STEP_SECONDS, _MODE_SECONDS, _SLICES_SECONDS = 4e-6, 0.06e-6, 4e-6
_WRITTEN = 2  # responses in a result folder: the scene's own and that of its control
_PACKED = 0.5  # size of a response file against the motion that the cache holds
_HELD = 5e8  # bytes of signals that may be held in memory where the cache has no room for them
_MEMORY = 5e8  # bytes: program, libraries and one block; signals go to a file, so a long run takes no more


@dataclass(frozen=True, kw_only=True)
class Cost:
    """One simulation of a scene; bytes of its signals, seconds on one core."""

    samples: float
    steps: float
    channels: int
    seconds: float

    @property
    def bytes(self) -> float:
        """Of all channels in double precision."""
        return 8.0 * self.samples * self.channels


def cost(scene: Scene) -> Cost:
    """What one simulation takes."""
    table = scene.simulation
    samples = table.end_s * table.output_rate_Hz
    steps = samples * max(1.0, math.ceil(1e6 / table.output_rate_Hz / max(table.step_us, 1e-12) - 1e-9))
    blocks = sum(math.ceil(stage.mesh.slices / 16) for stage in scene.stages)
    seconds = steps * (_STEP_SECONDS + _MODE_SECONDS * _modes(scene) + _SLICES_SECONDS * blocks)
    return Cost(samples=samples, steps=steps, channels=_channels(scene), seconds=seconds)


def too_long(scene: Scene) -> Iterator[Problem]:
    """More time steps or signals than one simulation may have."""
    one, table = cost(scene), scene.simulation
    if one.steps > MOST_STEPS:
        yield Problem(
            "simulation.step_us",
            f"gives {one.steps:.3g} time steps in {table.end_s:g} s, more than {MOST_STEPS:.0g} (about "
            f"{MOST_STEPS * one.seconds / one.steps / 3600:.2g} hours)",
            f"Set {table.end_s / MOST_STEPS * 1e6:.2g} or more, or reduce simulation.end_s",
            f"{table.step_us:g}",
        )
    if one.samples * one.channels > MOST_VALUES:
        yield Problem(
            "simulation.output_rate_Hz",
            f"gives {one.samples:.3g} samples of {one.channels} channels, {words(one.bytes)}, more than "
            f"{words(8 * MOST_VALUES)} for one simulation",
            f"Set {MOST_VALUES / one.channels / table.end_s:.4g} or less, or reduce simulation.end_s",
            f"{table.output_rate_Hz:g}",
        )


def check_room(scene: Scene, source: str, simulations: int) -> None:
    """Compare the signals of a study with the room in the cache and the result folder.

    A cache without room is a warning of the run as long as memory can hold the signals instead.

    Raises
    ------
    SceneError : they do not fit
    """
    one, problems = cost(scene), []
    motions, packed = simulations * one.bytes, min(simulations, _WRITTEN) * _PACKED * one.bytes
    for folder, needed, held in ((cache_root(), motions, _HELD), (Path("runs"), packed, 0.0)):
        free = shutil.disk_usage(_existing(folder)).free
        if needed > max(free, held):
            problems.append(
                Problem(
                    "simulation",
                    f"the signals of {simulations} simulations take about {words(needed)} in {folder}, {words(free)} "
                    "are free there",
                    "Reduce simulation.output_rate_Hz or end_s, or delete files there",
                )
            )
    if problems:
        raise SceneError(source, problems)


def estimate(scene: Scene, simulations: int) -> str:
    """The cost of a study in words."""
    one = cost(scene)
    disk = (simulations + min(simulations, _WRITTEN) * _PACKED) * one.bytes
    return (
        f"{simulations} simulation{'s' if simulations > 1 else ''} of {one.steps:.3g} time steps and {one.samples:.3g} "
        f"samples of {one.channels} channels: about {duration(simulations * one.seconds)} on one core, without mesh "
        f"and casing, {words(_MEMORY)} of memory, {words(disk)} on disk"
    )


def words(size: float) -> str:
    """A number of bytes for people."""
    for unit in ("B", "kB", "MB", "GB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:.4g} TB"


def _modes(scene: Scene) -> float:
    """About how many modes of the machine are kept."""
    length = scene.shaft_model.element_length_mm
    nodes = 0.0
    for shaft in scene.shafts:
        stretch = shaft.sections[-1].end_mm - shaft.sections[0].start_mm
        nodes += min(333.0, stretch / length) + len(shaft.sections) + len(shaft.bearing_positions_mm) + 2
    per_node = 3.0 if scene.shaft_model.model == "timoshenko" else 1.0  # half of the bending modes lie above the band
    return per_node * nodes + scene.casing.made_of.added_modes


def _channels(scene: Scene) -> int:
    """Signals that are recorded, see `mbd.parts.channels.channel_names`."""
    bearings = sum(len(shaft.bearing_positions_mm) for shaft in scene.shafts)
    count = 3 * scene.drive.motors + 2 * len(scene.shafts) + 4 * len(scene.stages) + 3 * bearings
    count += 3 * (len(scene.sensors) if isinstance(scene.casing, FlexibleBase) else bearings)
    things = {"bearing": bearings, "shaft": len(scene.shafts), "stage": len(scene.stages)}
    for name in scene.simulation.channels:
        kind = further_class(name, MachineError).kind
        count += things[kind.dims[0]] * len(kind.spelled(""))
    return count + scene.load.channels


def _existing(folder: Path) -> Path:
    """The folder, or the nearest of its parents that is there."""
    folder = folder.absolute()
    return next((place for place in (folder, *folder.parents) if place.is_dir()), Path())
