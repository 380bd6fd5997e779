"""Text, tables and JSON file of the study: the claims before the computation, and the verdict on each of them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipelines.io.text_table import Grid
from pipelines.studies.verification.published_claims import CLAIMS, UNTESTED, Claim, ClaimEvidence

if TYPE_CHECKING:
    import xarray

HOLDS, FAILS, OPEN = "holds", "does not hold", "undecided"


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """`mean` with its `standard_error`, both in the unit of the values; `verdict` is one of HOLDS, FAILS, OPEN."""

    mean: float
    standard_error: float
    verdict: str


def judge(values: Sequence[float] | np.ndarray, least: float) -> Judgement:
    """Whether the mean of one value per seed (seed,), of two or more, is at least a given limit.

    The 95 % confidence interval of the mean of n values with standard deviation s is +/- t s/sqrt(n), where t is the
    97.5 % point of Student's distribution with n - 1 degrees of freedom. A claim holds if the whole interval is above
    the limit, and does not hold if the whole interval is below. Otherwise it is undecided.

    References
    ----------
    Student (1908), Biometrika 6(1), 1-25.
    """
    from scipy.stats import t

    values = np.asarray(values, dtype=float)
    mean, error = float(values.mean()), float(values.std(ddof=1) / np.sqrt(values.size))
    reach = float(t.ppf(0.975, values.size - 1)) * error
    over = mean - least
    verdict = HOLDS if over >= reach else FAILS if over <= -reach else OPEN
    return Judgement(mean=mean, standard_error=error, verdict=verdict)


_WORDS = {"static-torque": "constant torque", "none": "no losses"}
RULE = (
    "Each cell gives the mean over the seeds of the deviations ± its standard error, in dB, and a verdict. The 95 % "
    "confidence interval of the mean (Student) is ± 2.8 standard errors for five seeds. A claim holds if the whole "
    "interval is at least the limit. It does not hold if the whole interval is below the limit. Otherwise it is "
    "undecided."
)

Verdicts = dict[str, list[tuple[Claim, dict[str, Judgement]]]]


def stated() -> str:
    """All claims with their measures and limits, as they are printed before anything is computed."""
    parts = []
    for heading, claims in CLAIMS.items():
        rows = tuple((claim.words, claim.measure, f"{claim.least:g}") for claim in claims)
        parts.append(Grid(title=heading, headers=("claim", "measure", "at least, dB"), rows=rows).to_text())
    return "\n\n".join([RULE, *parts]) + "\n"


def verdicts(evidence: ClaimEvidence) -> Verdicts:
    """The judgements on every claim, one for each condition, by heading."""
    return {
        heading: [
            (
                claim,
                {
                    name: judge(values.values, claim.least)
                    for name, values in _conditions(claim.compare(evidence, claim.measure))
                },
            )
            for claim in claims
        ]
        for heading, claims in CLAIMS.items()
    }


def grids(found: Verdicts) -> Iterator[Grid]:
    """One table per group of claims: a row per claim, a column per condition."""
    for heading, judged in found.items():
        rows = tuple(
            (
                claim.words,
                f"{claim.least:g}",
                *(f"{one.mean:+.1f} ± {one.standard_error:.1f} {one.verdict}" for one in by_condition.values()),
            )
            for claim, by_condition in judged
        )
        yield Grid(title=heading, headers=("claim", "at least, dB", *judged[0][1]), rows=rows)


def reasons(found: Verdicts) -> dict[str, str]:
    """Reasons why claims do not hold or are undecided, by heading, each once; "" if all claims hold."""
    return {
        heading: " ".join(
            dict.fromkeys(
                reason
                for claim, by_condition in judged
                if any(one.verdict != HOLDS for one in by_condition.values())
                for reason in claim.reasons
            )
        )
        for heading, judged in found.items()
    }


def text(found: Verdicts) -> str:
    """Tables and reasons for the terminal."""
    return _with_reasons(found, [grid.to_text() for grid in grids(found)])


def markdown(found: Verdicts) -> str:
    """Tables and reasons for a page."""
    return _with_reasons(found, [f"**{grid.title}**\n\n{grid.to_markdown()}" for grid in grids(found)])


def write(folder: Path, evidence: ClaimEvidence, found: Verdicts, facts: Mapping[str, Any]) -> tuple[Path, Path]:
    """Write claims.md and claims.json: the verdicts, and all measures of all seeds.

    Parameters
    ----------
    folder : of both files, created if it does not exist
    evidence, found : the measures and the verdicts
    facts : provenance for the head of claims.json

    Raises
    ------
    OSError : nothing can be written there
    """
    folder.mkdir(parents=True, exist_ok=True)
    page, data = folder / "claims.md", folder / "claims.json"
    page.write_text(markdown(found), encoding="utf-8")
    content = {
        **facts,
        "claims": [
            {
                "heading": heading,
                "claim": claim.words,
                "measure": claim.measure,
                "least_dB": claim.least,
                "conditions": {name: asdict(one) for name, one in by_condition.items()},
            }
            for heading, judged in found.items()
            for claim, by_condition in judged
        ],
        "levels": evidence.levels.to_dict(),
        "loads": evidence.loads.to_dict(),
    }
    data.write_text(json.dumps(content, indent=1), encoding="utf-8")
    return page, data


def _with_reasons(found: Verdicts, tables: list[str]) -> str:
    """An explanation of the tables, each table with its reasons, and the claims without a table."""
    parts = [part for both in zip(tables, reasons(found).values(), strict=True) for part in both if part]
    return "\n\n".join([RULE, *parts, *(f"{words}: {why}" for words, why in UNTESTED.items())]) + "\n"


def _conditions(values: xarray.DataArray) -> Iterator[tuple[str, xarray.DataArray]]:
    """Values (seed,) by the text of their condition: the load or the interval of time, then the losses."""
    where = next(str(name) for name in values.dims if name not in ("losses", "seed"))
    for losses in values.losses.values:
        for place in values[where].values:
            words = f"{_WORDS.get(str(place), str(place))}, {_WORDS.get(str(losses), str(losses))}"
            yield words, values.sel({where: place, "losses": losses})
