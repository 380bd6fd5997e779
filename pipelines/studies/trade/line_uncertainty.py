"""Numerical uncertainty of the detected lines, as a sentence below a trade-off or a refinement study."""

from __future__ import annotations

from statistics import median

from pipelines.diagnosis.uncertainty.bar_records import LineBars
from pipelines.engine.run_graph import Work
from pipelines.engine.step import Graph
from pipelines.scene.load_scene import LoadedScene
from pipelines.steps.result_steps import bars_step, casing_taken
from pipelines.steps.run_plan import plan_run


def line_uncertainty(loaded: LoadedScene, work: Work) -> str:
    """Sentence on the numerical uncertainty of the detected lines; "" without a control or a diagnosis.

    The scene and its control are simulated if they are not in the cache.

    Raises
    ------
    SceneError, InputError : the scene or its control cannot be run, or there is not enough disk space for its signals
    WorkError : a step failed
    """
    plan = plan_run(loaded, both_loads=False)
    if plan.control is None or plan.machine.diagnosis is None:
        return ""
    if len(casing_taken(plan.graph)) == 1:
        return (
            "The uncertainty of the detected spectral lines by the casing mesh is not estimated. Set "
            "casing.extrapolated = true for it."
        )
    step = bars_step(plan)
    bars = work.build(Graph([*plan.graph, step]), [step.name]).value(step.name)
    return uncertainty_sentence(bars) if isinstance(bars, LineBars) else bars


def uncertainty_sentence(error_bars: LineBars) -> str:
    """Sentence with the median and the largest numerical uncertainty of the detected lines of all windows."""
    found = [bar.numerical.width / 2 for bar in error_bars.bars if bar.detected and bar.numerical is not None]
    if not found:
        return "No detected line has an error bar."
    return (
        f"Casing mesh and time step make the levels of the {len(found)} detected lines of the fault uncertain by "
        f"{median(found):.2g} dB in the median and {max(found):.2g} dB at most (half the error bar, 5 to 95 %). "
        "Choices that differ by less cannot be distinguished."
    )
