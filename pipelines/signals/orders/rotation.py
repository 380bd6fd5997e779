"""The rotation of a machine in a recording: the angle of its first shaft, and how well it is known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from pipelines.io.errors import InputError


class RotationError(InputError):
    """The angle cannot be had from a recording."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Rotation:
    """`angle` (time,) of the first shaft in rad, one value per sample of the recording.

    A recorded angle falls where the machine runs backwards; one from pulses or from the signal alone never falls, as
    neither knows the sense. `source` says in words where it comes from; `error` is the standard uncertainty of the
    mean speed, as a share of it; `absolute` is True where angle 0 is a mark on the shaft, so that the place of a tooth
    means something. With one pulse per turn the mark is that of the shaft with the tachometer, `mark`: other shafts
    pass theirs at angles nobody knows. Where `mark` is empty all shafts have theirs at 0. `conditional` are the shafts
    whose speed is only as right as the tooth numbers, or not well enough known, each with the reason.
    """

    angle: np.ndarray
    source: str
    error: float
    absolute: bool
    mark: str = ""
    conditional: Mapping[str, str] = field(default_factory=dict)

    def places_teeth(self, shaft: str) -> bool:
        """Whether the place of a tooth on a shaft means something."""
        return self.absolute and self.mark in ("", shaft)

    @property
    def turns(self) -> float:
        """How far the first shaft is in the end from where it began, in turns."""
        return float(self.angle[-1] - self.angle[0]) / (2.0 * np.pi)
