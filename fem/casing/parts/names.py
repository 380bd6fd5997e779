"""Names of parts of a casing that have no elements, and the largest loss factor of a part."""

from __future__ import annotations

MOUNTS = "mounts"  # springs under the feet
JOINTS = "joints"  # bolts between two halves
LARGEST_LOSS_FACTOR = 2.0  # a body of such a part alone would not oscillate
