"""Features equal the values that follow by hand from signals of known orders."""

import re

import numpy as np
import pytest

from pipelines.signals.features.average_features import meshing, synchronous
from pipelines.signals.features.envelope_features import (
    FINE,
    envelope_orders,
    impact_place,
    tooth_contrast,
    tooth_energies,
)
from pipelines.signals.features.passing import PASSING, SIDEBANDS, pass_levels
from pipelines.signals.features.statistics import kurtosis
from pipelines.signals.features.synchronous_averages import Average, average_power
from pipelines.signals.features.unresolved_passes import unresolved_passes
from pipelines.signals.orders.kinematics import Bearing, Gear, Kinematics, Shaft
from pipelines.signals.orders.whitening import banded

PLACES, TURNS = 1024, 30
THETA = 2 * np.pi * np.arange(PLACES) / PLACES


def repeated(turn):
    return np.tile(turn, (TURNS, 1))[None]


def features(turn, teeth=20):
    averaged = Average(values=repeated(turn).mean(axis=1), orders=400, teeth=[teeth])
    return {name: float(value[0]) for name, value in (synchronous(averaged) | meshing(averaged, teeth)).items()}


def test_mesh_orders_and_sidebands_are_read_and_taken_out():
    found = features(
        2.0 * np.cos(20 * THETA)
        + 0.3 * np.cos(19 * THETA + 1.0)
        + 0.5 * np.sin(21 * THETA)
        + 0.2 * np.cos(23 * THETA)
        + 0.1 * np.cos(40 * THETA)
        + 0.7 * np.cos(THETA)
        + 0.05 * np.cos(2 * THETA)
    )
    assert found["mesh_1"] == pytest.approx(2.0)
    assert found["mesh_1_lower"] == pytest.approx(0.3)
    assert found["sideband_ratio"] == pytest.approx((0.3 + 0.5 + 0.2) / 2.0)
    assert found["residual_rms"] == pytest.approx(np.sqrt((0.3**2 + 0.5**2 + 0.2**2 + 0.05**2) / 2))
    assert found["difference_rms"] == pytest.approx(0.2 / np.sqrt(2))
    assert found["fm4"] == pytest.approx(1.5)  # kurtosis of a sine


def test_fm0_is_the_range_over_the_mesh_amplitudes():
    found = features(2.0 * np.cos(20 * THETA) + 0.5 * np.cos(40 * THETA))
    lowest = 2.0 * -0.9375 + 0.5 * (2 * 0.9375**2 - 1)  # where sin(x) (2 + 2 cos x) changes sign next to the maximum
    values = 2.0 * np.cos(20 * THETA) + 0.5 * np.cos(40 * THETA)
    assert values.min() <= lowest
    assert found["fm0"] == pytest.approx(np.ptp(values) / 2.5)


def test_the_envelope_of_a_modulated_mesh_has_the_orders_of_its_square():
    depth = 0.4
    turn = (1 + depth * np.cos(THETA)) * np.cos(100 * THETA)
    band, _ = banded(repeated(turn).reshape(1, -1), (50 / PLACES, 150 / PLACES), 1.0)
    envelope = np.abs(band.reshape(1, TURNS, PLACES)) ** 2
    expected = np.hypot(2 * depth, depth**2 / 2) / (1 + depth**2 / 2)
    assert envelope_orders(envelope)[0] == pytest.approx(expected, rel=1e-6)


def test_a_whitened_impact_stands_out_of_a_resonance_that_hides_it():
    random = np.random.default_rng(6)
    lines = np.fft.rfft(random.standard_normal(TURNS * PLACES))
    order = np.arange(len(lines)) / TURNS
    strong = np.fft.irfft(lines * (1.0 + 100.0 / (1.0 + ((order - 200.0) / 10.0) ** 2)))
    impact = np.zeros(PLACES)
    impact[333] = 15.0
    signal = (strong.reshape(1, TURNS, PLACES) + impact).reshape(1, -1)
    assert kurtosis(signal.reshape(TURNS, PLACES).mean(axis=0)) < 4.0
    _, white = banded(signal, (20.0 / PLACES, 450.0 / PLACES), 5.0 / PLACES)
    white = white.reshape(TURNS, PLACES).mean(axis=0).real
    assert kurtosis(white) > 10.0
    assert abs(int(np.argmax(white)) - 333) <= 1


def test_a_band_without_power_stays_without():
    assert not np.any(banded(np.zeros((2, 64)), (0.1, 0.4), 0.1))


@pytest.mark.parametrize("decay", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("backwards", [False, True])
def test_an_impact_begins_at_one_place_however_long_it_decays(decay, backwards):
    """The impact is 11.2 pitches after the mark; the faster the shaft, the more pitches its vibration lasts."""
    teeth, rise = 37, 0.4
    after = (np.arange(PLACES) * teeth / PLACES - 11.2) * (-1 if backwards else 1) % teeth
    envelope = 1.0 + 50.0 * (after / rise * np.exp(1.0 - after / rise) + np.exp(-after / decay))
    energies = tooth_energies(np.broadcast_to(envelope, (2, TURNS, PLACES)), FINE * teeth)
    assert impact_place(energies, backwards) == pytest.approx(11.2, abs=0.2)


def test_the_energy_of_the_tooth_that_rings_stands_out():
    envelope = np.ones((2, TURNS, PLACES))
    teeth = 37  # no divisor of the places
    start, stop = (round(PLACES * edge / teeth) for edge in (11, 12))
    envelope[:, :, start:stop] = 9.0
    energies = tooth_energies(envelope, teeth)
    assert tooth_contrast(energies) == pytest.approx(3.0, rel=0.02)
    assert energies.mean(axis=-1) == pytest.approx(envelope.mean(axis=(1, 2)))


@pytest.mark.parametrize("noise", [0.0, 1.0, 5.0])
def test_an_average_retains_the_power_of_the_noise_divided_by_the_number_of_turns(noise):
    """A line of power 1 repeats; the average of N turns contains 1/N of the power of the noise."""
    random = np.random.default_rng(8)
    turns = np.sqrt(2.0) * repeated(np.cos(20 * THETA)) + noise * random.standard_normal((4, TURNS, PLACES))
    left = noise**2 / TURNS
    retained, whole = average_power(turns)
    assert retained == pytest.approx(np.full(len(turns), left), rel=0.1, abs=1e-12)
    assert whole == pytest.approx(np.full(len(turns), 1.0 + left), rel=0.1)


def test_impulses_that_pass_stand_above_the_floor_and_others_do_not():
    random = np.random.default_rng(4)
    length = TURNS * PLACES
    places = np.round(np.arange(0, TURNS * 3.58) / 3.58 * PLACES).astype(int)
    signal = 0.1 * random.standard_normal(length)
    signal[places[places < length]] += 3.0
    envelope = np.abs(banded(signal[None], (0.1, 0.45), 0.05)[0].reshape(1, TURNS, PLACES)) ** 2
    found = pass_levels(envelope, {"BPFO": 3.58, "BPFI": 4.6})
    assert found["BPFO", PASSING][0] > 20.0
    assert found["BPFI", PASSING][0] < 5.0


def test_a_rolling_element_is_recognised_by_the_sidebands_of_the_cage():
    random = np.random.default_rng(9)
    turn = np.arange(60 * 256) / 256
    bursts = np.exp(30.0 * (np.cos(2.0 * np.pi * 4.8 * turn) - 1.0))
    in_load_zone = np.exp(5.0 * (np.cos(2.0 * np.pi * 0.4 * turn) - 1.0))
    noise = 0.03 * random.standard_normal(len(turn))
    envelopes = np.stack([bursts * in_load_zone + noise, bursts + noise]).reshape(2, 60, 256)
    found = pass_levels(envelopes, {"2 BSF": 4.8}, sidebands={"2 BSF": 0.4})
    modulated, even = 20.0 * np.log10(found["2 BSF", SIDEBANDS])
    assert modulated > even + 10.0
    assert modulated > 20.0


def test_pass_orders_need_turns_enough():
    envelope = np.random.default_rng(5).random((1, 5, PLACES))
    assert pass_levels(envelope, {"FTF": 0.4}) == {}


def test_a_pass_order_at_a_multiple_of_a_shaft_is_omitted_up_to_the_window_that_separates_them():
    """BPFO is 107.4 Hz, and 2 x shaft_2 107.1 Hz. Two of the multiples 1, 2, 3 must differ by a line."""
    orders, speed, rate = {"BPFO": 3.58}, 30.0, 12_000.0
    shafts = (Shaft(name="shaft_1", ratio=1.0), Shaft(name="shaft_2", ratio=1.785))
    machine = Kinematics(shafts=shafts, bearings=(Bearing(name="E", shaft="shaft_1", orders=orders),))
    (reason,) = unresolved_passes(machine, speed, 1.0, rate).values()
    assert "(107.4 Hz) is not separated from 2 x shaft_2 (107.1 Hz); the window has 1 s, " in reason
    needed = float(re.search(r"([\d.]+) s are enough", reason)[1])
    assert needed == pytest.approx(1.0 / (2 * 0.3), rel=0.06)
    random = np.random.default_rng(6)
    for seconds, there in ((0.9 * needed, False), (1.05 * needed, True)):
        assert (unresolved_passes(machine, speed, seconds, rate) == {}) == there
        envelope = random.random((1, round(seconds * speed), 400))
        assert (("BPFO", PASSING) in pass_levels(envelope, orders, (1.0, 1.785))) == there


def test_multiples_of_the_order_at_which_the_same_teeth_meet_again_are_no_impacts_of_a_bearing():
    """21 and 49 teeth meet again after seven turns of the pinion: a healthy pair has lines at 1/7 of its order."""
    shafts = (Shaft(name="shaft_1", ratio=1.0), Shaft(name="shaft_2", ratio=21 / 49))
    gears = (Gear(name="p", shaft="shaft_1", stage=1, teeth=21), Gear(name="w", shaft="shaft_2", stage=1, teeth=49))
    bearing = Bearing(name="E", shaft="shaft_1", orders={"BPFO": 3.569, "BSF": 2.31})
    machine = Kinematics(shafts=shafts, gears=gears, bearings=(bearing,))
    repeat = machine.tooth_repeats()[1]
    assert repeat == pytest.approx(1 / 7)
    random = np.random.default_rng(8)
    for turns, there in ((42, False), (400, True)):
        comb = np.cos(2.0 * np.pi * np.arange(turns * 256)[:, None] / 256 * repeat * np.arange(1, 110)).sum(axis=1)
        envelope = (comb + random.standard_normal(len(comb))).reshape(1, turns, 256)
        alone = pass_levels(envelope, bearing.strikes, (1.0, 21 / 49))
        assert alone["E BPFO", PASSING][0] > 10.0  # 20 dB
        found = pass_levels(envelope, bearing.strikes, (1.0, 21 / 49), repeats=[repeat])
        assert (("E 2 BSF", PASSING) in found) == there
        assert all(level[0] < 10.0 for level in found.values())
    reasons = unresolved_passes(machine, 24.0, 42 / 24.0, 12_000.0)
    assert all("at which the same teeth meet again" in reason for reason in reasons.values())
    assert len(reasons) == 2


def test_a_pass_order_above_the_spectrum_is_named_with_this_reason():
    machine = Kinematics(
        shafts=(Shaft(name="shaft_1", ratio=1.0),),
        bearings=(Bearing(name="E", shaft="shaft_1", orders={"BPFO": 3.58, "BPFI": 5.42}),),
    )
    assert unresolved_passes(machine, 30.0, 60.0, 600.0) == {
        "E BPFI": "multiples of its pass frequency (162.6 Hz) exceed half of the sampling rate; "
        "the window has 60 s, no longer window is enough"
    }
