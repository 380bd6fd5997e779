"""A verdict as text: sentences and tables; `headline` is the first sentence of a report without known damage."""

from __future__ import annotations

from pipelines.diagnosis.baseline_checks import FEWEST_FOR_OUTLYING
from pipelines.diagnosis.deviation_statistics import FEWEST_FOR_P, clopper_pearson
from pipelines.diagnosis.impacts import CLEAR
from pipelines.diagnosis.verdict import ALARM, DIFFERENT, Evidence, Finding, Verdict, decibels
from pipelines.io.text_table import Grid, grid
from pipelines.signals.features.definitions import BY_NAME
from pipelines.signals.features.feature_table import left_out_words

STRENGTH = "evidence / limit"  # heading
EVIDENCE = (
    "Increase: mean of a group of features of a component at the channel of its strongest evidence. A component is "
    f"damaged if {STRENGTH} is 1 or more, a bearing also if it causes clear impacts; such a bearing ranks first."
)
NO_LIMIT = "Increase: mean of a group of features of a component at the channel where it is highest."
_NAMED = 3  # features that differ


def headline(verdict: Verdict) -> str:
    """The answer in one sentence."""
    named = " or ".join([f"{verdict.first.component}{_tooth(verdict.first)}", *verdict.candidates])
    if verdict.damaged is None:
        return f"Strongest evidence: {named}."
    if verdict.damaged:
        return f"Damaged: {named}."
    if verdict.different:
        component = "examined" if verdict.not_examined else "single"
        return f"Different from the healthy recordings, but no {component} component is damaged."
    if verdict.not_examined:
        return f"Not examined: {', '.join(verdict.not_examined)}; no other component exceeds its limit."
    return "No damage: no component exceeds its limit."


def answer(verdict: Verdict) -> str:
    """The answer in two words at most; "-" without limits."""
    if verdict.damaged is None:
        return "-"
    healthy = "incomplete" if verdict.not_examined else "no damage"
    return "damaged" if verdict.damaged else "different" if verdict.different else healthy


def sentences(verdict: Verdict) -> tuple[str, ...]:
    """Sentences: answer, evidence, reference, rates of false answers, and omitted components."""
    found = [headline(verdict)]
    if verdict.damaged is not False:
        found.append(f"Evidence: {standing(verdict.first.evidence)}.")
        alike = [one for one in verdict.findings if one.component in verdict.first.alike]
        found += [f"{one.component} has the same orders: {standing(one.evidence)}." for one in alike]
    if verdict.changes:
        named = [
            f"{BY_NAME[one.feature].words} of {one.component} at {one.sensor} {one.axis} ({decibels(one.increase)} dB)"
            for one in verdict.changes[:_NAMED]
        ]
        more = len(verdict.changes) - len(named)
        found.append(f"Features that differ: {', '.join(named)}{f' and {more} more' if more else ''}.")
    found += compared(verdict)
    if verdict.left_out:
        cause = "Damage there can raise the evidence of other components."
        if not verdict.first.repeating and verdict.damaged is not False:
            cause = (
                "Damage there can be the cause, since a smaller share of the vibration repeats with "
                f"{verdict.first.component} than in some healthy recording."
            )
        found.append(f"{left_out_words(verdict.left_out)} {cause}")
    return tuple(found)


def standing(evidence: Evidence) -> str:
    """Text with the evidence of a component and its limit."""
    count = len(evidence.features)
    what = BY_NAME[evidence.features[0]].words if count == 1 else f"mean of {count} features"
    text = f"{what} at {evidence.sensor} {evidence.axis} is {decibels(evidence.increase)} dB"
    if evidence.limit is not None:
        text += f", or {evidence.deviation:.1f} standard deviations (limit: {evidence.limit:.1f})"
    if evidence.impacts is not None:
        text += f", and {evidence.impacts:.0f} dB over the envelope spectrum around it (limit {CLEAR:g} dB)"
    return text


def compared(verdict: Verdict) -> list[str]:
    """Sentences on the reference of the comparison and on the rates of false answers."""
    if verdict.exact:
        return [
            "The reference is the same simulation without the fault, so that every increase is an effect of the fault. "
            f"The limits follow from the scatter of {verdict.healthy} samples of the sensor noise. Add --baseline 8 to "
            "compare with healthy machines of other deviations."
        ]
    found = [f"Compared with {verdict.healthy} healthy recording{'s' if verdict.healthy > 1 else ''}."]
    found += ["Their levels depend on the speed and are taken at that of this recording."] if verdict.at_speed else []
    if verdict.outlying:
        found.append(
            f"Left out because they differ from the other healthy recordings: {', '.join(verdict.outlying)}. "
            "Check them."
        )
    if verdict.healthy + len(verdict.outlying) < FEWEST_FOR_OUTLYING:
        found.append(f"Give {FEWEST_FOR_OUTLYING} or more to find a damaged one among them.")
    if verdict.damaged is None:
        return [*found, f"Give {FEWEST_FOR_P} or more for limits."]
    found.append(
        f"At these limits at most {100 * ALARM:g} % of healthy machines are called damaged and {100 * DIFFERENT:g} % "
        "different."
    )
    if verdict.tested:
        called = (verdict.false_alarms, verdict.false_differences)
        rates = (
            f"{100 * low:.2g} to {100 * high:.2g} %"
            for low, high in (clopper_pearson(len(one), verdict.tested) for one in called)
        )
        damaged, different = (f" ({', '.join(one)})" if one else "" for one in called)
        found.append(
            f"Of the {verdict.tested} healthy recordings, each compared with the others, {len(called[0])} are called "
            f"damaged{damaged} and {len(called[1])} different{different}. With 95 % confidence these rates are "
            f"{' and '.join(rates)}."
        )
    return found


def ranking_grid(verdict: Verdict) -> Grid:
    """Table of all components, the strongest evidence first, then those that are not examined."""
    found = [
        {
            "component": one.component,
            "increase dB": decibels(one.evidence.increase),
            STRENGTH: strength(one.evidence),
            "channel": f"{one.evidence.sensor} {one.evidence.axis}",
            "tooth": one.tooth,
            "same orders as": one.alike,
        }
        for one in verdict.findings
    ]
    others = [{"component": name, "channel": "not examined"} for name in verdict.not_examined]
    return grid("Components by their evidence", [*found, *others])


def text(verdict: Verdict) -> str:
    """Sentences and table for the terminal."""
    return "\n\n".join([" ".join(sentences(verdict)), ranking_grid(verdict).to_text().rstrip(), note(verdict)]) + "\n"


def note(verdict: Verdict) -> str:
    """Explanation of the columns of the ranking."""
    return NO_LIMIT if verdict.damaged is None else EVIDENCE


def strength(evidence: Evidence) -> str:
    """Evidence divided by its limit, as text; "-" without a limit."""
    return "-" if evidence.limit is None else f"{evidence.ratio:.2f}"


def _tooth(finding: Finding) -> str:
    return "" if finding.tooth is None else f", tooth {finding.tooth} (+- 1)"
