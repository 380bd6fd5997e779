"""What error bars hold and what they do not, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

from pipelines.diagnosis.uncertainty.line_bars import LineBar

LEFT_OUT = (
    "Not in the error bars: the error of the mesh law, which gearcase converge --over gear-mesh and --over slices "
    "estimate; the effect of the deviations, which gearcase run --seeds shows; modes above the band of the "
    "reduced casing; and the stiffness of bearing seats, feet and mounts."
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
            f"The discretisation error of the casing is not known: {remedy}. Only the effect of uncertain damping is "
            "shown."
        )
    else:
        found.append(
            "Numerical uncertainty: 5 to 95 % of 200 samples. Each sample changes the natural frequencies of the "
            "casing within their uncertainty bands, and adds an error of the time step."
        )
    found.append(
        "Uncertain damping: 5 to 95 % of 200 samples. Each sample multiplies all damping ratios of the casing by one "
        f"factor, in 90 % of the samples between {1 / (1 + damping_spread):.2g} and {1 + damping_spread:.2g}. This "
        "range is an assumption; diagnosis.damping_spread sets it."
    )
    found.append(LEFT_OUT)
    if missed:
        found.append(
            "These lines are excited by further forces than those of the bearings, so their error bars are incomplete: "
            f"{', '.join(missed)}."
        )
    return tuple(found)
