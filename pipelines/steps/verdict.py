"""Step `verdict`: what is damaged, from the features of the motions of a run and of healthy ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pipelines.diagnosis.known_damage import Damage
    from pipelines.machine.machine_model import Drivetrain
    from pipelines.signals.orders.kinematics import Kinematics


def build(
    kinematics: Kinematics,
    damages: tuple[Damage, ...],
    cases: tuple[tuple[str, str], ...],
    exact: bool,
    *,
    own: Sequence[dict[str, Any]],
    healthy: Sequence[dict[str, Any]],
) -> dict[str, Any]:
    """The verdicts under "cases" and as text under "words"; where there are none, the reason under "failure".

    Parameters
    ----------
    kinematics, damages : the machine, and what is known to be damaged
    cases : load and deviations of each
    exact : whether the healthy runs are the exact controls of the cases
    own, healthy : results of steps `features`: of every case, and of its control, or of all healthy machines
    """
    from pipelines.diagnosis.baseline_checks import BaselineError
    from pipelines.diagnosis.judge import judge
    from pipelines.diagnosis.known_damage import Case, text

    failure = next((one["failure"] for one in (*own, *healthy) if one["failure"]), "")
    chance = next((one["chance"] for one in (*own, *healthy) if one["chance"]), "") if exact else ""
    if chance and not failure:
        failure = (
            f"{chance}, so that differences from the healthy control need not be effects of the fault. Increase the "
            "load, or compare with other healthy machines: --baseline 8."
        )
    found = []
    try:
        for number, ((load, deviations), one) in enumerate(zip(cases, own, strict=True)):
            others = [healthy[number]] if exact else healthy
            for window, (table,) in one["tables"].items() if not failure else ():
                reference = [table for other in others for table in other["tables"][window]]
                verdict = judge(table, reference, kinematics, exact=exact)
                found.append(Case(load=load, deviations=deviations, window=window, verdict=verdict))
    except BaselineError as error:
        failure = str(error)
    if failure:
        return {"cases": (), "words": "", "failure": failure}
    return {"cases": tuple(found), "words": text(found, damages), "failure": ""}


def known_damages(machine: Drivetrain) -> tuple[Damage, ...]:
    """What the scene damages: component, tooth (None where it has none) and words."""
    from pipelines.diagnosis.known_damage import Damage
    from pipelines.machine.scene_kinematics import STRIKES

    teeth = [(f"stage {fault.stage} {fault.gear}", fault.tooth) for fault in machine.faults]
    spalls = [(f"{fault.bearing} {STRIKES[fault.spall.on]}", None) for fault in machine.spalls]
    shafts = [(f"shaft_{fault.shaft + 1}", None) for fault in machine.shaft_faults]
    return tuple(
        Damage(component=component, tooth=tooth, words=words.replace("-tooth", " tooth"))
        for (component, tooth), words in zip([*teeth, *spalls, *shafts], machine.fault_words, strict=True)
    )
