"""Step `verdict`: the ranking of components from the features of a run and of healthy ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pipelines.machine.plant import Drivetrain
    from pipelines.signals.orders.kinematics import Kinematics

STRIKES = {"outer-ring": "BPFO", "inner-ring": "BPFI", "element": "2 BSF"}


@dataclass(frozen=True, kw_only=True)
class VerdictSpec:
    """The machine, its `known_faults`, and whether the healthy run is the exact control, which its text states."""

    kinematics: Kinematics
    faulty: tuple[tuple[str, int | None], ...]
    exact: bool


def build(spec: VerdictSpec, *, own: dict[str, Any], healthy: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The verdict under "verdict" and as text under "words"; where there is none, None and the reason under "failure".

    Parameters
    ----------
    spec : the machine
    own, healthy : results of steps `features`
    """
    from pipelines.diagnosis.baseline import BaselineError
    from pipelines.diagnosis.verdict import judge
    from pipelines.diagnosis.words import found_words, text

    failure = next((one["failure"] for one in (own, *healthy) if one["failure"]), "")
    if failure:
        return {"verdict": None, "words": "", "failure": failure}
    try:
        verdict = judge(own["table"], [one["table"] for one in healthy], spec.kinematics, exact=spec.exact)
    except BaselineError as error:
        return {"verdict": None, "words": "", "failure": str(error)}
    parts = [text(verdict).rstrip(), found_words(verdict, spec.faulty)]
    return {"verdict": verdict, "words": "\n\n".join(filter(None, parts)) + "\n", "failure": ""}


def known_faults(plant: Drivetrain) -> tuple[tuple[str, int | None], ...]:
    """What the scene damages: component and tooth, None where it has none."""
    teeth = [(f"stage {fault.stage} {fault.gear}", fault.tooth) for fault in plant.faults]
    spalls = [(f"{fault.bearing} {STRIKES[fault.spall.on]}", None) for fault in plant.spalls]
    return (*teeth, *spalls, *((f"shaft_{fault.shaft + 1}", None) for fault in plant.shaft_faults))
