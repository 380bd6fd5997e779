"""A casing in one piece, factorised with its interface held, against which its reductions are checked."""

from __future__ import annotations

from dataclasses import dataclass

from fem.casing.reduced.grounded import AssembledCasing
from fem.casing.reduced.reduction import Interface, held_interface


@dataclass(frozen=True, eq=False, kw_only=True)
class FactoredCasing(AssembledCasing):
    """A casing with its factor and constraint modes."""

    interface: Interface


def factored(casing: AssembledCasing) -> FactoredCasing:
    """A casing that is not divided, factorised."""
    springs = casing.springs if casing.ground == "springs" else None
    interface = held_interface(casing.K_free, casing.rows, penalty=springs, loads=casing.loads)
    return FactoredCasing(**vars(casing), interface=interface)
