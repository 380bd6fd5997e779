"""Amplitude and envelope spectra over whole revolutions, line amplitudes and the local floor.

A segment of n revolutions of the faulty shaft puts every line k f_r on the bin k n: nothing leaks, whatever the window.
Amplitudes are one-sided peak amplitudes, A = 2 |sum w x exp(-i 2 pi f t)| / sum w: a tone A cos(2 pi f t) on a bin
reads A with every window. The Hann window is the default: it costs one bin on each side of a line, which whole
revolutions have to spare, and keeps what does not repeat with the shaft (the rope mode, decaying resonances) from
filling the gaps between the orders, where the floor is read.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.numerics.interpolation import HALF_WIDTH, interpolated
from fem.storage.records import Record, array, integer, scalar, text

WINDOWS = ("hann", "boxcar")
LINE_HALF_WIDTH = (
    2  # bins on either side of an order that belong to the line (zero of the Hann window), not to the floor
)
FEWEST_REVOLUTIONS = 2 * LINE_HALF_WIDTH + 2  # fewer leave no bins between the orders for a local floor
SAMPLE_TOLERANCE = 1e-3  # samples; a segment this close to a whole number of samples is not resampled


class SpectrumError(ValueError):
    """The window, the band or the wanted frequencies do not fit the signal."""


@dataclass(frozen=True, kw_only=True)
class Segment:
    """A whole number of revolutions at the end of a window, where the transients of the ramp before it have died most.

    `start` (s) from the first sample of the record, `samples` after resampling, `rate` (Hz) after resampling:
    equal to the recorded rate unless `resampled`.
    """

    start: float
    revolutions: int
    samples: int
    rate: float
    resampled: bool

    @property
    def duration(self) -> float:
        """Length in s, a whole number of revolutions."""
        return self.samples / self.rate


@dataclass(frozen=True, eq=False, kw_only=True)
class Spectrum(Record):
    """One-sided peak amplitudes on equidistant lines from 0 Hz."""

    plotted = ("frequency", "amplitude")
    kind: str = text()  # "spectrum" | "envelope"
    window: str = text()
    revolutions: int = integer()  # revolutions of the faulty shaft in the segment: bins per order
    frequency: np.ndarray = array("bin", units="Hz")
    amplitude: np.ndarray = array("bin", units="m s-2")
    band_low: float = scalar(units="Hz")
    band_high: float = scalar(units="Hz")

    @property
    def resolution(self) -> float:
        """Distance of two bins in Hz."""
        return float(self.frequency[1])

    def lines(self, frequencies: Sequence[float] | np.ndarray) -> np.ndarray:
        """Amplitudes at frequencies (Hz) that fall on bins.

        Raises
        ------
        SpectrumError : a frequency lies more than 2 % of a bin beside every bin, or beyond the last one
        """
        position = np.asarray(frequencies, dtype=float) / self.resolution
        index = np.rint(position).astype(int)
        off = np.abs(position - index)
        if np.any(off > 0.02) or np.any(index < 0) or np.any(index >= self.amplitude.size):
            worst = int(np.argmax(np.where((index < 0) | (index >= self.amplitude.size), np.inf, off)))
            raise SpectrumError(
                f"line {position[worst] * self.resolution:.4f} Hz: not on a bin of {self.resolution:.6f} Hz "
                f"(position {position[worst]:.3f} of {self.amplitude.size - 1}). "
                "Cut the segment to whole revolutions of the shaft of this line."
            )
        return self.amplitude[index]

    def floors(self, frequencies: Sequence[float] | np.ndarray) -> np.ndarray:
        """Local floor at lines on bins: the median amplitude of the bins between the orders, one order to each side.

        Bins within `LINE_HALF_WIDTH` of a multiple of the revolution frequency (0 Hz included) are left out. Needs
        at least six revolutions in the segment.
        """
        bins_per_order = self.revolutions
        if bins_per_order < FEWEST_REVOLUTIONS:
            raise SpectrumError(
                f"local floor: {bins_per_order} revolutions leave no bins between the orders, "
                f"at least {FEWEST_REVOLUTIONS} are needed. Use a longer window."
            )
        centres = np.rint(np.asarray(frequencies, dtype=float) / self.resolution).astype(int)
        bins = np.arange(self.amplitude.size)
        distance = np.abs(bins - np.rint(bins / bins_per_order) * bins_per_order)
        between = distance > LINE_HALF_WIDTH
        floors = np.empty(centres.size)
        for i, centre in enumerate(centres):
            near = between & (np.abs(bins - centre) <= bins_per_order)
            floors[i] = np.median(self.amplitude[near])
        return floors


def whole_revolutions(times: tuple[float, float], rate: float, revolution_frequency: float) -> Segment:
    """The longest stretch of whole revolutions in a window whose length is a whole number of samples.

    Of the revolution counts between the largest that fits and half of it, the largest one whose duration is a whole
    number of samples (within `SAMPLE_TOLERANCE`) is taken; if there is none, the largest that fits, resampled to the
    nearest whole number of samples. At 10 kHz, 900 rpm and 20/55 teeth a window of 2 s holds ten wheel revolutions
    (18333.33 samples) and is cut to nine: 1.65 s, 16,500 samples.

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
    margin = min(end - start - duration, HALF_WIDTH / rate)  # interpolation looks beyond the last sample
    samples = round(duration * rate)
    return Segment(
        start=end - margin - duration,
        revolutions=largest,
        samples=samples,
        rate=samples / duration,
        resampled=True,
    )


def cut(signal: np.ndarray, rate: float, segment: Segment) -> np.ndarray:
    """The samples of a segment along the first axis, resampled by band-limited interpolation where the segment says so.

    Raises
    ------
    SpectrumError : the segment reaches beyond the record
    """
    signal = np.asarray(signal, dtype=float)
    if not segment.resampled:
        first = round(segment.start * rate)
        if first < 0 or first + segment.samples > signal.shape[0]:
            raise SpectrumError(
                f"segment from {segment.start:g} s, {segment.samples} samples: beyond the record of "
                f"{signal.shape[0]} samples. Choose a window inside the record."
            )
        return signal[first : first + segment.samples]
    position = (segment.start + np.arange(segment.samples) / segment.rate) * rate
    if position[0] < -1e-6 or position[-1] > signal.shape[0] - 1 + 1e-6:
        raise SpectrumError(
            f"segment from {segment.start:g} s, {segment.duration:g} s long: beyond the record of "
            f"{signal.shape[0] / rate:g} s. Choose a window inside the record."
        )
    return np.moveaxis(interpolated(np.moveaxis(signal, 0, -1), position), -1, 0)


def amplitude_spectrum(signal: np.ndarray, segment: Segment, window: str = "hann") -> Spectrum:
    """Spectrum of a cut segment; of several axes the root sum square, which no sensor orientation changes.

    Parameters
    ----------
    signal : float (segment.samples,) or (segment.samples, axes), m/s2
    """
    signal = _columns(signal, segment)
    amplitude = np.sqrt(np.sum(amplitudes(signal, window) ** 2, axis=1))
    return _spectrum("spectrum", amplitude, segment, window, (0.0, segment.rate / 2))


def envelope(signal: np.ndarray, segment: Segment, band: tuple[float, float]) -> np.ndarray:
    """Length of the analytic signal of the band-passed segment (samples,), m/s2.

    The band-pass keeps the FFT lines inside the band; the analytic signal keeps the positive frequencies, doubled.
    Of several axes the length of the complex vector, sqrt(sum |a_axis|^2): independent of the sensor's orientation,
    and equal to the amplitude where all axes share one modulation.

    References
    ----------
    McFadden (1986), Detecting fatigue cracks in gears by amplitude and phase demodulation of the meshing vibration,
    J. Vib. Acoust. 108(2), 165-170.
    """
    signal = _columns(signal, segment)
    low, high = band
    if not 0 <= low < high <= segment.rate / 2:
        raise SpectrumError(
            f"envelope band {low:g} to {high:g} Hz: must increase and lie between 0 and {segment.rate / 2:g} Hz "
            "(half the sampling rate)"
        )
    frequency = np.fft.fftfreq(segment.samples, 1 / segment.rate)
    inside = (frequency >= low) & (frequency <= high) & (frequency > 0)
    lines = np.fft.fft(signal, axis=0) * (2.0 * inside[:, None])
    analytic = np.fft.ifft(lines, axis=0)
    return np.sqrt(np.sum(np.abs(analytic) ** 2, axis=1))


def envelope_spectrum(
    signal: np.ndarray, segment: Segment, band: tuple[float, float], window: str = "hann"
) -> Spectrum:
    """Amplitude spectrum of the envelope less its mean; a modulation A (1 + m cos(2 pi f t)) reads A m at f.

    Parameters
    ----------
    signal : float (segment.samples,) or (segment.samples, axes), m/s2
    segment : how the signal was cut
    band : of the envelope, Hz
    window : one of WINDOWS

    Raises
    ------
    SpectrumError : the band lies outside 0 to half the rate, a length other than the segment's, an unknown window
    """
    length = envelope(signal, segment, band)
    amplitude = amplitudes((length - length.mean())[:, None], window)[:, 0]
    return _spectrum("envelope", amplitude, segment, window, band)


def with_noise(signal: np.ndarray, rms: float, seed: Sequence[int]) -> np.ndarray:
    """The signal plus white Gaussian sensor noise of the stated rms (m/s2), drawn from the stated seed."""
    if rms < 0:
        raise SpectrumError(f"sensor noise {rms:g} m/s2: must be 0 or positive")
    signal = np.asarray(signal, dtype=float)
    return signal + rms * np.random.default_rng(list(seed)).standard_normal(signal.shape)


def _columns(signal: np.ndarray, segment: Segment) -> np.ndarray:
    signal = np.asarray(signal, dtype=float)
    signal = signal[:, None] if signal.ndim == 1 else signal
    if signal.shape[0] != segment.samples:
        raise SpectrumError(f"signal of {signal.shape[0]} samples, the segment has {segment.samples}: cut it first")
    return signal


def amplitudes(signal: np.ndarray, window: str) -> np.ndarray:
    """One-sided peak amplitudes (bins, axes) of (samples, axes), whatever the unit."""
    return np.abs(complex_amplitudes(signal, window))


def complex_amplitudes(signal: np.ndarray, window: str) -> np.ndarray:
    """Those of `amplitudes` with their phases: a tone Re(A exp(2 pi i f t)) on a bin reads A."""
    samples = signal.shape[0]
    weight = _weights(samples, window)
    amplitude = 2 * np.fft.rfft(signal * weight[:, None], axis=0) / weight.sum()
    amplitude[0] /= 2
    if samples % 2 == 0:
        amplitude[-1] /= 2
    return amplitude


def bin_kernel(samples: int, bins: Sequence[int], window: str) -> np.ndarray:
    """Matrix (samples, bin) with which signal @ matrix are the `complex_amplitudes` at a few bins, neither first nor
    last of all."""
    weight = _weights(samples, window)
    phase = -2j * np.pi / samples * (np.outer(np.arange(samples), bins) % samples)
    kernel: np.ndarray = (2.0 / weight.sum()) * weight[:, None] * np.exp(phase)
    return kernel


def _weights(samples: int, window: str) -> np.ndarray:
    if window == "hann":
        return 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(samples) / samples)
    if window == "boxcar":
        return np.ones(samples)
    raise SpectrumError(f"window {window!r}: known are {', '.join(WINDOWS)}")


def _spectrum(kind: str, amplitude: np.ndarray, segment: Segment, window: str, band: tuple[float, float]) -> Spectrum:
    frequency = np.arange(amplitude.size) * segment.rate / segment.samples
    return Spectrum(
        kind=kind,
        window=window,
        revolutions=segment.revolutions,
        frequency=frequency,
        amplitude=amplitude,
        band_low=band[0],
        band_high=band[1],
    )
