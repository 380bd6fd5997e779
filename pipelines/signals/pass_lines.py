"""Lines of a spalled rolling bearing: harmonics of its pass frequency in the envelope, with sidebands.

Every passage of a spall rings the machine. A spall of the outer ring stays in the load zone; one of the inner ring
turns through it with the shaft, one of an element with the cage, and their lines have sidebands at that rate (Randall &
Antoni 2011, Mech. Syst. Signal Process. 25, 485-520). A spall of an element meets both races in a turn: 2 BSF.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.signals.lines import LineTable
from pipelines.signals.spectrum import Spectrum

HARMONICS = 3
SIDEBANDS = 2  # to each side


@dataclass(frozen=True, kw_only=True)
class PassLines:
    """What is looked for of one spall.

    `label` "bearing_3 BPFO"; `fault` in words; `frequency` of its passages (Hz); `spacing` (Hz) of its sidebands and
    `spacing_label`, 0 and "" without; `spread` by slip of the cage, as a share of the frequency.
    """

    label: str
    fault: str
    frequency: float
    spacing: float = 0.0
    spacing_label: str = ""
    spread: float = 0.0

    def wanted(self) -> list[tuple[str, int, float]]:
        """Label, number of the harmonic and frequency (Hz) of every line."""
        found = []
        sides = range(-SIDEBANDS, SIDEBANDS + 1) if self.spacing else (0,)
        for k in range(1, HARMONICS + 1):
            for side in sides:
                name = self.label if k == 1 else f"{k} x {self.label}"
                if side:
                    many = "" if abs(side) == 1 else f"{abs(side)} "
                    name += f" {'+' if side > 0 else '-'} {many}{self.spacing_label}"
                found.append((name, k, k * self.frequency + side * self.spacing))
        return found

    def own(self, lines: LineTable) -> LineTable:
        """Its rows among the lines of a case and window."""
        names = {name for name, _, _ in self.wanted()}
        return lines.at([i for i, label in enumerate(lines.label) if lines.kind[i] == "pass" and label in names])


def peaks(spectrum: Spectrum, frequencies: Sequence[float], reach: Sequence[float]) -> np.ndarray:
    """Largest amplitude (line,) within ``reach`` (Hz) of each frequency (Hz), that of the nearest bin at least."""
    found = []
    for frequency, width in zip(frequencies, reach, strict=True):
        low, high = (frequency - width) / spectrum.resolution, (frequency + width) / spectrum.resolution
        nearest = round(frequency / spectrum.resolution)
        found.append(spectrum.amplitude[min(math.ceil(low), nearest) : max(math.floor(high), nearest) + 1].max())
    return np.array(found)
