"""The rotation of a machine in a recording: the angle of its first shaft, with its source and uncertainty."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from pipelines.io.errors import InputError


class RotationError(InputError):
    """The angle of rotation cannot be determined from a recording."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Rotation:
    """`angle` (time,) of the first shaft in rad, one value for each sample of the recording.

    A recorded angle decreases where the machine runs backwards. An angle from pulses or from the vibration never
    decreases, since the sense of rotation is not known. `source` describes its origin; `error` is the standard
    uncertainty of the mean speed, relative.

    `absolute` is True if angle 0 is a mark on a shaft, so that positions of teeth are known. With one tachometer pulse
    per turn the mark is on the shaft named `mark`, and positions on other shafts are not known. If `mark` is empty, all
    shafts have a mark at angle 0. `conditional` maps shafts to the reason why their speed is uncertain: it depends on
    the tooth numbers, or is not known well enough. `likely` is the most likely speed relative to that of the angle.
    """

    angle: np.ndarray
    source: str
    error: float
    absolute: bool
    mark: str = ""
    conditional: Mapping[str, str] = field(default_factory=dict)
    likely: float = 1.0

    def places_teeth(self, shaft: str) -> bool:
        """Whether the positions of teeth on a shaft are known."""
        return self.absolute and self.mark in ("", shaft)

    @property
    def origin(self) -> str:
        """Uncertainty and source of the speed, and the shafts of conditional speed, as text behind a speed."""
        known = f" (known to {percent(self.error)} %)" if self.error else ""
        conditional = "".join(
            f" The speed of {shaft} is conditional: {reason}." for shaft, reason in self.conditional.items()
        )
        return f"{known}. Source: {self.source}.{conditional}"


def percent(error: float) -> str:
    """A relative uncertainty as text, in %."""
    return "< 0.001" if 0.0 < error < 1e-5 else f"{100 * error:.1g}"
