"""The rotation of a machine from the most accurate source in a recording."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipelines.io.shown_text import shown
from pipelines.signals.orders.kinematics import Kinematics
from pipelines.signals.orders.mesh_tracking import track
from pipelines.signals.orders.rotation import Rotation, RotationError
from pipelines.signals.orders.speed_from_multiples import LEAST, by_multiples
from pipelines.signals.orders.tachometer import angle_from_pulses, find_pulses

if TYPE_CHECKING:
    import xarray


def rotation_of(recording: xarray.Dataset, kinematics: Kinematics) -> Rotation:
    """The rotation from recorded shaft angles, else from a tachometer or a known speed, else from the vibration.

    Parameters
    ----------
    recording : `acceleration` (time, sensor, axis) with the equidistant coordinate `time` in s. Optional:
        `shaft_angle` (time, shaft) in rad; `tachometer` (time) with the attributes `pulses_per_turn`, `shaft` and, if
        known, `level` of a pulse; `known_speed` (time) in Hz with the attributes `shaft` and relative `uncertainty`
    kinematics : of the machine

    Raises
    ------
    RotationError : the recorded angle is of no shaft of the machine or does not change, the tachometer or the speed is
        not valid, or no angle follows from the vibration (see `pipelines.signals.orders.mesh_tracking.track`)
    """
    if "shaft_angle" in recording:
        return _recorded(recording, kinematics)
    if "tachometer" in recording:
        return _from_pulses(recording, kinematics)
    if "known_speed" in recording:
        return _from_speed(recording, kinematics)
    time, whole = np.asarray(recording.time, dtype=float), _channels(recording)
    if not whole:
        raise RotationError(
            "no angle, no tachometer, and no channel whose values are all numbers: the speed cannot be found. Record a "
            "tachometer, or repair the channels."
        )
    return track(whole, (len(time) - 1) / float(time[-1] - time[0]), kinematics)


def _channels(recording: xarray.Dataset) -> list[np.ndarray]:
    """Accelerations (time,) of all channels whose values are all numbers."""
    laid = np.asarray(recording.acceleration.transpose("sensor", "axis", "time"), dtype=float)
    return [channel for channel in laid.reshape(-1, laid.shape[-1]) if np.isfinite(channel).all()]


def _recorded(recording: xarray.Dataset, kinematics: Kinematics) -> Rotation:
    names = [str(name) for name in recording.shaft.values]
    known = [shaft for shaft in kinematics.shafts if shaft.name in names]
    if not known:
        raise RotationError(
            f"the recording has the angles of {_listed(names)}, the machine the shafts "
            f"{_listed([shaft.name for shaft in kinematics.shafts])}. Name them alike."
        )
    shaft = known[0]
    angle = np.asarray(recording.shaft_angle.sel(shaft=shaft.name), dtype=float) / shaft.ratio
    if not np.isfinite(angle).all() or np.ptp(angle) == 0.0:
        what = "does not change" if np.isfinite(angle).all() else "holds values that are not numbers"
        raise RotationError(f"the recorded angle of {shown(shaft.name)} {what}. Leave it out, or repair the recording.")
    return Rotation(angle=angle, source=f"recorded angle of {shown(shaft.name)}", error=0.0, absolute=True)


def _from_pulses(recording: xarray.Dataset, kinematics: Kinematics) -> Rotation:
    tachometer = recording.tachometer
    per_turn, name = float(tachometer.attrs["pulses_per_turn"]), str(tachometer.attrs["shaft"])
    ratio = _ratio(kinematics, name, "tachometer")
    if not per_turn > 0.0:
        raise RotationError(f"tachometer: {per_turn:g} pulses per turn. Give a number above 0.")
    time = np.asarray(recording.time, dtype=float)
    pulses = find_pulses(np.asarray(tachometer, dtype=float), time, tachometer.attrs.get("level"))
    angle, error = angle_from_pulses(pulses, per_turn, time)
    corrected = [
        f"{number} {kind}" for number, kind in ((pulses.missing, "missing"), (pulses.double, "double")) if number
    ]
    words = f"tachometer on {shown(name)}, {per_turn:g} pulse{'' if per_turn == 1.0 else 's'} per turn"
    return Rotation(
        angle=angle / ratio,
        source=words + (f"; {' and '.join(corrected)} pulses corrected" if corrected else ""),
        error=error / float(angle[-1] - angle[0]),
        absolute=per_turn == 1.0,
        mark=name,
    )


def _from_speed(recording: xarray.Dataset, kinematics: Kinematics) -> Rotation:
    known = recording.known_speed
    name, uncertainty = str(known.attrs["shaft"]), float(known.attrs["uncertainty"])
    speed = np.asarray(known, dtype=float) / _ratio(kinematics, name, "known speed")
    if not (np.isfinite(speed).all() and speed.min() >= 0.0 and speed.max() > 0.0):
        raise RotationError(
            f"speed of {shown(name)}: from {speed.min():.4g} to {speed.max():.4g} Hz, must be 0 or more and not 0 "
            "throughout. Correct speed.channel."
        )
    step = float(recording.time[-1] - recording.time[0]) / (len(speed) - 1)
    angle = 2.0 * np.pi * step * np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))])
    source = f"speed of {shown(name)} by the machine file, uncertainty {100 * uncertainty:g} %"
    if uncertainty <= LEAST:
        return Rotation(angle=angle, source=source, error=uncertainty, absolute=False)
    factor, distance = by_multiples(_channels(recording), angle, kinematics, uncertainty)
    if distance > uncertainty / 2:
        source += "; the multiples of the shafts in the envelope do not determine it better"
        return Rotation(angle=angle, source=source, error=uncertainty, absolute=False, likely=factor)
    source += "; the multiples of the shafts in the envelope determine it better"
    return Rotation(angle=factor * angle, source=source, error=max(distance, LEAST), absolute=False)


def _ratio(kinematics: Kinematics, name: str, what: str) -> float:
    """Speed ratio, relative to the first shaft, of the shaft `name` at which `what` is measured."""
    known = {shaft.name: shaft.ratio for shaft in kinematics.shafts}
    if name not in known:
        raise RotationError(
            f"the {what} is on {shown(name)}, the machine has the shafts {_listed(list(known))}. Name one of them."
        )
    return known[name]


def _listed(names: list[str]) -> str:
    return ", ".join(shown(name) for name in names)
