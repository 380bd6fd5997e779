"""Names, choices and limits of casings, used by their options and their computation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

Ground = Literal["fixed", "springs"]
Attachment = Literal["mean", "rigid"]
DampingRatio = float | Sequence[Sequence[float]]  # zeta, or rows (Hz, zeta) with ascending frequencies
MODES_OVER_BAND = 1.5  # fixed-interface modes are kept up to this multiple of the required band
COVER, FEET = "cover", "feet"

MOUNTS = "mounts"  # springs under the feet
JOINTS = "joints"  # bolts between two halves
LARGEST_LOSS_FACTOR = 2.0  # a body of only such a part would not oscillate
FEWEST_MOUNTS = 3  # feet on springs, which hold all rigid motions unless they are in one line


def few_feet(count: int) -> str:
    """What is wrong with a casing on springs that has less than `FEWEST_MOUNTS` feet, and what to do."""
    return (
        f"a casing on springs needs {FEWEST_MOUNTS} feet or more, because a mount has no stiffness against rotation; "
        f"it has {count}. Set one item of casing.housing.grounds for each foot"
    )
