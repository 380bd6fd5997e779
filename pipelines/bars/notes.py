"""What error bars hold and what they do not, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

from pipelines.bars.line_bars import LineBar

LEFT_OUT = (
    "Not in the bars: the mesh law (its error is what gearcase converge tells with --over gear-mesh and --over "
    "slices), modes that the reduction leaves out, the seats (casing.attachment mean or rigid), feet and mounts, and "
    "the deviations of the teeth (gearcase run with --seeds)."
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
        found.append(f"The error of the casing's mesh is not known: {remedy}. Shown is what the inputs do.")
    else:
        found.append(
            "Numerical: 5 to 95 % of 200 draws of the casing's natural modes from the limits and bands of their "
            "frequencies, and the error of the time step."
        )
    found.append(
        "Inputs: 5 to 95 % of 200 draws of one factor on the casing's damping ratios, most of them from "
        f"{1 / (1 + damping_spread):.2g} to {1 + damping_spread:.2g} (assumed; diagnosis.damping_spread)."
    )
    found.append(LEFT_OUT)
    if missed:
        found.append(f"Other forces than those of the bearings make: {', '.join(missed)}.")
    return tuple(found)
