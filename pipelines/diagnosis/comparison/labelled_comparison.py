"""Features of several recordings of one machine, and their differences, as an xarray dataset."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pipelines.diagnosis.comparison.compared_features import features_of
from pipelines.diagnosis.comparison.compared_recording import brought_together, compared_recording
from pipelines.io.errors import InputError
from pipelines.io.shown_text import shown
from pipelines.signals.features.feature_table import labelled_array
from pipelines.signals.features.recording_features import FeatureError
from pipelines.signals.orders.kinematics import Kinematics
from pipelines.signals.orders.rotation import RotationError

if TYPE_CHECKING:
    import xarray


def labelled_comparison(recordings: Mapping[str, xarray.Dataset], kinematics: Kinematics) -> xarray.Dataset:
    """Features of recordings of one machine.

    The variables are `value` (recording, component, feature) in the unit of the feature, `difference` from the first
    recording in dB, and `speed` (recording,) of the first shaft in rad/s. Missing values are NaN.

    Raises
    ------
    InputError : fewer than two recordings, one without features, or no common channel
    """
    import xarray

    if len(recordings) < 2:
        raise InputError(
            f"{len(recordings)} recording{'' if len(recordings) == 1 else 's'} given. Give two or more to compare."
        )
    parts = []
    for name, recording in recordings.items():
        try:
            parts.append(compared_recording(name, recording, kinematics))
        except (FeatureError, RotationError) as error:
            raise InputError(f"{shown(name)}: {error}") from error
    try:
        found = features_of(brought_together(parts))
    except FeatureError as error:
        raise InputError(str(error)) from error
    dims = ("recording", "component", "feature")
    places = [(name, *line) for name in recordings for line in found.lines]
    value, difference = (
        labelled_array(dict(zip(places, given.ravel(), strict=True)), dims) for given in (found.value, found.difference)
    )
    speed = np.array([2.0 * math.pi * part.windows[0].frequency for part in parts])
    labelled = {"value": value, "difference": difference.assign_attrs(units="dB")}
    return xarray.Dataset(labelled | {"speed": (dims[:1], speed, {"units": "rad/s"})})
