"""Whole turns of a shaft: exact tones whatever the speed does, places of teeth that stay, nothing that folds."""

import numpy as np
import pytest

from pipelines.signals.orders.revolutions import revolutions
from pipelines.signals.orders.rotation import Rotation

RATE = 10_000.0


def rotation(angle):
    return Rotation(angle=angle, source="stored", error=0.0, absolute=True)


def uneven(seconds=3.0, speed=12.3):
    """Time and angle of a shaft whose speed swings slowly by 5 % and at 300 Hz by 1 %."""
    time = np.arange(round(seconds * RATE)) / RATE
    turns = speed * (time + 0.05 / 5.0 * np.sin(5.0 * time) + 0.01 / 1885.0 * np.sin(1885.0 * time))
    return time, 2 * np.pi * turns + 1.0


def columns(per_turn):
    return 2 * np.pi * np.arange(per_turn) / per_turn


@pytest.mark.parametrize("share", [0.02, 0.2, 0.4])
def test_a_tone_is_read_within_80_dB_up_to_four_tenths_of_the_rate(share):
    time, angle = uneven()
    order = round(share * RATE / 12.3 / 1.06)  # never above the share, with the swings of the speed
    found = revolutions(np.cos(order * angle), time, rotation(angle), 1.0, 1024)
    assert found.shape[0] >= 35
    assert np.abs(found - np.cos(order * columns(1024))).max() < 1e-4


def test_turns_of_another_shaft_begin_at_its_own_mark():
    time, angle = uneven()
    found = revolutions(np.cos(7 * 0.4 * angle), time, rotation(angle), 0.4, 2048)
    assert np.abs(found - np.cos(7 * columns(2048))).max() < 1e-4


def test_a_tooth_keeps_its_place_in_both_senses_of_rotation():
    time = np.arange(round(4 * RATE)) / RATE
    angle = 200.0 * np.sin(np.pi * time / 4) + 0.3  # forth and back
    bump = np.exp(20 * (np.cos(angle - 2 * np.pi * 0.25) - 1))
    found = revolutions(bump, time, rotation(angle), 1.0, 256)
    assert len(found) > 50
    assert set(found.argmax(axis=1)) == {64}
    np.testing.assert_allclose(found, np.tile(found.mean(axis=0), (len(found), 1)), atol=2e-3)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_turns_laid_end_to_end_are_the_signal_over_the_angle(sense):
    """Of a shaft that runs backwards too: an order and a quarter goes on from turn to turn and stays one line."""
    time, angle = uneven()
    found = revolutions(np.cos(1.25 * angle), time, rotation(sense * angle), 1.0, 256)[:32]
    lines = 2 * np.abs(np.fft.rfft(found.ravel())) / found.size
    assert lines[40] == pytest.approx(1.0, abs=1e-4)
    assert np.delete(lines, 40).max() < 1e-4


def test_only_whole_turns_inside_each_window_are_given():
    time = np.arange(round(4 * RATE)) / RATE
    angle = 2 * np.pi * 10.0 * time
    number = np.floor(angle / (2 * np.pi) + 1e-9)
    for window, turns in (((0.95, 1.32), [10, 11, 12]), ((2.0, 2.1), [20]), ((3.0, 3.05), [])):
        found = revolutions(number, time, rotation(angle), 1.0, 1000, window)
        np.testing.assert_allclose(found[:, 500], turns, atol=1e-6)


def test_nothing_folds_back_where_the_steps_are_wider_than_the_samples():
    time = np.arange(round(3 * RATE)) / RATE
    angle = 2 * np.pi * (12.0 * time + 0.5 * time**2)  # 12 to 15 Hz
    kept, filtered = np.cos(28 * angle), np.cos(36 * angle)
    found = revolutions(np.array([kept, filtered]), time, rotation(angle), 1.0, 64)
    assert np.abs(found[0] - np.cos(28 * columns(64))).max() < 1e-4
    assert np.abs(found[1]).max() < 1e-4


def test_channels_are_cut_alike_and_a_missing_one_stays_missing():
    time, angle = uneven(1.0)
    signal = np.random.default_rng(1).standard_normal((2, 3, len(time)))
    signal[1, 2] = np.nan
    found = revolutions(signal, time, rotation(angle), 1.0, 300)
    np.testing.assert_array_equal(found[0, 1], revolutions(signal[0, 1], time, rotation(angle), 1.0, 300))
    assert np.isnan(found[1, 2]).all()
    assert not np.isnan(found[1, :2]).any()


def test_a_shaft_that_stands_has_no_turns():
    time = np.arange(1000) / RATE
    assert revolutions(np.ones((2, 1000)), time, rotation(np.zeros(1000)), 1.0, 64).shape == (2, 0, 64)
