"""Places in messages."""

from __future__ import annotations

from collections.abc import Iterable


def in_mm(place: Iterable[float]) -> str:
    """A place given in metres as text, such as "(12.5, 0, -3) mm"."""
    return f"({', '.join(f'{round(1000 * value, 6) + 0.0:.5g}' for value in place)}) mm"
