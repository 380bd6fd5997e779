"""Lines of a fault of a shaft: the orders 1 and 2 of its rotation in the spectrum.

The forces of unbalance and of a bent shaft turn with the shaft, 1x. Bending by a misaligned coupling changes sign twice
per turn, 2x (Randall 2011, Vibration-based Condition Monitoring, 2.2.1). These lines do not distinguish between faults
of the same shaft.
"""

from __future__ import annotations

from dataclasses import dataclass

from pipelines.signals.spectrum import LINE_HALF_WIDTH

ORDERS = (1, 2)
FEWEST_TURNS = LINE_HALF_WIDTH + 1  # in a window; the lower bins contain the static part of the signal


@dataclass(frozen=True, kw_only=True)
class ShaftLines:
    """The lines of a faulty `shaft`, which turns at `frequency` (Hz)."""

    shaft: str
    frequency: float

    def monitored(self) -> list[tuple[str, int, float]]:
        """Label, order and frequency (Hz) of every line."""
        return [(f"{k}x {self.shaft}", k, k * self.frequency) for k in ORDERS]


def readable(frequency: float, resolution: float, top: float) -> bool:
    """Whether a line (Hz) is resolved in a spectrum with the distance `resolution` of bins (Hz), up to `top` (Hz)."""
    return FEWEST_TURNS * resolution <= frequency < top - resolution
