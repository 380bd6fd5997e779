"""What a run costs before it is run: time steps, samples, seconds, memory and disk; and what is too much.

The seconds follow from the loop benchmark (docs/benchmarks.md): for a time step 4 us, 0.06 us per mode, and 4 us per
sixteen slices of every stage, on one core of the machine it was measured on; twice as much where that is busy. Casings
of finite elements add about as many modes as the shipped rig's.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from fem.storage.cache_folder import cache_root
from pipelines.io.errors import Problem, SceneError
from pipelines.io.shown import duration
from pipelines.machine.plant import Drivetrain

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


def cost(train: Drivetrain) -> Cost:
    """What one simulation takes."""
    motion = train.motion
    samples = motion.end * motion.output_rate
    steps = samples * max(1.0, math.ceil(1 / motion.output_rate / max(motion.step or math.inf, 1e-18) - 1e-9))
    blocks = sum(math.ceil(law.mesh.slices / 16) for law in train.laws)
    seconds = steps * (_STEP_SECONDS + _MODE_SECONDS * _modes(train) + _SLICES_SECONDS * blocks)
    return Cost(samples=samples, steps=steps, channels=len(train.recorded.channels(train.machine)), seconds=seconds)


def too_long(train: Drivetrain) -> Iterator[Problem]:
    """More time steps or signals than one simulation may have."""
    one, motion = cost(train), train.motion
    if one.steps > MOST_STEPS:
        yield Problem(
            "simulation.step_us",
            f"gives {one.steps:.3g} time steps in {motion.end:g} s, more than {MOST_STEPS:.0g} (about "
            f"{MOST_STEPS * one.seconds / one.steps / 3600:.2g} hours)",
            f"Set {motion.end / MOST_STEPS * 1e6:.2g} or more, or reduce simulation.end_s",
            f"{1e6 * (motion.step or 0.0):g}",
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
    """Compare the signals of a study with the room in the cache and the result folder.

    A cache without room is a warning of the run as long as memory can hold the signals instead.

    Parameters
    ----------
    trains : of every simulation, the two that are written first
    source : the scene, for the message

    Raises
    ------
    SceneError : they do not fit
    """
    motions, packed, problems = *_bytes(trains), []
    for folder, needed, held in ((cache_root(), motions, _HELD), (Path("runs"), packed, 0.0)):
        free = shutil.disk_usage(_existing(folder)).free
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
    """The cost of a study in words; `trains` as `check_room`."""
    costs = [cost(train) for train in trains]
    signals = " or ".join(str(count) for count in dict.fromkeys(one.channels for one in costs))
    return (
        f"{_simulations(len(costs))} of {costs[0].steps:.3g} time steps and "
        f"{costs[0].samples:.3g} samples of {signals} signals: about {duration(sum(one.seconds for one in costs))} on "
        f"one core for the motion (mesh laws and casing not included), {words(_MEMORY)} of memory, "
        f"{words(sum(_bytes(trains)))} on disk"
    )


def _bytes(trains: Sequence[Drivetrain]) -> tuple[float, float]:
    """Of all signals in the cache, and of those in the result folder."""
    sizes = [cost(train).bytes for train in trains]
    return sum(sizes), _PACKED * sum(sizes[:_WRITTEN])


def _simulations(count: int) -> str:
    return f"{count} simulation{'s' if count > 1 else ''}"


def words(size: float) -> str:
    """A number of bytes for people."""
    for unit in ("B", "kB", "MB", "GB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:.4g} TB"


def _modes(train: Drivetrain) -> float:
    """About how many modes of the machine are kept."""
    found = float(train.casing_modes)
    for shaft in train.machine.shafts:
        bearings = sum(bearing.shaft == shaft.name for bearing in train.machine.bearings)
        nodes = min(333.0, (shaft.y_end - shaft.y_start) / shaft.element_length) + len(shaft.sections) + bearings + 2
        found += nodes * (3.0 if shaft.model == "timoshenko" else 1.0)  # half of the bending modes exceed the band
    return found


def _existing(folder: Path) -> Path:
    """The folder, or the nearest of its parents that is there."""
    folder = folder.absolute()
    return next((place for place in (folder, *folder.parents) if place.is_dir()), Path())
