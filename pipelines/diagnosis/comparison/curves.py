"""Order spectra, envelope spectra, cepstra and averages of one channel of several recordings, on common axes.

All recordings are resampled to the same number of places per turn of the first shaft, which gives the same orders.
Their spectra are averaged over blocks of the same number of turns, which gives the same resolution.

References
----------
Fyfe & Munck (1997), Mech. Syst. Signal Process. 11(2), 187-205 (order spectra); Welch (1967), IEEE Trans. Audio
Electroacoust. 15(2), 70-73 (averaged spectra); Ho & Randall (2000), Mech. Syst. Signal Process. 14(5), 763-788
(spectrum of the squared envelope); Randall (2011), Vibration-based Condition Monitoring, Wiley, and Randall
(2017), Mech. Syst. Signal Process. 97, 3-19 (cepstrum).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipelines.diagnosis.comparison.compared_recording import Channel, ComparedRecording
from pipelines.signals.features.recording_features import FeatureError, envelope_band
from pipelines.signals.orders.revolutions import HIGHEST, revolutions
from pipelines.signals.orders.whitening import banded

MOST_TURNS = 64  # in a block; a finer resolution would not be visible in a figure
RAHMONICS = 3  # of each shaft


@dataclass(frozen=True, eq=False, kw_only=True)
class Curves:
    """Curves of `channel` in the first window of each recording.

    `spectrum` (recording, order) has one-sided peak amplitudes in m/s2 over `orders` of the first shaft. `envelope`
    (recording, order) has those of the squared envelope divided by its mean, for the range of orders `band`. `average`
    (recording, place) in m/s2 is the time-synchronous average over a turn of `shaft`, without its mean. `turned` marks
    averages whose angle zero is not known; they are shifted to the best agreement with the first one.
    """

    channel: Channel
    orders: np.ndarray
    spectrum: np.ndarray
    envelope: np.ndarray
    band: tuple[float, float]
    turns: int  # in a block
    shaft: str
    average: np.ndarray
    turned: tuple[bool, ...]

    @cached_property
    def cepstrum(self) -> np.ndarray:
        """Real cepstra (recording, quefrency): inverse Fourier transform of the natural logarithm of the spectrum.

        Lines at equal distances, such as the sidebands of a shaft, become one line at the period of the shaft, and
        lines at multiples of it (rahmonics). The step of the quefrency is 1/(2 orders[-1]) turns of the first shaft.
        """
        found = np.fft.irfft(np.log(np.maximum(self.spectrum, np.finfo(np.float32).tiny)), axis=-1)
        return found[:, : found.shape[1] // 2]

    @property
    def quefrency(self) -> np.ndarray:
        """Quefrencies (quefrency,) of the cepstra, turns of the first shaft."""
        return np.arange(self.cepstrum.shape[1]) / (2.0 * self.orders[-1])

    def rahmonics(self, ratio: float) -> np.ndarray:
        """Sum (recording,) of the cepstra at 1, 2 and 3 turns of a shaft, each the highest of three samples.

        NaN if the blocks are too short. `ratio` is the number of turns of the shaft per turn of the first one.
        """
        places = np.rint(np.arange(1, RAHMONICS + 1) / ratio * 2.0 * self.orders[-1]).astype(int)
        if places[-1] + 1 >= self.cepstrum.shape[1]:
            return np.full(len(self.cepstrum), np.nan)
        return self.cepstrum[:, places[:, None] + np.arange(-1, 2)].max(axis=-1).sum(axis=-1)


def curves(parts: Sequence[ComparedRecording], channel: Channel, shaft: str) -> Curves:
    """The curves of recordings with the same channels and rate.

    Parameters
    ----------
    parts : as `pipelines.diagnosis.comparison.compared_recording.brought_together` gives them
    channel : sensor and axis
    shaft : whose turns are averaged

    Raises
    ------
    FeatureError : the first shaft makes no complete turn in a window, or the sampling rate is too low for an envelope
    """
    first = [part.windows[0].frequency for part in parts]
    highest = min(HIGHEST * part.rate / frequency for part, frequency in zip(parts, first, strict=True))
    guard = max(envelope_band(p.kinematics, p.time, f)[0] / f for p, f in zip(parts, first, strict=True))
    places = 2 * math.ceil(0.5 * highest / HIGHEST)
    row = parts[0].channels.index(channel)
    turns = [_turns(part, row, 1.0, places) for part in parts]
    for part, one in zip(parts, turns, strict=True):
        if not len(one):
            name = part.kinematics.shafts[0].name
            raise FeatureError(
                f"{part.name}: {name} makes less than one revolution in the window. Choose a longer window."
            )
    block = min(MOST_TURNS, *(len(one) for one in turns))
    share = (guard / places, highest / places)
    pairs = [_spectra(one, block, share) for one in turns]
    ratio = parts[0].kinematics.shaft(shaft).ratio
    averages = [
        _average(_turns(part, row, part.kinematics.shaft(shaft).ratio, 2 * math.ceil(0.5 * places / ratio)))
        for part in parts
    ]
    turned = [not all(one.rotation.places_teeth(shaft) for one in (part, parts[0])) for part in parts[1:]]
    laid = [_over(averages[0], one) if known else one for one, known in zip(averages[1:], turned, strict=True)]
    kept = int(highest * block) + 1
    return Curves(
        channel=channel,
        orders=np.arange(kept) / block,
        spectrum=np.array([spectrum[:kept] for spectrum, _ in pairs]),
        envelope=np.array([envelope[:kept] for _, envelope in pairs]),
        band=(guard, highest),
        turns=block,
        shaft=shaft,
        average=np.array([averages[0], *laid]),
        turned=(False, *turned),
    )


def _turns(part: ComparedRecording, row: int, ratio: float, places: int) -> np.ndarray:
    """Values (turn, place) of a channel over the complete turns of a shaft in the first window."""
    span = (part.windows[0].start, part.windows[0].end)
    return revolutions(part.acceleration[row], part.time, part.rotation, ratio, places, span)


def _spectra(turns: np.ndarray, block: int, share: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes (order,) of a signal (turn, place), and those of its squared envelope divided by its mean."""
    envelope = np.abs(banded(turns.ravel(), share, 1.0)[0]) ** 2
    return _amplitudes(turns.ravel(), block * turns.shape[1]), _amplitudes(
        envelope / envelope.mean(), block * turns.shape[1]
    )


def _amplitudes(values: np.ndarray, size: int) -> np.ndarray:
    """One-sided peak amplitudes by Welch's method: mean power of Hann-windowed blocks that overlap by half."""
    from scipy.signal import welch

    return np.sqrt(2.0 * welch(values, nperseg=size, window="hann", scaling="spectrum")[1])


def _average(turns: np.ndarray) -> np.ndarray:
    """The mean turn (place,) less its mean."""
    mean = turns.mean(axis=0)
    return mean - mean.mean()


def _over(first: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The other average, shifted to the maximum of its cross-correlation with the first one."""
    likeness = np.fft.irfft(np.fft.rfft(first) * np.conj(np.fft.rfft(other)), len(first))
    return np.roll(other, int(np.argmax(likeness)))
