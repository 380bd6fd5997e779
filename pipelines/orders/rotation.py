"""The rotation of a machine in a recording: the angle of its first shaft, and how well it is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False, kw_only=True)
class Rotation:
    """`angle` (time,) of the first shaft in rad, never falling, one value per sample of the recording.

    `source` says in words where it comes from; `error` is the standard uncertainty of the mean speed, as a share of it;
    `absolute` is True where angle 0 is a mark on the shaft, so that the place of a tooth means something.
    """

    angle: np.ndarray
    source: str
    error: float
    absolute: bool

    @property
    def turns(self) -> float:
        """How often the first shaft turns in the recording."""
        return float(self.angle[-1] - self.angle[0]) / (2.0 * np.pi)
