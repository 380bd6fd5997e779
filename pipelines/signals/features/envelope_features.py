"""Features of the squared envelope over the turns of a shaft: its orders, and the energy of every tooth.

The envelope spectrum of the diagnosis is `pipelines.signals.spectrum.envelope_spectrum`.

References
----------
McFadden (1986), J. Vib. Acoust. 108(2), 165-170 (a damaged tooth modulates the mesh once a turn); Ho & Randall (2000),
Mech. Syst. Signal Process. 14(5), 763-788 (spectrum of the squared envelope).
"""

from __future__ import annotations

import numpy as np

ENVELOPE_HARMONICS = 5
FINE, RISE = 20, 2  # places per pitch for the beginning of an impact, and pitches before its maximum


def envelope_orders(envelope: np.ndarray) -> np.ndarray:
    """Root sum square (channel,) of the orders 1 to 5 of the averaged squared envelope, divided by its mean.

    Parameters
    ----------
    envelope : squared envelope (channel, turn, place)
    """
    averaged = envelope.mean(axis=1)
    lines = 2.0 * np.abs(np.fft.rfft(averaged, axis=-1))[:, 1 : ENVELOPE_HARMONICS + 1] / averaged.shape[-1]
    return np.sqrt(np.sum(lines**2, axis=-1)) / averaged.mean(axis=-1)


def tooth_energies(envelope: np.ndarray, teeth: int) -> np.ndarray:
    """Mean of the squared envelope (channel, tooth) while each tooth of a gear passes, over all turns.

    Tooth i passes from angle 2 pi i / teeth to 2 pi (i + 1) / teeth.
    """
    averaged = envelope.mean(axis=1)
    places = averaged.shape[-1]
    total = np.concatenate([np.zeros((len(averaged), 1)), np.cumsum(averaged, axis=-1)], axis=-1)
    edges = np.arange(teeth + 1) * places / teeth
    below = np.minimum(edges.astype(int), places - 1)
    at = total[:, below] + (edges - below) * averaged[:, below]
    return np.diff(at, axis=-1) * teeth / places


def tooth_contrast(energies: np.ndarray) -> np.ndarray:
    """Square root of the largest energy of a tooth (channel,), divided by the median of all teeth.

    The teeth of a healthy gear with pitch deviations differ little; a local fault concentrates the energy at one tooth.
    """
    return np.sqrt(energies.max(axis=-1) / np.median(energies, axis=-1))


def impact_place(energies: np.ndarray, backwards: bool) -> float:
    """Angle in pitches at which the vibration of the strongest impact begins.

    The vibration rises at once and decays over a time, which is more pitches at a higher speed. Therefore its beginning
    counts: the first place, at most RISE pitches before the highest energy in the sense of rotation, with half of it.

    Parameters
    ----------
    energies : from `tooth_energies` (channel, place) for FINE times the number of teeth
    backwards : whether the angle decreases over time
    """
    level = np.mean(energies / np.median(energies, axis=-1, keepdims=True), axis=0)
    sense = -1 if backwards else 1
    before = int(np.argmax(level)) + sense * np.arange(-RISE * FINE, 1)
    begin = before[np.argmax(level[before % len(level)] >= 0.5 * level.max())]
    return float(begin + 0.5) / FINE
