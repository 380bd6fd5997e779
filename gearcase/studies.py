"""Studies of accuracy and cost, and of flank modifications."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gearcase.argument_checks import checked_file, refusal
from gearcase.progress import ProgressFunction
from gearcase.scenes import Scene, loaded_scene
from pipelines.engine.run_graph import Work
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.studies.design.design_study import DesignOptions, DesignStudy, design_study
from pipelines.studies.spread.population_spread import FeatureSpread, run_spread, spread_plan
from pipelines.studies.trade.refinement import RefinementStudy, refine
from pipelines.studies.trade.refinement_axes import AXES
from pipelines.studies.trade.tradeoff import Tradeoff, trade

__all__ = [
    "DesignStudy",
    "FeatureSpread",
    "RefinementStudy",
    "Tradeoff",
    "converge",
    "design",
    "spread",
    "tradeoff",
]


def converge(
    scene: Scene,
    over: str,
    *,
    levels: int = 3,
    processes: int | None = None,
    progress: ProgressFunction | None = None,
) -> RefinementStudy:
    """Estimate the discretisation error of one mesh, number of modes or time step, by Richardson extrapolation.

    Parameters
    ----------
    scene : the scene
    over : "gear-mesh", "slices", "positions", "casing-mesh", "modes", "shaft-elements" or "step"
    levels : number of sizes: one finer than in the scene, that of the scene, the rest coarser
    processes : long steps computed in parallel, 2 by default
    progress : function that is called with a `StepProgress` for every step

    Returns
    -------
    values of every quantity at every level (`units` by quantity), observed order, limit and uncertainty band

    Raises
    ------
    SceneError, InputError, WorkError : `over` does not apply to the scene, a level is out of range, a step failed

    >>> import gearcase
    >>> found = gearcase.converge(gearcase.Scene.from_file("minimal"), "slices")
    >>> found.units["stage 1 stiffness"], found.fineness
    ('N/um', (2.0, 1.0, 0.5))
    """
    if over not in AXES:
        raise refusal("over", over, f"one of {', '.join(AXES)}", "Correct the name.")
    return refine(loaded_scene(scene), over, levels, Work(processes=processes, progress=progress))


def spread(
    scene: Scene,
    over: str | Path | None = None,
    *,
    machines: int | None = None,
    out: str | Path | None = None,
    processes: int | None = None,
) -> FeatureSpread:
    """Simulate machines of a population, and estimate which property makes the variance of each feature.

    Parameters
    ----------
    scene : the scene
    over : plan of a campaign with the variables and settings of the population; the typical one by default
    machines : their number, at least 20; that of the plan, or 100 by default
    out : folder of the data set, ./campaigns/spread-<scene> by default; finished machines in it are not repeated
    processes : machines computed in parallel, all cores by default

    Returns
    -------
    `table`, a data frame with a row for each channel, component and feature: `median`, ends `low`, `high` of the 90 %
    interval, and for each of `variables` its first-order Sobol index and `..._error`, the standard error of the index

    Raises
    ------
    SceneError, InputError : the plan or the folder cannot be used, or too few machines have features
    WorkError : the disk is full, or the workers have ended; finished machines are kept

    >>> import gearcase
    >>> short = gearcase.Scene.from_file("minimal").changed({"simulation.end_s": 0.35, "diagnosis.windows_s": {}})
    >>> found = gearcase.spread(short, machines=20)
    >>> rms = found.means().set_index("feature").loc["rms"]
    >>> bool(rms.low < rms["median"] < rms.high), found.machines, found.variables[0]
    (True, 20, 'spread_specimen')
    """
    loaded = loaded_scene(scene)
    machine = checked_machine(loaded.scene, loaded.source.shown)
    plan_file = None if over is None else checked_file("over", over, "the plan of a campaign")
    plan = spread_plan(loaded, machine, plan_file, machines)
    return run_spread(plan, Path(out or f"campaigns/{plan.name}"), machine.monitored, processes, Work())


def tradeoff(scene: Scene, *, processes: int | None = None, progress: ProgressFunction | None = None) -> Tradeoff:
    """Measure the time and accuracy of every model and main setting, compared with a reference. Takes minutes.

    Parameters
    ----------
    scene : the scene
    processes : long steps computed in parallel, 2 by default
    progress : function that is called with a `StepProgress` for every step

    Returns
    -------
    every choice with its seconds, peak memory in bytes and largest errors (relative; of levels in dB)

    Raises
    ------
    SceneError, WorkError : the scene cannot be used, a step failed

    >>> import gearcase
    >>> found = gearcase.tradeoff(gearcase.Scene.from_file("minimal"))  # doctest: +SKIP
    >>> found.most_accurate(seconds=10.0).choice.name  # doctest: +SKIP
    """
    return trade(loaded_scene(scene), Work(processes=processes, progress=progress))


def design(
    scene: Scene,
    vary: Sequence[str] = (),
    *,
    stage: int = 1,
    minimize: Sequence[str] = ("te",),
    limits: Sequence[str] = (),
    torques: Sequence[float] = (),
    samples: int = 0,
    misalignment_um: float = 0.0,
    seed: int = 1,
    evaluations: int = 2000,
    processes: int | None = None,
    progress: ProgressFunction | None = None,
) -> DesignStudy:
    """Search for the best flank modifications of a stage, as `gearcase design` does.

    Parameters
    ----------
    scene : the scene
    vary : modifications with their values, such as "both.tip_relief.amount_um=0:40:4"; none: tip reliefs of both gears
    stage : number of the stage, from 1
    minimize, limits : objectives and limits, such as "te" and "pressure <= 1200"
    torques : N m on the pinion; none: 25, 50, 75 and 100 % of that of the scene
    samples : number of pairs with random deviations; 0 for the nominal pair only
    misalignment_um : largest misalignment of these pairs over the face width
    seed : of search and deviations
    evaluations : number of candidates up to which all combinations are evaluated; beyond it pymoo searches
    processes : long steps computed in parallel, 2 by default
    progress : function that is called with a `StepProgress` for every step

    Returns
    -------
    the front: `rows` of its table, `best` designs by name, `settings` of a design for `Scene.changed`

    Raises
    ------
    SceneError, InputError, WorkError : the scene or an argument cannot be used, nothing meets the limits, a step failed

    >>> import gearcase
    >>> scene = gearcase.Scene.from_file("pair")
    >>> vary = ["both.tip_relief.amount_um=0:8:2", "both.tip_relief.length_mm=2,3,4"]
    >>> found = gearcase.design(scene, vary, torques=[50.0])
    >>> unmodified, best = found.rows()
    >>> best["te um"] < 0.7 * unmodified["te um"]
    True
    >>> quiet = scene.changed(found.settings(found.recommended))
    """
    options = DesignOptions(
        stage=stage,
        vary=vary,
        minimize=minimize,
        limits=limits,
        torques=torques,
        samples=samples,
        misalignment=1e-6 * misalignment_um,
        seed=seed,
        evaluations=evaluations,
    )
    return design_study(loaded_scene(scene), options, Work(processes=processes, progress=progress))
