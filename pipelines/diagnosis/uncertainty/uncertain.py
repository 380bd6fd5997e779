"""What is not known well of a plant's casing, and what to set where the error of its mesh is unknown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fem.casing.models.casing import Casing
from fem.casing.reduced.modes import CasingModes
from fem.casing.uncertainty.extrapolation import RIGID_MOTIONS, LowestModes, measured_limits
from fem.casing.uncertainty.frequency_errors import FrequencyErrors, frequency_errors


@dataclass(frozen=True, eq=False, kw_only=True)
class Uncertain:
    """The errors of the frequencies of a casing (None: not known) and the spread of its damping.

    `damping_spread`: its ratios are off by a factor of up to 1 + spread, 5 to 95 %; `remedy` is said where the errors
    are not known.
    """

    errors: FrequencyErrors | None
    damping_spread: float
    remedy: str


def uncertain(
    casing: Casing, modes: CasingModes | None, coarser: Sequence[LowestModes], damping_spread: float
) -> Uncertain:
    """What is not known well.

    Parameters
    ----------
    casing : model of the casing
    modes, coarser : of an extrapolated casing, on its own mesh and on the coarser ones
    damping_spread : of the damping ratios
    """
    if modes is not None and coarser:
        first = RIGID_MOTIONS if modes.ground == "springs" else 0
        errors = frequency_errors(measured_limits(modes, coarser), first)
        return Uncertain(errors=errors, damping_spread=damping_spread, remedy="")
    return Uncertain(errors=None, damping_spread=damping_spread, remedy=casing.remedy)
