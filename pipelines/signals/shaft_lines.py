"""Lines of a fault of a shaft: the orders 1 and 2 of its rotation in the spectrum.

Unbalance and a bent shaft turn with the shaft, 1x; what a misaligned coupling bends changes sign twice a turn, 2x
(Randall 2011, Vibration-based Condition Monitoring, 2.2.1). Faults of one shaft share its lines: which of them it is,
lines alone do not tell.
"""

from __future__ import annotations

from dataclasses import dataclass

from pipelines.signals.lines import LineTable
from pipelines.signals.spectrum import LINE_HALF_WIDTH

ORDERS = (1, 2)
FEWEST_TURNS = LINE_HALF_WIDTH + 1  # in a window: what stands still fills the bins below


@dataclass(frozen=True, kw_only=True)
class ShaftLines:
    """What is looked for of one fault: `fault` in words; `shaft` its name, which turns at `frequency` (Hz); `main` its
    strongest order."""

    fault: str
    shaft: str
    frequency: float
    main: int

    def wanted(self) -> list[tuple[str, int, float]]:
        """Label, order and frequency (Hz) of every line."""
        return [(f"{k}x {self.shaft}", k, k * self.frequency) for k in ORDERS]

    def own(self, lines: LineTable) -> LineTable:
        """Its rows among the lines of a case and window."""
        names = {name for name, _, _ in self.wanted()}
        return lines.at([i for i, label in enumerate(lines.label) if lines.kind[i] == "shaft" and label in names])

    def grade(self, lines: LineTable) -> str:
        """ "seen", "partly" (the other order is detected) or "not seen" in the lines of one case and window."""
        own = self.own(lines)
        if own.where(order=self.main).detected.any():
            return "seen"
        return "partly" if own.detected.any() else "not seen"

    def sentence(self, lines: LineTable) -> str:
        """Levels of its lines in one case and window, against the control."""
        own = self.own(lines)
        parts = [
            f"{own.label[i]} = {own.frequency[i]:.4g} Hz has {own.faulty[i]:.3g} m/s², {own.difference[i]:+.1f} dB "
            f"over the control's {own.healthy[i]:.3g} m/s² and {own.over_floor[i]:+.1f} dB over its floor: "
            f"{'' if own.detected[i] else 'not '}detected"
            for i in range(len(own))
        ]
        missing = [name for name, _, _ in self.wanted() if name not in own.label]
        if missing:
            parts.append(
                f"{' and '.join(missing)} cannot be read: the window holds fewer than {FEWEST_TURNS} periods, or the "
                "line lies beyond half of the sampling rate"
            )
        return f"{'; '.join(parts)}."


def criterion() -> str:
    """What it takes for a fault of a shaft to be seen."""
    return (
        "a fault of a shaft is seen if its main order in the spectrum is detected (1x of unbalance and bow, 2x of a "
        "misaligned coupling)"
    )


def readable(frequency: float, resolution: float, top: float) -> bool:
    """Whether a line (Hz) can be told in a spectrum of a resolution (Hz) up to `top` (Hz)."""
    return FEWEST_TURNS * resolution <= frequency < top - resolution
