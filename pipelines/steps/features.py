"""Step `features`: what every component of the machine shows in a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray

    from mbd.output.trajectory import Trajectory
    from pipelines.diagnosis.simulated_features import FeatureSettings


def build(settings: FeatureSettings, labels: Mapping[str, Any], samples: int, *, motion: Trajectory) -> dict[str, Any]:
    """The tables of a motion, see `of_response`.

    Parameters
    ----------
    settings, labels, samples : machine and windows, labels of the motion, number of samples of sensor noise
    motion : of the machine
    """
    from pipelines.signals.response import make_response

    return of_response(make_response(motion, labels), settings, samples)


def of_response(run: xarray.Dataset, settings: FeatureSettings, samples: int) -> dict[str, Any]:
    """The tables of features by window, one for each sample of noise, under "tables".

    Where there are none, the reason is under "failure". "chance" is why the run cannot be compared with a control, or
    "".

    Parameters
    ----------
    run : response of the machine
    settings : machine and windows
    samples : number of samples of sensor noise that are added
    """
    from pipelines.diagnosis.simulated_features import window_features
    from pipelines.signals.features.recording_features import FeatureError
    from pipelines.signals.motion_warnings import chance_of_run
    from pipelines.signals.orders.rotation import RotationError

    chance = chance_of_run(run, max((end for _, end in settings.windows.values()), default=0.0))
    try:
        return {"tables": window_features(run, settings, samples), "failure": "", "chance": chance}
    except (FeatureError, RotationError) as error:
        return {"tables": {}, "failure": str(error), "chance": chance}
