"""Checks shared by the machine's parts, and the errors of this package."""

from __future__ import annotations

import math

import numpy as np

from fem.options import check_options


class MachineError(ValueError):
    """A part of the machine is described by impossible or contradictory values."""


class EquilibriumError(RuntimeError):
    """The machine has no equilibrium at t = 0, or it was not found."""


class StepError(RuntimeError):
    """A time step did not converge, or the step size is outside the range of the method."""


class Options:
    """Base of options, see `fem.options.option`; MachineError if one is outside its limits."""

    def __post_init__(self) -> None:
        check_options(self, MachineError)


def positive(where: str, value: float, remedy: str = "") -> None:
    """Raise MachineError unless ``value`` is finite and > 0."""
    if not (math.isfinite(value) and value > 0):
        raise MachineError(f"{where}: {value!r} must be finite and greater than 0. {remedy}".rstrip())


def freeze_pairs(owner: object, name: str, places: str, levels: str) -> None:
    """Make two fields of an object read-only arrays (n,) of pairs.

    Parameters
    ----------
    owner, name : the object, and its name in messages
    places, levels : names of its fields, e.g. "times" and "torques"

    Raises
    ------
    MachineError : different lengths, no pair, values that are not finite, or places that do not increase strictly
    """
    for field in (places, levels):
        values = np.array(getattr(owner, field), dtype=float).reshape(-1)
        values.flags.writeable = False
        object.__setattr__(owner, field, values)
    at, values = getattr(owner, places), getattr(owner, levels)
    if len(at) != len(values) or len(at) == 0:
        raise MachineError(f"{name}: {len(at)} {places} for {len(values)} {levels}; give pairs.")
    if not (np.isfinite(at).all() and np.isfinite(values).all()):
        raise MachineError(f"{name}: {places} and {levels} must be finite.")
    if (np.diff(at) <= 0).any():
        i = int(np.argmax(np.diff(at) <= 0))
        raise MachineError(
            f"{name}: {at[i + 1]:g} follows {at[i]:g}, but its {places} must increase strictly. Spread a jump over at "
            "least one sample."
        )
