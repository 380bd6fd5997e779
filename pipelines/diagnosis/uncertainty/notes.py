"""Notes on error bars: which errors they contain and which they omit."""

from __future__ import annotations

from collections.abc import Sequence

from pipelines.diagnosis.uncertainty.bar_records import SAMPLES

LEFT_OUT = (
    "Not in the error bars: the error of the mesh law, which gearcase converge --over gear-mesh and --over slices "
    "estimate; the effect of the deviations, which gearcase run --seeds shows; modes above the band of the "
    "reduced casing; and the stiffness of bearing seats, feet and mounts."
)


def notes(missed: Sequence[str], remedy: str, damping_spread: float) -> tuple[str, ...]:
    """Sentences on the errors that the error bars contain and omit.

    Parameters
    ----------
    missed : names of lines that forces other than those of the bearings excite, too
    remedy : setting that makes the error of the casing mesh known, "" if it is known
    damping_spread : relative spread of the damping ratios, 5 to 95 %
    """
    numerical = (
        f"Numerical uncertainty: 5 to 95 % of {SAMPLES} samples. Each sample changes the natural frequencies of the "
        "casing within their uncertainty bands, and adds an error of the time step."
    )
    if remedy:
        numerical = (
            f"The discretisation error of the casing is not known: {remedy}. Only the effect of uncertain damping is "
            "shown."
        )
    damping = (
        f"Uncertain damping: 5 to 95 % of {SAMPLES} samples. Each sample multiplies all damping ratios of the casing "
        f"by one factor, in 90 % of the samples between {1 / (1 + damping_spread):.2g} and {1 + damping_spread:.2g}. "
        "This range is an assumption; diagnosis.damping_spread sets it."
    )
    incomplete = (
        "These lines are excited by further forces than those of the bearings, so their error bars are incomplete: "
        f"{', '.join(missed)}."
    )
    return (numerical, damping, LEFT_OUT, *([incomplete] if missed else []))
