"""METHODS: the time integrators by name."""

from __future__ import annotations

from collections.abc import Callable

from mbd.integrators.base import Integrator
from mbd.integrators.exponential import exponential
from mbd.integrators.generalised_alpha import GeneralisedAlpha
from mbd.integrators.reference import Reference
from mbd.integrators.trapezoidal import trapezoidal
from mbd.system.system import System

METHODS: dict[str, Callable[[System, float], Integrator]] = {
    "exponential": exponential,
    "trapezoidal": trapezoidal,
    "generalised-alpha": GeneralisedAlpha,
    "reference": Reference,
}
