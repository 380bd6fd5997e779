"""Run-ups: orders stay sharp while the speed changes, cuts read amplitudes, resonances stand still over frequency."""

import numpy as np
import pytest

from pipelines.signals.orders.order_spectra import OrderError, frequency_waterfall, order_waterfall

RATE = 5000.0


def run_up(seconds=6.0, top=30.0):
    """Time, angle of a shaft that climbs evenly to `top` Hz."""
    time = np.arange(int(seconds * RATE)) / RATE
    return time, np.pi * top * time**2 / seconds


def test_a_line_that_follows_the_shaft_keeps_its_order_and_amplitude():
    time, angle = run_up()
    signal = 2.0 * np.cos(25 * angle + 0.3) + 0.5 * np.cos(31.5 * angle)
    found = order_waterfall(signal, time, angle, shaft="shaft_1")
    np.testing.assert_allclose(found.cut(25.0), 2.0, rtol=2e-3)
    np.testing.assert_allclose(found.cut(31.5), 0.5, rtol=5e-3)
    assert found.cut(40.0).max() < 1e-3
    assert np.all(np.diff(found.speed) > 0)


def test_a_fixed_frequency_crosses_the_orders_and_stands_still_over_frequency():
    time, angle = run_up()
    signal = np.cos(2 * np.pi * 600.0 * time)
    flat = frequency_waterfall(signal, time, angle, shaft="shaft_1")
    assert set(flat.line[flat.amplitude.argmax(axis=1)].tolist()) == {600.0}
    climbing = order_waterfall(signal, time, angle, shaft="shaft_1")
    peaks = climbing.line[climbing.amplitude.argmax(axis=1)]
    fast = climbing.speed > 0.5 * climbing.speed.max()
    np.testing.assert_allclose(peaks[fast] * climbing.speed[fast] / (2 * np.pi), 600.0, rtol=0.1)


def test_nothing_folds_back_from_high_frequencies_at_low_speed():
    """A tone near half the rate lies, at low speed, far beyond the orders that are shown."""
    time, angle = run_up()
    found = order_waterfall(np.cos(2 * np.pi * 2300.0 * time), time, angle, shaft="shaft_1")
    slow = found.line < 60.0  # 2300 Hz is order 76 at the highest speed, and more below
    assert found.amplitude[:, slow].max() < 1e-3


def test_lines_near_half_of_the_rate_keep_their_amplitude():
    time, _ = run_up()
    steady = 2 * np.pi * 25.0 * time
    found = order_waterfall(np.cos(86 * steady), time, steady, shaft="shaft_1")  # 2150 Hz of 5000
    np.testing.assert_allclose(found.cut(86.0)[1:-1], 1.0, rtol=1e-3)


def test_the_sense_of_rotation_does_not_matter():
    time, angle = run_up()
    signal = np.cos(20 * angle)
    one, other = (order_waterfall(signal, time, sense * angle, shaft="s").cut(20.0) for sense in (1, -1))
    np.testing.assert_allclose(one, other, rtol=1e-9)


def test_a_cut_follows_a_frequency_waterfall_as_well():
    time, angle = run_up(seconds=20.0)
    found = frequency_waterfall(np.cos(25 * angle), time, angle, shaft="shaft_1")
    fast = found.speed > 0.3 * found.speed.max()
    np.testing.assert_allclose(found.cut(25.0)[fast], 1.0, rtol=0.05)


@pytest.mark.parametrize(
    ("options", "message"),
    [({"revolutions": 500}, "window takes 500"), ({"angle": np.zeros(30000)}, "rest has no orders")],
)
def test_what_has_no_orders_is_refused(options, message):
    time, angle = run_up()
    given = {"angle": angle, "shaft": "shaft_1"} | options
    with pytest.raises(OrderError, match=message):
        order_waterfall(np.cos(angle), time, **given)


def test_an_order_beyond_the_signal_is_refused():
    time, angle = run_up()
    with pytest.raises(OrderError, match="beyond the highest line"):
        order_waterfall(np.cos(angle), time, angle, shaft="shaft_1").cut(1e4)
