"""Step `features`: what every component of the machine shows in a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbd.output.trajectory import Trajectory
    from pipelines.diagnosis.simulated import FeatureSettings


def build(settings: FeatureSettings, labels: Mapping[str, Any], samples: int, *, motion: Trajectory) -> dict[str, Any]:
    """The tables of features by window, one for each sample of noise, under "tables".

    Where there are none, the reason is under "failure".

    Parameters
    ----------
    settings, labels : machine and windows, and the labels of the motion
    samples : number of samples of sensor noise that are added to the motion
    motion : of the machine
    """
    from pipelines.diagnosis.simulated import window_features
    from pipelines.signals.features.recorded import FeatureError
    from pipelines.signals.orders.rotation import RotationError
    from pipelines.signals.response import make_response

    try:
        tables = window_features(make_response(motion, labels), settings, samples)
    except (FeatureError, RotationError) as error:
        return {"tables": {}, "failure": str(error)}
    return {"tables": tables, "failure": ""}
