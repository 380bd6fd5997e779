"""Estimated cost of a run: time steps, samples, seconds, memory and disk space; and their upper limits.

The time per step follows from the benchmark of the time loop (docs/benchmarks.md): 4 us, 0.06 us per mode, and 4 us per
sixteen slices of every stage, on one core of the computer of the benchmark. On a busy computer it is twice as long.
Casings of finite elements are assumed to have about as many modes as that of the shipped rig.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from fem.storage.cache_folder import cache_root
from pipelines.io.errors import Problem, SceneError
from pipelines.io.shown_text import duration
from pipelines.machine.machine_model import Drivetrain

MOST_STEPS = 1e9  # of one simulation: half a day
MOST_VALUES = 1e9  # samples times channels of one simulation: 8 GB
_STEP_SECONDS, _MODE_SECONDS, _SLICES_SECONDS = 4e-6, 0.06e-6, 4e-6
_WRITTEN = 2  # responses in a result folder: that of the scene and that of its control
_PACKED = 0.5  # size of a response file relative to the motion in the cache
_HELD = 5e8  # bytes of signals that are kept in memory if the cache has not enough space
_MEMORY = 5e8  # bytes of program, libraries and one block; signals are written to a file and need no memory


@dataclass(frozen=True, kw_only=True)
class Cost:
    """Cost of one simulation of a scene; seconds are those on one core."""

    samples: float
    steps: float
    channels: int
    seconds: float

    @property
    def bytes(self) -> float:
        """Size of all channels in double precision."""
        return 8.0 * self.samples * self.channels


def cost(train: Drivetrain) -> Cost:
    """Estimated cost of one simulation."""
    motion = train.motion
    samples = motion.end * motion.output_rate
    steps = samples * max(1.0, math.ceil(1 / motion.output_rate / max(motion.step, 1e-18) - 1e-9))
    blocks = sum(math.ceil(law.mesh.slices / 16) for law in train.laws)
    seconds = steps * (_STEP_SECONDS + _MODE_SECONDS * _modes(train) + _SLICES_SECONDS * blocks)
    return Cost(samples=samples, steps=steps, channels=len(train.recorded.channels(train.parts)), seconds=seconds)


def too_long(train: Drivetrain) -> Iterator[Problem]:
    """Problems of a simulation with too many time steps or signals."""
    one, motion = cost(train), train.motion
    if one.steps > MOST_STEPS:
        yield Problem(
            "simulation.step_us",
            f"gives {one.steps:.3g} time steps in {motion.end:g} s, more than {MOST_STEPS:.0g} (which take "
            f"about {MOST_STEPS * one.seconds / one.steps / 3600:.2g} hours)",
            f"Set {motion.end / MOST_STEPS * 1e6:.2g} or more, or reduce simulation.end_s",
            f"{1e6 * motion.step:g}",
        )
    if one.samples * one.channels > MOST_VALUES:
        yield Problem(
            "simulation.output_rate_Hz",
            f"gives {one.samples:.3g} samples of {one.channels} signals, {words(one.bytes)}, more than "
            f"{words(8 * MOST_VALUES)} for one simulation",
            f"Set {MOST_VALUES / one.channels / motion.end:.4g} or less, or reduce simulation.end_s",
            f"{motion.output_rate:g}",
        )


def check_room(trains: Sequence[Drivetrain], source: str) -> None:
    """Compare the size of the signals of a study with the free disk space of the cache and the result folder.

    If the cache has not enough space but the memory has, the run only gives a warning.

    Parameters
    ----------
    trains : of all simulations, first the two that are written to the result folder
    source : name of the scene, for the message

    Raises
    ------
    SceneError : there is not enough space
    """
    motions, packed, problems = *_bytes(trains), []
    for folder, needed, held in ((cache_root(), motions, _HELD), (Path("runs"), packed, 0.0)):
        places = (folder.absolute(), *folder.absolute().parents)
        free = shutil.disk_usage(next((place for place in places if place.is_dir()), Path())).free
        if needed > max(free, held):
            problems.append(
                Problem(
                    "simulation",
                    f"the signals of {_simulations(len(trains))} take about {words(needed)} in {folder}, {words(free)} "
                    "are free there",
                    "Reduce simulation.output_rate_Hz or end_s, or delete files there",
                )
            )
    if problems:
        raise SceneError(source, problems)


def estimate(trains: Sequence[Drivetrain]) -> str:
    """The cost of a study as text; `trains` as for `check_room`."""
    costs = [cost(train) for train in trains]
    signals = " or ".join(str(count) for count in dict.fromkeys(one.channels for one in costs))
    return (
        f"{_simulations(len(costs))} of {costs[0].steps:.3g} time steps and "
        f"{costs[0].samples:.3g} samples of {signals} signals: about {duration(sum(one.seconds for one in costs))} on "
        f"one idle core for the motion (mesh laws and casing not included), {words(_MEMORY)} of memory, "
        f"{words(sum(_bytes(trains)))} on disk"
    )


def _bytes(trains: Sequence[Drivetrain]) -> tuple[float, float]:
    """Bytes of all signals in the cache, and of those in the result folder."""
    sizes = [cost(train).bytes for train in trains]
    return sum(sizes), _PACKED * sum(sizes[:_WRITTEN])


def _simulations(count: int) -> str:
    return f"{count} simulation{'s' if count > 1 else ''}"


def words(size: float) -> str:
    """A number of bytes as text with a suitable unit."""
    for unit in ("B", "kB", "MB", "GB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:.4g} TB"


def _modes(train: Drivetrain) -> float:
    """Approximate number of retained modes of the machine."""
    found = float(train.casing_modes)
    for shaft in train.parts.shafts:
        bearings = sum(bearing.shaft == shaft.name for bearing in train.parts.bearings)
        nodes = min(333.0, (shaft.y_end - shaft.y_start) / shaft.element_length) + len(shaft.sections) + bearings + 2
        found += nodes * (3.0 if shaft.model == "timoshenko" else 1.0)  # half of the bending modes exceed the band
    return found
