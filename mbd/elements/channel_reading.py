"""Reading: one channel as a linear function of the motion, value = D q + V q' + A q'' + L lambda + rigid part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fem.named_classes import named_class

FURTHER = {  # channels that a scene asks for by name; each a component with a `kind`
    "bearing-misalignment": ("mbd.parts.misalignment", "BearingMisalignment"),
}


def further_class(name: str, error: type[Exception]) -> Any:
    """The class of a further channel; `error` if there is none of that name."""
    return named_class(FURTHER, name, "channel", error)


@dataclass(eq=False)
class Reading:
    """Coefficients of one channel; rows are (coordinate,) or (force,), ``rigid`` is on (phi_m, phi_m', phi_m'')."""

    units: str
    displacement: np.ndarray | float = 0.0
    velocity: np.ndarray | float = 0.0
    acceleration: np.ndarray | float = 0.0
    forces: np.ndarray | float = 0.0
    rigid: tuple[float, float, float] = (0.0, 0.0, 0.0)
    shift: np.ndarray | None = None  # (3,) motion by which it reads 1 m along x, y, z; None: that of its coordinates
    vibration: bool = False  # used for the error estimate of the time step


@dataclass(frozen=True, kw_only=True)
class ChannelKind:
    """A variable of the results: the channels ``thing:quantity`` of all things along the first of `dims`.

    With `labels`, the coordinates of the last of `dims`, there is one channel ``thing:quantity + label`` for each.
    Without `dims` the variable is one channel, whose whole name is `quantity`.
    """

    variable: str
    dims: tuple[str, ...]
    quantity: str
    text: str
    labels: tuple[str, ...] = ()

    def spelled(self, thing: str) -> tuple[str, ...]:
        """Names of the channels of a thing."""
        return tuple(f"{thing}:{self.quantity}{label}" for label in self.labels or ("",))
