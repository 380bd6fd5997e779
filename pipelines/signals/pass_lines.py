"""Lines of a spalled rolling bearing: harmonics of its pass frequency in the envelope, with sidebands.

Each passage of a spall excites the machine by an impact. A spall of the outer ring stays in the load zone. A spall of
the inner ring passes through it once per turn of the shaft, one of a rolling element once per turn of the cage; their
lines have sidebands at this distance (Randall & Antoni 2011, Mech. Syst. Signal Process. 25, 485-520). A spall of an
element meets both races once per turn of the element: 2 BSF.
"""

from __future__ import annotations

from dataclasses import dataclass

from pipelines.signals.line_table import LineTable

HARMONICS = 3
SIDEBANDS = 2  # to each side


@dataclass(frozen=True, kw_only=True)
class PassLines:
    """Monitored lines of one spall.

    `label` is a name such as "bearing_3 BPFO", `fault` describes the spall, and `frequency` (Hz) is that of its
    passages. The sidebands have the distance `spacing` (Hz), named `spacing_label`; 0 and "" without sidebands.
    `spread` is the relative change of the frequency by slip of the cage.
    """

    label: str
    fault: str
    frequency: float
    spacing: float = 0.0
    spacing_label: str = ""
    spread: float = 0.0

    def monitored(self) -> list[tuple[str, int, float]]:
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
        """The rows of this spall among the lines of a case and window."""
        names = {name for name, _, _ in self.monitored()}
        return lines.at([i for i, label in enumerate(lines.label) if lines.kind[i] == "pass" and label in names])
