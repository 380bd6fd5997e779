"""Uncertain properties of a casing: errors of its natural frequencies by the mesh, and its damping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fem.casing.models.casing import CasingModel
from fem.casing.reduced.casing_modes import CasingModes
from fem.casing.uncertainty.extrapolation import RIGID_MOTIONS, LowestModes, measured_limits
from fem.casing.uncertainty.frequency_errors import FrequencyErrors, frequency_errors


@dataclass(frozen=True, eq=False, kw_only=True)
class Uncertain:
    """Errors of the natural frequencies of a casing (None if not known) and spread of its damping.

    In 90 % of the samples the damping ratios are multiplied by a factor between 1/(1 + `damping_spread`) and
    1 + `damping_spread`. `remedy` is the setting that makes the errors of the frequencies known, "" if they are known.
    """

    errors: FrequencyErrors | None
    damping_spread: float
    remedy: str


def uncertain(
    casing: CasingModel, modes: CasingModes | None, coarser: Sequence[LowestModes], damping_spread: float
) -> Uncertain:
    """The uncertain properties of a casing.

    Parameters
    ----------
    casing : model of the casing
    modes, coarser : modes of an extrapolated casing on its mesh, and on the coarser ones; None and empty for others
    damping_spread : relative spread of the damping ratios, 5 to 95 %
    """
    if modes is not None and coarser:
        first = RIGID_MOTIONS if modes.ground == "springs" else 0
        errors = frequency_errors(measured_limits(modes, coarser), first)
        return Uncertain(errors=errors, damping_spread=damping_spread, remedy="")
    return Uncertain(errors=None, damping_spread=damping_spread, remedy=casing.remedy)
