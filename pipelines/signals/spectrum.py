"""Amplitude and envelope spectra over whole revolutions, line amplitudes and the local floor.

In a segment of n revolutions of the monitored shaft, the line k f_r is on the bin k n and does not leak. Amplitudes are
one-sided peak amplitudes with a Hann window, A = 2 |sum w x exp(-i 2 pi f t)| / sum w: for a tone A cos(2 pi f t) on a
bin the result is A. The window widens a line by one bin on each side, which does not reach the neighbouring orders. It
reduces the leakage of components that do not repeat with the shaft (rope mode, decaying resonances) into the bins
between the orders, where the floor is measured.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fem.numerics.sinc_interpolation import HALF_WIDTH, interpolated
from fem.storage.records import Record, array, integer, scalar

LINE_HALF_WIDTH = (
    2  # bins on either side of an order that belong to the line (zero of the Hann window), not to the floor
)
FEWEST_REVOLUTIONS = 2 * LINE_HALF_WIDTH + 2  # fewer leave no bins between the orders for a local floor
SAMPLE_TOLERANCE = 1e-3  # samples; a segment this close to a whole number of samples is not resampled


class SpectrumError(ValueError):
    """The window in time, the band or the requested frequencies do not fit the signal."""


@dataclass(frozen=True, kw_only=True)
class Segment:
    """A whole number of revolutions at the end of a window, where transients of a preceding ramp have decayed most.

    `start` (s) is counted from the first sample of the record. `samples` and `rate` (Hz) are those after resampling;
    the rate is the recorded one unless `resampled`.
    """

    start: float
    revolutions: int
    samples: int
    rate: float
    resampled: bool

    @property
    def duration(self) -> float:
        """Duration in s of the whole revolutions."""
        return self.samples / self.rate


@dataclass(frozen=True, eq=False, kw_only=True)
class Spectrum(Record):
    """One-sided peak amplitudes at equidistant frequencies from 0 Hz."""

    plotted = ("frequency", "amplitude")
    revolutions: int = integer()  # revolutions of the monitored shaft in the segment: bins per order
    frequency: np.ndarray = array("bin", units="Hz")
    amplitude: np.ndarray = array("bin", units="m s-2")
    band_low: float = scalar(units="Hz")
    band_high: float = scalar(units="Hz")

    @property
    def resolution(self) -> float:
        """Distance of two bins in Hz."""
        return float(self.frequency[1])

    def lines(self, frequencies: ArrayLike, reach: ArrayLike = 0.0) -> np.ndarray:
        """Largest amplitude (line,) within `reach` (Hz, of all lines or of each) of each frequency (Hz).

        The nearest bin is always included. Without reach it is the only one.

        Raises
        ------
        SpectrumError : a frequency is beyond the last bin
        """
        found = []
        for frequency, width in np.broadcast(frequencies, reach):
            low, high = (frequency - width) / self.resolution, (frequency + width) / self.resolution
            nearest = round(frequency / self.resolution)
            if nearest >= self.amplitude.size:
                raise SpectrumError(
                    f"line {frequency:.4f} Hz: beyond the last bin of the spectrum, {self.frequency[-1]:.4f} Hz. "
                    "Increase the sampling rate."
                )
            found.append(self.amplitude[min(math.ceil(low), nearest) : max(math.floor(high), nearest) + 1].max())
        return np.array(found)

    def floors(self, frequencies: Sequence[float] | np.ndarray) -> np.ndarray:
        """Local floor at lines: the median amplitude of the bins between the orders, within one order of the line.

        Bins within `LINE_HALF_WIDTH` of a multiple of the revolution frequency (0 Hz included) are omitted.

        Raises
        ------
        SpectrumError : the segment has fewer than FEWEST_REVOLUTIONS revolutions
        """
        if self.revolutions < FEWEST_REVOLUTIONS:
            raise SpectrumError(
                f"local floor: {self.revolutions} revolutions leave no bins between the orders, "
                f"at least {FEWEST_REVOLUTIONS} are needed. Use a longer window."
            )
        bins = np.arange(self.amplitude.size)
        distance = np.abs(bins - np.rint(bins / self.revolutions) * self.revolutions)
        between = bins[distance > LINE_HALF_WIDTH]
        centres = np.rint(np.asarray(frequencies, dtype=float) / self.resolution)
        near = (between[np.abs(between - centre) <= self.revolutions] for centre in centres)
        return np.array([np.median(self.amplitude[own]) for own in near])


def whole_revolutions(times: tuple[float, float], rate: float, revolution_frequency: float) -> Segment:
    """The longest stretch of whole revolutions in a window whose length is a whole number of samples.

    The number of revolutions is reduced, to half of those in the window at most, until the duration is a whole number
    of samples (within `SAMPLE_TOLERANCE`). If no number is suitable, all revolutions in the window are resampled to the
    nearest whole number of samples. Example: at 10 kHz, 900 rpm and 20/55 teeth a window of 2 s contains ten
    revolutions of the wheel (18333.33 samples) and is cut to nine (1.65 s, 16,500 samples).

    Parameters
    ----------
    times : start and end of the window, s from the first sample
    rate : sampling rate, Hz
    revolution_frequency : f_r, Hz

    Raises
    ------
    SpectrumError : not one revolution fits
    """
    start, end = times
    largest = math.floor((end - start) * revolution_frequency * (1 + 1e-12))
    if largest < 1:
        raise SpectrumError(
            f"window {start:g} to {end:g} s: {(end - start) * revolution_frequency:.3f} revolutions at "
            f"{revolution_frequency:.4f} Hz, at least 1 is needed. Use a longer window."
        )
    for count in range(largest, largest // 2, -1):
        exact = count * rate / revolution_frequency
        if abs(exact - round(exact)) <= SAMPLE_TOLERANCE:
            samples = round(exact)
            first = round(end * rate) - samples
            return Segment(start=first / rate, revolutions=count, samples=samples, rate=rate, resampled=False)
    duration = largest / revolution_frequency
    margin = min(end - start - duration, HALF_WIDTH / rate)  # interpolation needs samples beyond the last one
    samples = round(duration * rate)
    return Segment(
        start=end - margin - duration,
        revolutions=largest,
        samples=samples,
        rate=samples / duration,
        resampled=True,
    )


def cut(signal: np.ndarray, rate: float, segment: Segment) -> np.ndarray:
    """The samples of a segment along the first axis, resampled by band-limited interpolation if it is `resampled`.

    Raises
    ------
    SpectrumError : the segment reaches beyond the record
    """
    signal = np.asarray(signal, dtype=float)
    position = (segment.start + np.arange(segment.samples) / segment.rate) * rate
    if position[0] < -1e-6 or position[-1] > signal.shape[0] - 1 + 1e-6:
        raise SpectrumError(
            f"segment from {segment.start:g} s, {segment.duration:g} s long: beyond the record of "
            f"{signal.shape[0] / rate:g} s. Choose a window inside the record."
        )
    if not segment.resampled:
        return signal[round(position[0]) : round(position[-1]) + 1]
    return np.moveaxis(interpolated(np.moveaxis(signal, 0, -1), position), -1, 0)


def amplitude_spectrum(signal: np.ndarray, segment: Segment) -> Spectrum:
    """Spectrum of a cut segment; of several axes the root sum square, independent of the orientation of the sensor.

    Parameters
    ----------
    signal : float (segment.samples,) or (segment.samples, axes), m/s2
    """
    amplitude = np.sqrt(np.sum(amplitudes(signal.reshape(len(signal), -1)) ** 2, axis=1))
    return _spectrum(amplitude, segment, (0.0, segment.rate / 2))


def envelope(signal: np.ndarray, segment: Segment, band: tuple[float, float]) -> np.ndarray:
    """Envelope (samples,) of the band-passed segment: magnitude of its analytic signal, m/s2.

    The band-pass keeps the FFT lines inside the band; the analytic signal keeps the positive frequencies, doubled. For
    several axes the envelope is the magnitude of the complex vector, sqrt(sum |a_axis|^2). It does not depend on the
    sensor's orientation, and is the amplitude if all axes have the same modulation.

    References
    ----------
    McFadden (1986), Detecting fatigue cracks in gears by amplitude and phase demodulation of the meshing vibration,
    J. Vib. Acoust. 108(2), 165-170.
    """
    low, high = band
    if not 0 <= low < high <= segment.rate / 2:
        raise SpectrumError(
            f"envelope band {low:g} to {high:g} Hz: must increase and lie between 0 and {segment.rate / 2:g} Hz "
            "(half the sampling rate)"
        )
    frequency = np.fft.fftfreq(segment.samples, 1 / segment.rate)
    inside = (frequency >= low) & (frequency <= high) & (frequency > 0)
    lines = np.fft.fft(signal.reshape(len(signal), -1), axis=0) * (2.0 * inside[:, None])
    analytic = np.fft.ifft(lines, axis=0)
    return np.sqrt(np.sum(np.abs(analytic) ** 2, axis=1))


def envelope_spectrum(signal: np.ndarray, segment: Segment, band: tuple[float, float]) -> Spectrum:
    """Amplitude spectrum of the envelope less its mean; the envelope A (1 + m cos(2 pi f t)) has the line A m at f.

    Parameters
    ----------
    signal : float (segment.samples,) or (segment.samples, axes), m/s2
    segment : segment that the signal was cut to
    band : of the envelope, Hz

    Raises
    ------
    SpectrumError : a band outside 0 to half the rate
    """
    length = envelope(signal, segment, band)
    return _spectrum(amplitudes((length - length.mean())[:, None])[:, 0], segment, band)


def with_noise(signal: np.ndarray, rms: float, seed: Sequence[int]) -> np.ndarray:
    """The signal plus white Gaussian sensor noise of the given rms (m/s2) and seed."""
    signal = np.asarray(signal, dtype=float)
    return signal + rms * np.random.default_rng(list(seed)).standard_normal(signal.shape)


def amplitudes(signal: np.ndarray) -> np.ndarray:
    """One-sided peak amplitudes (bins, axes) of a signal (samples, axes), in its unit."""
    return np.abs(complex_amplitudes(signal))


def complex_amplitudes(signal: np.ndarray) -> np.ndarray:
    """The `amplitudes` with their phases: a tone Re(A exp(2 pi i f t)) on a bin has the amplitude A."""
    samples = signal.shape[0]
    weight = _weights(samples)
    amplitude = 2 * np.fft.rfft(signal * weight[:, None], axis=0) / weight.sum()
    amplitude[0] /= 2
    if samples % 2 == 0:
        amplitude[-1] /= 2
    return amplitude


def bin_kernel(samples: int, bins: Sequence[int]) -> np.ndarray:
    """Matrix (samples, bin): signal @ matrix are the `complex_amplitudes` at the given bins.

    The first and the last bin of the spectrum are not allowed, as they are not doubled.
    """
    weight = _weights(samples)
    phase = -2j * np.pi / samples * (np.outer(np.arange(samples), bins) % samples)
    kernel: np.ndarray = (2.0 / weight.sum()) * weight[:, None] * np.exp(phase)
    return kernel


def _weights(samples: int) -> np.ndarray:
    """Hann window, periodic."""
    return 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(samples) / samples)


def _spectrum(amplitude: np.ndarray, segment: Segment, band: tuple[float, float]) -> Spectrum:
    frequency = np.arange(amplitude.size) * segment.rate / segment.samples
    return Spectrum(
        revolutions=segment.revolutions,
        frequency=frequency,
        amplitude=amplitude,
        band_low=band[0],
        band_high=band[1],
    )
