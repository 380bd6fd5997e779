"""Step `features`: what every component of the machine shows in a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbd.output.trajectory import Trajectory
    from pipelines.diagnosis.simulated import FeatureSettings


@dataclass(frozen=True, kw_only=True)
class FeaturesSpec:
    """Machine and windows, the labels of the motion, and how many samples of sensor noise are added to it."""

    settings: FeatureSettings
    labels: Mapping[str, Any]
    samples: int


def build(spec: FeaturesSpec, *, motion: Trajectory) -> dict[str, Any]:
    """The tables of features by window, one for each sample of noise, under "tables".

    Where there are none, the reason is under "failure".
    """
    from pipelines.diagnosis.simulated import window_features
    from pipelines.signals.features.recorded import FeatureError
    from pipelines.signals.orders.rotation import RotationError
    from pipelines.signals.response import make_response

    try:
        tables = window_features(make_response(motion, spec.labels), spec.settings, spec.samples)
    except (FeatureError, RotationError) as error:
        return {"tables": {}, "failure": str(error)}
    return {"tables": tables, "failure": ""}
