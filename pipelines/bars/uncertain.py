"""What is not known well of a plant's casing, and what to set where the error of its mesh is unknown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fem.casing.mesh_error.extrapolation import RIGID_MOTIONS, LowestModes, measured_limits
from fem.casing.reduced.modes import CasingModes
from fem.casing.uncertain.frequency_errors import FrequencyErrors, frequency_errors
from pipelines.plant.casing import CasingPart, ElasticPart, MatricesPart

EXTRAPOLATE = "set casing.extrapolated = true, which computes further meshes, and run the scene again"


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
    part: CasingPart | None, modes: CasingModes | None, coarser: Sequence[LowestModes], damping_spread: float
) -> Uncertain:
    """What is not known well.

    Parameters
    ----------
    part : the casing of a plant
    modes, coarser : of an extrapolated casing, on its own mesh and on the coarser ones
    damping_spread : of the damping ratios
    """
    if modes is not None and coarser:
        first = RIGID_MOTIONS if modes.ground == "springs" else 0
        errors = frequency_errors(measured_limits(modes, coarser), first)
        return Uncertain(errors=errors, damping_spread=damping_spread, remedy="")
    remedy = 'it has no finite elements; set casing.model = "craig-bampton"'
    if isinstance(part, ElasticPart):
        remedy = EXTRAPOLATE
    elif isinstance(part, MatricesPart):
        remedy = "the matrices come from another program"
    return Uncertain(errors=None, damping_spread=damping_spread, remedy=remedy)
