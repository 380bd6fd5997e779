"""The blind verdict of a run: features of its motion and of healthy ones, and the ranking that follows."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.engine.step import Step
from pipelines.runs import run_folder
from pipelines.steps.study import Study

if TYPE_CHECKING:
    from pipelines.diagnosis.verdict import Verdict
    from pipelines.engine.run_graph import Outcome
    from pipelines.orders.kinematics import Kinematics
    from pipelines.plant.plant import Drivetrain

VERDICT = "verdict"  # name of the files
STRIKES = {"outer-ring": "BPFO", "inner-ring": "BPFI", "element": "2 BSF"}


def feature_steps(study: Study) -> list[Step]:
    """Features of the scene's motion, then of the healthy ones: the baseline, else the control. None without either.

    The exact control stands for healthy only where nothing better was asked for: it has the same deviations.
    """
    from pipelines.diagnosis.simulated import FeatureSettings
    from pipelines.steps import features

    first = study.cases[0]
    healthy = [(one.plant, one.motion) for one in study.baseline]
    own_control = first.healthy == first.faulty  # a scene without faults
    if not healthy and first.control is not None and first.healthy is not None and not own_control:
        healthy = [(first.control, first.healthy)]
    if not healthy or not first.plant.looked_for.possible:
        return []
    settings = FeatureSettings(kinematics=kinematics(first.plant), windows=first.plant.looked_for.windows)
    taken = [(first.plant, first.faulty, 1), *((plant, motion, 0) for plant, motion in healthy)]
    return [
        Step(
            name=f"features {motion}",
            kind="features",
            build=features.build,
            spec=features.FeaturesSpec(settings=settings, labels=plant.labels, stream=stream),
            takes=(motion,),
            libraries=("numpy", "scipy"),
            seconds=1.0,
        )
        for plant, motion, stream in taken
    ]


def kinematics(plant: Drivetrain) -> Kinematics:
    """What a machine has, for its diagnosis."""
    from pipelines.orders.plant_kinematics import kinematics_of

    return kinematics_of(plant.layout, plant.rolling)


def judged(study: Study, steps: list[Step], outcome: Outcome) -> tuple[Verdict | None, str]:
    """The verdict, or None and why there is none."""
    from pipelines.diagnosis.verdict import BaselineError, judge

    found = [outcome.value(step.name) for step in steps]
    failure = next((one["failure"] for one in found if one["failure"]), "")
    if failure:
        return None, failure
    own, *healthy = (one["table"] for one in found)
    try:
        return judge(own, healthy, kinematics(study.plant)), ""
    except BaselineError as error:
        return None, str(error)


def known_faults(plant: Drivetrain) -> list[tuple[str, int | None]]:
    """What the scene damages: component and tooth, None where it has none."""
    teeth = [(f"stage {fault.stage} {fault.gear}", fault.tooth) for fault in plant.faults]
    spalls = [(f"{fault.bearing} {STRIKES[fault.spall.on]}", None) for fault in plant.spalls]
    return [*teeth, *spalls, *((f"shaft_{fault.shaft + 1}", None) for fault in plant.shaft_faults)]


def verdict_words(verdict: Verdict, plant: Drivetrain, exact: bool) -> str:
    """The verdict as text; with `exact` the healthy recording is the exact control, and that is said."""
    from pipelines.diagnosis.words import confirmed, text

    parts = [text(verdict).rstrip()]
    if exact:
        parts.append(
            "The healthy recording is the control: the same machine without the fault, which only a simulation has. "
            "The increases are the effect of the fault. Set --baseline 8 to compare with healthy machines of other "
            "deviations."
        )
    parts.append(confirmed(verdict, known_faults(plant)))
    return "\n\n".join(filter(None, parts)) + "\n"


def write_verdict(folder: Path, verdict: Verdict, words: str) -> None:
    """verdict.json and verdict.txt."""
    run_folder.write_json(folder / f"{VERDICT}.json", dataclasses.asdict(verdict))
    (folder / f"{VERDICT}.txt").write_text(words, encoding="utf-8")
