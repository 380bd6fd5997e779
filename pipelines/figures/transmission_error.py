"""Transmission error of a healthy pair over the mesh cycle and its orders, before and after flank modifications."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipelines.runs.gear_numbers import MeshState
    from pipelines.steps.pair_curves import PairLaws

POSITIONS = 256  # of one mesh cycle; a multiple of four, so that a wave up to order 64 shows its peaks
ORDERS = 8  # of the mesh frequency that are shown
_SHOWN = 5  # of them in the table


@dataclass(frozen=True, eq=False, kw_only=True)
class TransmissionErrors:
    """Transmission error of one pair at one load, without tooth faults and deviations.

    `unmodified` is None for flanks without modifications.
    """

    stage: int  # from 1
    title: str
    torque: float  # N m, on the pinion
    cycle: np.ndarray  # (position,), mesh cycles over one of them
    unmodified: np.ndarray | None  # (position,), m
    actual: np.ndarray  # (position,), m

    @property
    def states(self) -> dict[str, np.ndarray]:
        """The curves by what the flanks are, "unmodified" first."""
        if self.unmodified is None:
            return {"unmodified": self.actual}
        return {"unmodified": self.unmodified, "modified": self.actual}

    def rows(self) -> list[dict[str, Any]]:
        """Peak-to-peak and the first orders of every state, um."""
        return [
            {
                "stage": self.stage,
                "torque N m": self.torque,
                "flanks": state,
                "p-p um": 1e6 * float(np.ptp(error)),
                **{f"order {k} um": 1e6 * float(size) for k, size in enumerate(orders(error)[:_SHOWN], 1)},
            }
            for state, error in self.states.items()
        ]


def transmission_errors(found: PairLaws, state: MeshState) -> TransmissionErrors:
    """The transmission error of a pair over one mesh cycle."""
    cycle = np.arange(POSITIONS) / POSITIONS
    pair = found.pair
    return TransmissionErrors(
        stage=found.stage,
        title=f"stage {found.stage}, {pair.pinion.teeth}/{pair.wheel.teeth} teeth, model {found.drive.model}",
        torque=state.force * pair.pinion.base_radius,
        cycle=cycle,
        unmodified=found.stiffness(cycle, modified=False, force=state.force, tilt=state.tilt).transmission_error
        if found.modified
        else None,
        actual=found.stiffness(cycle, force=state.force, tilt=state.tilt).transmission_error,
    )


def orders(error: np.ndarray) -> np.ndarray:
    """Amplitudes (order,) of the orders 1, 2, ... of the mesh frequency of one whole mesh cycle (position,)."""
    lines: np.ndarray = 2 * np.abs(np.fft.rfft(error))[1 : ORDERS + 1] / error.size
    return lines


def transmission_error_figure(title: str, errors: Sequence[TransmissionErrors]) -> Figure:
    """A row for each stage: the curves on the left, the orders on the right; a colour for each torque."""
    from matplotlib import colormaps

    from pipelines.figures.plots import dress, new_figure, plain

    stages = list(dict.fromkeys(error.stage for error in errors))
    figure = new_figure(0.7 + 3.6 * len(stages), 11.0)
    figure.suptitle(f"{plain(title)}\ntransmission error of the healthy pair, without deviations")
    panels = np.atleast_2d(figure.subplots(len(stages), 2, width_ratios=[1.2, 1.0]))
    for stage, (curves, lines) in zip(stages, panels, strict=True):
        own = [error for error in errors if error.stage == stage]
        colours = colormaps["viridis"](np.linspace(0.0, 0.8, len(own)))
        count = sum(len(error.states) for error in own)
        place = 0
        for error, colour in zip(own, colours, strict=True):
            for state, values in error.states.items():
                before = state == "unmodified" and error.unmodified is not None
                label = f"{error.torque:.4g} N m" + (f", {state}" if error.unmodified is not None else "")
                curves.plot(error.cycle, 1e6 * values, color=colour, ls="--" if before else "-", label=label)
                at = np.arange(1, ORDERS + 1) + 0.8 * ((place + 0.5) / count - 0.5)
                lines.bar(at, 1e6 * orders(values), 0.8 / count, facecolor="none" if before else colour,
                          edgecolor=colour, lw=0.8)  # fmt: skip
                place += 1
        curves.margins(x=0)
        dress(curves, own[0].title, "mesh cycle", "transmission error, µm")
        dress(lines, "orders of the mesh frequency", "order", "amplitude, µm")
        lines.set_xticks(range(1, ORDERS + 1))
        curves.legend(
            fontsize=8, ncols=max(1, len(own) // 3 + 1), loc="upper left", bbox_to_anchor=(0.0, -0.16), frameon=False
        )
    return figure
