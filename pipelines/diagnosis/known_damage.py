"""Known damage in several cases: in how many of them the diagnosis finds it, and its evidence.

`sentences` words the first sentence of a report if damage is known, else `pipelines.diagnosis.verdict_words`.

A case is a window of a run with a load and a set of deviations. The diagnosis does not use the known damage. Damage is
found if the damaged component exceeds its limit and no undamaged component has stronger evidence. Two equal bearings on
one shaft have the same pass orders, thus the same evidence, and both are found.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pipelines.diagnosis import verdict_words
from pipelines.diagnosis.verdict import Finding, Verdict, decibels
from pipelines.io.text_table import Grid, grid
from pipelines.signals.line_table import LOADS


@dataclass(frozen=True, kw_only=True)
class Damage:
    """A component that is known to be damaged, with its `tooth` (None if it has none) and a description."""

    component: str
    tooth: int | None
    words: str


@dataclass(frozen=True, kw_only=True)
class Case:
    """The verdict on a window; `deviations` are "off" or "seed <n>"."""

    load: str
    deviations: str
    window: str
    verdict: Verdict

    @property
    def name(self) -> str:
        """Window, load and deviations as text."""
        return f"{self.window}, {LOADS.get(self.load, self.load)}, {deviation_words(self.deviations)}"


def deviation_words(deviations: str) -> str:
    """Text for deviations: "error-free gears" or "deviations of seed <n>"."""
    return "error-free gears" if deviations == "off" else f"deviations of {deviations}"


def found(case: Case, damage: Damage, damages: Sequence[Damage]) -> Finding | None:
    """The finding of a damaged component if the diagnosis finds it, None otherwise.

    `damages` are all known damages. Their components may have stronger evidence.
    """
    others = {other.component for other in damages} - {damage.component}
    ranked = [one for one in case.verdict.findings if one.component not in others]
    strongest = ranked[0].evidence.ratio
    own = (one for one in ranked if one.component == damage.component and one.damaged)
    return next((one for one in own if one.evidence.ratio == strongest), None)


def _tied(verdict: Verdict, one: Finding) -> list[str]:
    """Components with the same orders and the same evidence as a finding."""
    others = (other for other in verdict.findings if other.component in one.alike)
    return [other.component for other in others if other.evidence.ratio == one.evidence.ratio]


def any_found(cases: Sequence[Case], damages: Sequence[Damage]) -> bool | None:
    """Whether a known damage is found in any case, or any damage if none is known; None if that is not decided."""
    if all(case.verdict.damaged is None for case in cases):
        return None
    if not damages:
        return any(case.verdict.damaged for case in cases) or (
            None if any(case.verdict.not_examined for case in cases) else False
        )
    return any(found(case, damage, damages) is not None for case in cases for damage in damages) or (
        None if any(_without_findings(case, damage) for case in cases for damage in damages) else False
    )


def _without_findings(case: Case, damage: Damage) -> bool:
    """Whether a damaged component is not examined."""
    return all(one.component != damage.component for one in case.verdict.findings)


def sentences(cases: Sequence[Case], damages: Sequence[Damage]) -> list[str]:
    """Sentences on how many cases each damage is found in, with its weakest evidence; the verdict if none is known."""
    if not damages:
        count = sum(bool(case.verdict.damaged) for case in cases)
        answer = f"Damage is found in {count or 'none'} of {len(cases)} case{'s' if len(cases) > 1 else ''}."
        return [*([answer] if len(cases) > 1 else []), *verdict_words.sentences(cases[0].verdict)]
    answers, evidence = [], []
    for damage in damages:
        findings = [(case, one) for case in cases if (one := found(case, damage, damages)) is not None]
        unseen = [case for case in cases if _without_findings(case, damage)]
        answer = f"found in {len(findings)} of {len(cases)} cases{f', not examined in {len(unseen)}' if unseen else ''}"
        if len(cases) == 1:
            answer = "found" if findings else "not examined" if unseen else "not found"
        answers.append(f"{damage.words[0].upper()}{damage.words[1:]}: {answer}.")
        if findings:
            case, one = min(findings, key=lambda pair: pair[1].evidence.ratio)
            weakest = "Weakest evidence" if len(findings) > 1 else "Evidence"
            evidence.append(f"{weakest} ({case.name}): {verdict_words.standing(one.evidence)}.")
            evidence += [f"{other} has the same evidence." for other in _tied(case.verdict, one)]
            evidence += _tooth_words(damage, [one.tooth for _, one in findings])
        elif unseen:
            verdict = unseen[0].verdict
            evidence += [
                f"{one} ({unseen[0].name})." for one in verdict.left_out if damage.component in one.partition(": ")[0]
            ]
            evidence.append(f"Strongest evidence of the other components: {_nearest(cases, damage)}.")
            shared = f"{damage.component} has the same orders as the {verdict.first.component} and can be the cause."
            evidence += [shared] if damage.component in verdict.first.alike else []
        elif any(case.verdict.damaged for case in cases):
            evidence.append(f"Another component has the strongest evidence: {_nearest(cases, damage)}.")
        else:
            evidence.append(f"Nearest evidence of damage: {_nearest(cases, damage)}.")
            evidence.append("`gearcase detect` finds the size of damage that is detected.")
    return [" ".join(answers), *evidence, *verdict_words.compared(cases[0].verdict)]


def _tooth_words(damage: Damage, teeth: Sequence[int | None]) -> list[str]:
    """Where the impact begins; cracks have no impact, so that their tooth is stated only if it is right."""
    wrong = Counter(tooth for tooth in teeth if tooth not in (None, damage.tooth))
    right = teeth.count(damage.tooth)
    if damage.tooth is None or (not right and (not wrong or damage.words.startswith("cracked"))):
        return []
    parts = [f"at tooth {damage.tooth}{f' in {right} of {len(teeth)}' if len(teeth) > 1 else ''}"] if right else []
    parts += [f"at tooth {tooth}{f' in {count}' if len(teeth) > 1 else ''}" for tooth, count in wrong.items()]
    other = "" if right else f", not at tooth {damage.tooth}"
    return [f"The impact begins {', '.join(parts)}{other}."]


def _nearest(cases: Sequence[Case], damage: Damage) -> str:
    """The finding that is nearest to its limit, and that of the damaged component."""
    ranked = [(case, one) for case in cases for one in case.verdict.findings]
    case, first = max(ranked, key=lambda pair: pair[1].evidence.ratio)
    own = [one for _, one in ranked if one.component == damage.component]
    texts = [f"{first.component} ({case.name}), {verdict_words.standing(first.evidence)}"]
    if own and first not in own:
        best = max(own, key=lambda one: one.evidence.ratio)
        texts.append(f"{best.component}, {verdict_words.standing(best.evidence)}")
    return "; ".join(texts)


def cases_grid(cases: Sequence[Case], damages: Sequence[Damage]) -> Grid:
    """Table with one row for each case and damage: evidence of the damaged component, its rank, and the tooth."""
    rows = []
    for case in cases:
        ranked = {one.component: (place, one) for place, one in enumerate(case.verdict.findings, 1)}
        known = {"load": LOADS.get(case.load, case.load), "deviations": case.deviations, "window": case.window}
        for damage in damages:
            row: dict[str, Any] = {**known, "damaged": damage.component, "answer": "not examined"}
            if damage.component in ranked:
                place, one = ranked[damage.component]
                row |= {
                    "answer": "not found" if found(case, damage, damages) is None else "found",
                    "increase dB": decibels(one.evidence.increase),
                    verdict_words.STRENGTH: verdict_words.strength(one.evidence),
                    "channel": f"{one.evidence.sensor} {one.evidence.axis}",
                    "rank": place,
                    "tooth": one.tooth,
                }
            rows.append(row)
    return grid("The diagnosis next to the damage of the scene, which it does not use", rows)


def text(cases: Sequence[Case], damages: Sequence[Damage]) -> str:
    """Sentences and tables for the terminal."""
    first = cases[0]
    parts = [" ".join(sentences(cases, damages))]
    parts += [cases_grid(cases, damages).to_text().rstrip()] if damages else []
    parts += [
        f"{first.name}:",
        verdict_words.ranking_grid(first.verdict).to_text().rstrip(),
        verdict_words.note(first.verdict),
    ]
    return "\n\n".join(parts) + "\n"
