"""The verdict in words: sentences and tables made from its numbers, and from nothing else."""

from __future__ import annotations

from collections.abc import Sequence

from pipelines.diagnosis.prediction import FEWEST_FOR_P
from pipelines.diagnosis.verdict import ALARM, Finding, Verdict, decibels
from pipelines.io.grid import Grid

NAMES = {
    "difference_rms": "difference signal",
    "fm4": "FM4",
    "fm0": "FM0",
    "sideband_ratio": "sideband ratio",
    "envelope_orders": "envelope",
    "tooth_contrast": "energy of one tooth",
    "pass_order": "pass order in the envelope",
    "order_1": "1x",
    "order_2": "2x",
    "tsa_rms": "average",
    "tsa_kurtosis": "kurtosis of the average",
    "rms": "rms",
    "crest_factor": "crest factor",
    "kurtosis": "kurtosis",
}

INCREASE = "Increase: mean over all features of a component and all channels."
P_VALUE = (
    "p-value: the least of the features of a component, each the probability of such a level in a healthy machine, "
    "corrected for the number of features. It may be of another feature than the largest one."
)


def headline(verdict: Verdict) -> str:
    """The answer in one sentence."""
    first = verdict.first
    if verdict.alarm is None:
        return f"Largest increase: {first.component}, {_standing(first)}."
    if not verdict.alarm:
        return "No alarm: no feature exceeds the healthy recordings."
    if first.p is not None and first.p > ALARM:
        return f"Alarm, but of no single component: the signal as a whole has changed ({_strongest(verdict.whole)})."
    return f"Alarm: {first.component} exceeds the healthy recordings, {_standing(first)}."


def sentences(verdict: Verdict) -> tuple[str, ...]:
    """The answer, what it was compared with, how often it would be wrong, and what could not be looked at."""
    found = [headline(verdict)]
    if verdict.first.alike and verdict.alarm is not False:
        found.append(f"Its orders cannot be distinguished from those of {', '.join(verdict.first.alike)}.")
    found.append(compared(verdict))
    if verdict.left_out:
        found.append(f"Left out: {'; '.join(verdict.left_out)}.")
    return tuple(found)


def compared(verdict: Verdict) -> str:
    """What the recording was compared with, and the rate of false alarms."""
    many = f"{verdict.healthy} healthy recording{'s' if verdict.healthy > 1 else ''}"
    if verdict.alarm is None:
        return f"Compared with {many}. Give {FEWEST_FOR_P} or more for p-values and alarms."
    text = f"Compared with {many}. The model of normal levels gives an alarm for {100 * ALARM:g} % of healthy ones"
    if not verdict.tested:
        return f"{text}."
    low, high = verdict.false_alarm_interval
    return (
        f"{text}; tested against one another, {verdict.false_alarms} of these {verdict.tested} give one "
        f"({100 * low:.2g} to {100 * high:.2g} % with 95 % confidence)."
    )


def ranking_grid(verdict: Verdict) -> Grid:
    """All components, the highest rise first."""
    rows = tuple(
        (
            finding.component,
            decibels(finding.rise),
            probability(finding),
            _strongest(finding),
            "" if finding.tooth is None else str(finding.tooth),
            ", ".join(finding.alike),
        )
        for finding in (*verdict.findings, verdict.whole)
    )
    headers = ("component", "increase dB", "p-value", "largest feature", "tooth", "same orders as")
    return Grid(title="Components by their mean increase over the healthy recordings", headers=headers, rows=rows)


def evidence_grid(verdict: Verdict) -> Grid:
    """Every feature of every component."""
    rows = tuple(
        (finding.component, NAMES.get(one.feature, one.feature), decibels(one.rise), _p(one.p))
        for finding in (*verdict.findings, verdict.whole)
        for one in finding.evidence
    )
    return Grid(
        title="Features, mean over all channels", headers=("component", "feature", "increase dB", "p-value"), rows=rows
    )


def confirmed(verdict: Verdict, faulty: Sequence[tuple[str, int | None]]) -> str:
    """How the blind ranking fits what is known to be damaged, (component, tooth or None) each; "" if nothing is."""
    parts = []
    order = [finding.component for finding in verdict.findings]
    for component, tooth in faulty:
        if component not in order:
            parts.append(f"{component} is damaged and has no features")
            continue
        place = order.index(component)
        finding = verdict.findings[place]
        words = f"{component} is damaged and ranks {_ordinal(place + 1)} of {len(order)}"
        if place and order[0] in finding.alike:
            words += f", behind {order[0]}, which has the same orders"
        if tooth is not None and finding.tooth is not None:
            words += f"; tooth {tooth} is damaged, tooth {finding.tooth} is found"
        parts.append(words)
    return f"True damage, not used for the ranking: {'. '.join(parts)}." if parts else ""


def text(verdict: Verdict) -> str:
    """All of it for the terminal."""
    note = INCREASE if verdict.alarm is None else f"{INCREASE} {P_VALUE}"
    return "\n\n".join([" ".join(sentences(verdict)), ranking_grid(verdict).to_text().rstrip(), note]) + "\n"


def probability(finding: Finding) -> str:
    """The least corrected p-value of a component, "-" with a small baseline."""
    return _p(finding.p)


def _p(value: float | None) -> str:
    return "-" if value is None else f"{value:.1g}"


def _standing(finding: Finding) -> str:
    where = "" if finding.tooth is None else f", highest envelope energy at tooth {finding.tooth} (+- 1)"
    chance = "" if finding.p is None else f" (least p-value of a feature: {finding.p:.1g})"
    return f"{decibels(finding.rise)} dB in the mean of its features{chance}{where}"


def _strongest(finding: Finding) -> str:
    one = max(finding.evidence, key=lambda evidence: evidence.rise)
    return f"{NAMES.get(one.feature, one.feature)} {decibels(one.rise)} dB"


def _ordinal(number: int) -> str:
    return {1: "first", 2: "second", 3: "third"}.get(number, f"{number}th")


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]
