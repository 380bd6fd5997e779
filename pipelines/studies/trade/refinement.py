"""A refinement study of a scene along one axis: convergence over three levels or more, errors of the setting in use."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fem.casing.uncertainty.limits_by_element import Extrapolation
from fem.storage import shown_html
from pipelines.engine.run_graph import Work
from pipelines.scene.load_scene import LoadedScene, changed
from pipelines.studies.trade.convergence import Convergence, ConvergenceError, study
from pipelines.studies.trade.measured_variants import Measured, measure
from pipelines.studies.trade.refinement_axes import AXES


@dataclass(frozen=True, kw_only=True)
class RefinementStudy:
    """Levels from fine to coarse with their costs, and the convergence of every quantity over them."""

    axis: str
    fineness: tuple[float, ...]  # of each level, 1 is the setting in use
    levels: tuple[Measured, ...]
    quantities: dict[str, Convergence]
    units: dict[str, str]
    unpaired: dict[str, float] = field(default_factory=dict)  # MAC of the closest mode, of modes that were left out

    @property
    def in_use(self) -> int:
        """Number of the level with the settings of the scene."""
        return self.fineness.index(1.0)

    def __repr__(self) -> str:
        return f"<RefinementStudy: {self.axis}, {len(self.levels)} levels, {len(self.quantities)} quantities>"

    def _repr_html_(self) -> str:
        """Every quantity with its limit and the error of the setting in use, for a notebook."""
        at = self.in_use
        rows = [
            (name, self.units[name], one.values[at], one.limit, one.order, 100 * one.relative_bands[at])
            for name, one in self.quantities.items()
        ]
        head = ("quantity", "unit", "in use", "extrapolated", "order", "error at most, %")
        return shown_html.table(f"Refined: {self.axis}", head, rows)


def level_name(fineness: float) -> str:
    """Name of a level in tables and figures: x2 is twice as fine as the setting in use."""
    return "in use" if fineness == 1.0 else f"x{fineness:.3g}"


def refine(loaded: LoadedScene, axis: str, count: int, work: Work) -> RefinementStudy:
    """Compute all levels, and the convergence of every value of the probe of the axis.

    Parameters
    ----------
    loaded, work : the scene, and what builds its steps
    axis : one of `pipelines.studies.trade.refinement_axes.AXES`
    count : number of levels, the finest first

    Raises
    ------
    AxisError : the scene has nothing to refine along the axis
    SceneError, WorkError : a level is outside what a model allows, or failed
    ConvergenceError : fewer than three levels
    """
    if count < 3:
        raise ConvergenceError(f"--levels {count}: a convergence study needs 3 levels or more. Set --levels 3")
    chosen = AXES[axis]
    # the finest first: one level finer than the setting in use, which is the second, all others are coarser
    fineness = tuple(chosen.ratio ** (1 - n) for n in range(count))
    scenes = {level_name(f): changed(loaded, chosen.settings(loaded.scene, f)) for f in fineness}
    levels = list(measure(scenes, [chosen.probe, *chosen.also], work).values())
    first = levels[0].by_probe[chosen.probe]
    sizes = [1 / f for f in fineness]
    unpaired: dict[str, float] = {}
    if chosen.probe == "modes":
        from fem.casing.uncertainty.limits_by_element import extrapolation_of

        unpaired = unpaired_modes(levels)
        quantities = modes_of_common_order(sizes, levels, extrapolation_of(getattr(loaded.scene.casing, "element", "")))
    else:
        columns: dict[str, Sequence[float]] = {
            value.name: [level.by_probe[chosen.probe][number].value for level in levels]
            for number, value in enumerate(first)
        }
        quantities = {name: study(sizes, column, chosen.formal_order) for name, column in columns.items()}
    return RefinementStudy(
        axis=axis,
        fineness=fineness,
        levels=tuple(levels),
        quantities=quantities,
        units={value.name: value.unit for value in first},
        unpaired=unpaired,
    )


def _shapes(levels: Sequence[Measured]) -> list[np.ndarray]:
    """Shapes (k, mode) of the modes of every level, the finest first."""
    import numpy as np

    return [np.array([v.shape for v in level.values]).T for level in levels]


def unpaired_modes(levels: Sequence[Measured]) -> dict[str, float]:
    """Modes of the finest level without a counterpart on some other, with the MAC of the closest mode there."""
    import numpy as np

    from fem.casing.uncertainty.pairing import assurance, counterparts

    shapes = _shapes(levels)
    alone = np.array([counterparts(shapes[0], other) < 0 for other in shapes[1:]])  # (level, mode)
    closest = np.array([assurance(shapes[0], other).max(axis=1) for other in shapes[1:]])
    columns = zip(levels[0].values, alone.T, closest.T, strict=True)
    return {v.name: float(macs[missing].min()) for v, missing, macs in columns if missing.any()}


def modes_of_common_order(
    sizes: Sequence[float], levels: Sequence[Measured], limits: Extrapolation
) -> dict[str, Convergence]:
    """Modes of the finest level that have counterparts on all others; limits and bands from the three finest levels.

    The band of a value is its distance from the limit and the band of the limit.
    """
    import numpy as np

    from fem.casing.uncertainty.frequency_limits import LimitError
    from fem.casing.uncertainty.pairing import counterparts

    shapes = _shapes(levels)
    number = np.array([counterparts(shapes[0], other) for other in shapes])
    kept = np.asarray((number >= 0).all(axis=0))
    frequencies = np.array(
        [np.array([v.value for v in level.values])[of[kept]] for level, of in zip(levels, number, strict=True)]
    )
    try:
        found = limits(sizes[:3], frequencies[:3])
    except LimitError as error:
        raise ConvergenceError(str(error)) from error
    names = [v.name for v, whole in zip(levels[0].values, kept, strict=True) if whole]
    return {
        name: Convergence(
            sizes=tuple(sizes),
            values=tuple(values.tolist()),
            kind="monotone" if np.isfinite(alone) else "oscillating",
            order=found.order if np.isfinite(alone) else None,
            limit=float(limit),
            bands=tuple((abs(values - limit) + band).tolist()),
        )
        for name, values, limit, band, alone in zip(
            names, frequencies.T, found.limits, found.bands, found.orders, strict=True
        )
    }
