"""Spectra: amplitudes and modulation of known signals come back exactly."""

import numpy as np
import pytest

from pipelines.signals.spectrum import (
    SpectrumError,
    amplitude_spectrum,
    cut,
    envelope,
    envelope_spectrum,
    whole_revolutions,
    with_noise,
)

RATE = 10_000.0
MESH = 900 / 60 * 20
WHEEL = MESH / 55


def modulated(time, depth=0.3, amplitude=2.0, carrier=MESH, modulation=WHEEL):
    return (
        amplitude * (1 + depth * np.cos(2 * np.pi * modulation * time + 0.4)) * np.cos(2 * np.pi * carrier * time + 1)
    )


@pytest.fixture(scope="module")
def segment():
    return whole_revolutions((0.5, 2.5), RATE, WHEEL)


@pytest.fixture(scope="module")
def time():
    return np.arange(50_000) / RATE


def test_nine_wheel_revolutions_of_the_20_55_stage_are_16500_samples(segment):
    assert pytest.approx(5.4545454545, rel=1e-9) == WHEEL
    assert MESH == 300.0
    assert (segment.revolutions, segment.samples, segment.resampled) == (9, 16_500, False)
    assert segment.start + segment.duration == pytest.approx(2.5, abs=1e-12)


def test_modulated_tone_gives_carrier_and_sidebands(time, segment):
    spectrum = amplitude_spectrum(cut(modulated(time), RATE, segment), segment)
    lines = spectrum.lines([MESH - WHEEL, MESH, MESH + WHEEL, MESH + 2 * WHEEL])
    np.testing.assert_allclose(lines, [0.3, 2.0, 0.3, 0.0], atol=1e-9)
    assert spectrum.frequency[np.argmax(spectrum.amplitude)] == pytest.approx(300.0, rel=1e-12)


def test_envelope_gives_modulation_frequency_and_depth(time, segment):
    piece = cut(modulated(time), RATE, segment)
    spectrum = envelope_spectrum(piece, segment, (150, 450))
    assert spectrum.frequency[np.argmax(spectrum.amplitude)] == pytest.approx(WHEEL, rel=1e-12)
    depth = spectrum.lines([WHEEL, 2 * WHEEL]) / envelope(piece, segment, (150, 450)).mean()
    np.testing.assert_allclose(depth, [0.3, 0.0], atol=1e-9)


def test_resultant_does_not_depend_on_sensor_orientation(time, segment):
    rng = np.random.default_rng(3)
    signal = cut(
        modulated(time)[:, None] * [0.6, -0.2, 0.5] + with_noise(np.zeros((50_000, 3)), 0.1, [1]), RATE, segment
    )
    rotation, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    np.testing.assert_allclose(
        envelope(signal @ rotation.T, segment, (150, 450)), envelope(signal, segment, (150, 450)), atol=1e-12
    )
    np.testing.assert_allclose(
        amplitude_spectrum(signal @ rotation.T, segment).amplitude,
        amplitude_spectrum(signal, segment).amplitude,
        atol=1e-12,
    )


def test_shaft_whose_revolutions_are_no_whole_samples_is_resampled(time):
    wheel = 5.4321987
    segment = whole_revolutions((0.5, 2.5), RATE, wheel)
    assert segment.resampled
    assert segment.revolutions == 10
    assert segment.duration * wheel == pytest.approx(10, rel=1e-12)
    signal = modulated(time, carrier=550 * wheel, modulation=wheel)  # 2988 Hz
    lines = amplitude_spectrum(cut(signal, RATE, segment), segment).lines(wheel * np.array([549, 550, 551, 553]))
    np.testing.assert_allclose(lines, [0.3, 2.0, 0.3, 0.0], atol=1e-5)


def test_floor_is_the_level_of_the_noise_not_of_the_orders(time, segment):
    tones = sum(np.cos(2 * np.pi * k * WHEEL * time) for k in range(1, 100))
    noise = with_noise(np.zeros_like(time), 0.05, [7])
    centres = WHEEL * np.arange(2, 60)
    with_orders = amplitude_spectrum(cut(tones + noise, RATE, segment), segment).floors(centres)
    noise_alone = amplitude_spectrum(cut(noise, RATE, segment), segment).floors(centres)
    np.testing.assert_allclose(with_orders, noise_alone, rtol=1e-9)
    # Rayleigh median of a Hann spectrum: sigma sqrt(4 ENBW / N) sqrt(ln 2), ENBW 1.5
    expected = 0.05 * np.sqrt(4 * 1.5 / segment.samples * np.log(2))
    assert noise_alone.mean() == pytest.approx(expected, rel=0.1)


def test_noise_is_seeded_and_has_the_stated_rms():
    zero = np.zeros(50_000)
    np.testing.assert_array_equal(with_noise(zero, 0.2, [1, 2]), with_noise(zero, 0.2, [1, 2]))
    assert np.std(with_noise(zero, 0.2, [1, 2])) == pytest.approx(0.2, rel=0.02)
    assert np.abs(with_noise(zero, 0.2, [1, 3]) - with_noise(zero, 0.2, [1, 2])).max() > 0.1


def test_what_does_not_fit_is_refused(time, segment):
    with pytest.raises(SpectrumError, match="longer window"):
        whole_revolutions((0.5, 0.6), RATE, WHEEL)
    with pytest.raises(SpectrumError, match="beyond the last bin"):
        amplitude_spectrum(cut(time, RATE, segment), segment).lines([RATE])
    with pytest.raises(SpectrumError, match="half the sampling rate"):
        envelope(cut(time, RATE, segment), segment, (4000, 6000))
    with pytest.raises(SpectrumError, match="beyond the record"):
        cut(time[:20_000], RATE, segment)
    with pytest.raises(SpectrumError, match="no bins between"):
        amplitude_spectrum(cut(time, RATE, s := whole_revolutions((0, 0.8), RATE, WHEEL)), s).floors([WHEEL])
