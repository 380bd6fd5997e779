"""How long a window must be so that every shaft turns often enough in it."""

from __future__ import annotations

from pipelines.signals.orders.kinematics import Kinematics


def needed_seconds(kinematics: Kinematics, turns: int) -> dict[str, float]:
    """Length (s) of a window that holds so many whole turns, wherever the mark of the shaft is, by shaft.

    It is that of one turn more, at the nominal speed.

    Raises
    ------
    ValueError : the nominal speed is not known or 0
    """
    if not kinematics.frequency:
        raise ValueError(f"nominal speed {kinematics.frequency} Hz: no time follows from it. Set a speed above 0.")
    return {shaft.name: (turns + 1) / (shaft.ratio * kinematics.frequency) for shaft in kinematics.shafts}
