"""What error bars hold and what they do not, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

from pipelines.bars.line_bars import LineBar

LEFT_OUT = (
    "The error bars leave out: the mesh law (gearcase converge --over gear-mesh and --over slices estimate its error), "
    "modes above the band of the reduction, the stiffness of the bearing seats (casing.attachment mean or rigid), feet "
    "and mounts, and the deviations of the teeth (gearcase run --seeds)."
)


def notes(bars: Sequence[LineBar], missed: Sequence[str], remedy: str, damping_spread: float) -> tuple[str, ...]:
    """The sentences.

    Parameters
    ----------
    bars : of all windows
    missed : names of lines that the forces of the bearings do not explain
    remedy : what to set where the error of the casing's mesh is not known, "" where it is
    damping_spread : of the damping ratios
    """
    found = []
    if remedy:
        found.append(
            f"The discretisation error of the casing is not known: {remedy}. Only the effect of uncertain inputs is "
            "shown."
        )
    else:
        found.append(
            "Numerical: 5 to 95 % of 200 samples of the casing's natural frequencies within their error bands, and the "
            "error of the time step."
        )
    found.append(
        "Inputs: 5 to 95 % of 200 samples of one factor on all damping ratios of the casing, mostly between "
        f"{1 / (1 + damping_spread):.2g} and {1 + damping_spread:.2g} (an assumption; set it by "
        "diagnosis.damping_spread)."
    )
    found.append(LEFT_OUT)
    if missed:
        found.append(
            "Other forces than those of the bearings act on these lines, so their error bars are incomplete: "
            f"{', '.join(missed)}."
        )
    return tuple(found)
