"""Result of a diagnosis: is the recording different from healthy ones, and which component is damaged?

`pipelines.diagnosis.judge` makes it, `pipelines.diagnosis.verdict_words` words it.
"""

from __future__ import annotations

from dataclasses import dataclass

from fem.storage import shown_html
from pipelines.signals.orders.kinematics import PARTS

DIFFERENT, ALARM = 0.01, 0.001  # probabilities that a healthy machine is called different, or damaged


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """Evidence of a component at the channel where it is strongest: the mean over a group of its `features`.

    `increase` is in dB over the healthy mean, `deviation` in standard deviations of the healthy recordings. A component
    whose deviation reaches `limit` is damaged. `p` is corrected for the number of components and channels, 0 for clear
    impacts. `limit` and `p` are None with fewer than FEWEST_FOR_P healthy recordings; `deviation` is then the increase.
    `impacts` is the level (dB) of clear impacts over the envelope spectrum around them, None if there are none.
    """

    features: tuple[str, ...]
    sensor: str
    axis: str
    increase: float
    deviation: float
    limit: float | None
    p: float | None
    impacts: float | None = None

    @property
    def ratio(self) -> float:
        """The deviation divided by its limit, or by 1 without a limit."""
        return self.deviation / (self.limit or 1.0)


@dataclass(frozen=True, kw_only=True)
class Finding:
    """A component with its evidence, and `alike`, the components with the same orders.

    `tooth` of a gear is in mesh when an impact begins; None if its position is not known or the gear shows no increase.
    `damaged` is None if the evidence has no limit. `repeating` is False if a smaller share of the vibration repeats
    with the shaft than in some healthy recording, so that damage of another shaft can be the cause of the evidence.
    `healthy` is the range of the evidence over its limit in the healthy recordings, each compared with the others; None
    if they are too few.
    """

    component: str
    evidence: Evidence
    damaged: bool | None
    repeating: bool
    alike: tuple[str, ...]
    tooth: int | None
    healthy: tuple[float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class Change:
    """A feature that differs at a channel: its increase (dB) and its deviation in standard deviations."""

    component: str
    feature: str
    sensor: str
    axis: str
    increase: float
    deviation: float


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Result of a diagnosis: is the recording different or damaged, and `findings`, the strongest evidence first.

    `different`, `damaged` and `p_different` are None with fewer than FEWEST_FOR_P healthy recordings. `p_different` is
    corrected for the number of features and channels. `changes` are the features that differ, the largest deviation
    first. `exact` means that the reference is a control. `at_speed` means that the levels of the healthy recordings
    depend on the speed and were taken at that of the recording.

    `tested` healthy recordings were diagnosed against the others; `false_differences` and `false_alarms` name those
    that were called different or damaged. `tested` is 0 if the others are too few. `healthy` counts the recordings of
    the reference without those that are `outlying`. `left_out` names shafts with too few turns or of conditional speed,
    and bearing parts whose pass order is not resolved, and the reason. `not_examined` are all gears, shafts and bearing
    parts without findings.
    """

    findings: tuple[Finding, ...]
    different: bool | None
    damaged: bool | None
    p_different: float | None
    changes: tuple[Change, ...]
    exact: bool
    healthy: int
    at_speed: bool
    outlying: tuple[str, ...]
    tested: int
    false_differences: tuple[str, ...]
    false_alarms: tuple[str, ...]
    left_out: tuple[str, ...]
    not_examined: tuple[str, ...]

    @property
    def first(self) -> Finding:
        """The component with the strongest evidence."""
        return self.findings[0]

    @property
    def candidates(self) -> tuple[str, ...]:
        """Shafts and bearing parts that are left out and whose damage can be the cause of the strongest evidence."""
        left_out = [one.partition(": ")[0] for one in self.left_out]
        shafts = [] if self.first.repeating else [one for one in left_out if not one.endswith(PARTS)]
        return (*(one for one in self.first.alike if one in left_out), *shafts)

    def __repr__(self) -> str:
        return f"<Verdict: {self._words()}; first {self.first.component}, {decibels(self.first.evidence.increase)} dB>"

    def _words(self) -> str:
        found = {True: "damaged", False: "no damage", None: "baseline too small to decide"}[self.damaged]
        found += f" ({', '.join(self.not_examined)} not examined)" if self.not_examined else ""
        return f"{found}, against {self.healthy} healthy recording{'' if self.healthy == 1 else 's'}"

    def _repr_html_(self) -> str:
        """The findings as a table, for a notebook."""
        rows = [
            (
                one.component,
                decibels(one.evidence.increase),
                f"{one.evidence.sensor} {one.evidence.axis}",
                None if one.evidence.p is None else f"{one.evidence.p:.1g}",
                one.tooth,
                ", ".join(one.alike),
            )
            for one in self.findings
        ]
        head = ("component", "increase, dB", "channel", "p-value", "tooth", "same orders as")
        return shown_html.table(self._words(), head, rows)


def decibels(increase: float) -> str:
    """An increase (dB) as text with a sign, without minus zero."""
    return f"{round(increase, 1) + 0.0:+.1f}"
