"""Checks of gear data: the error that all gear modules raise, and `require`, which raises it."""

from __future__ import annotations


class GeometryError(ValueError):
    """Gear data that describe no valid gear or pair."""


def require(condition: bool, message: str) -> None:
    """Raise GeometryError(message) unless the condition holds."""
    if not condition:
        raise GeometryError(message)
