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
