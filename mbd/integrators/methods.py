"""METHODS: the time integrators by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fem.named_classes import named_class

if TYPE_CHECKING:
    from mbd.integrators.base import Integrator
    from mbd.system.system import System

METHODS = {
    "exponential": ("mbd.integrators.exponential", "exponential"),
    "trapezoidal": ("mbd.integrators.trapezoidal", "trapezoidal"),
    "generalised-alpha": ("mbd.integrators.generalised_alpha", "GeneralisedAlpha"),
}
COMPILED = ("exponential", "trapezoidal")  # those whose time loop is `mbd.integrators.modal_loop`


def make_integrator(name: str, system: System, step: float) -> Integrator:
    """The integrator of that name for a system and a time step (s).

    Raises
    ------
    ValueError : no such integrator
    """
    made: Integrator = named_class(METHODS, name, "integrator", ValueError)(system, step)
    return made


def compile_loop(name: str) -> None:
    """Compile the time loop of the integrator of that name, or read it from disk, before a machine is there."""
    if name in COMPILED:
        from mbd.integrators import modal_loop

        modal_loop.compile_loop()
