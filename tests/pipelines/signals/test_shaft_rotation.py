"""The angle of a machine from recorded angles, from pulses, and from its vibration alone."""

import numpy as np
import pytest
import xarray

from pipelines.signals.orders.kinematics import Gear, Kinematics, Shaft
from pipelines.signals.orders.rotation import RotationError
from pipelines.signals.orders.rotation_of import rotation_of

RATE = 10_000.0
PAIR = Kinematics(
    shafts=(Shaft(name="input", ratio=1.0), Shaft(name="output", ratio=25 / 62)),
    gears=(
        Gear(name="pinion", shaft="input", stage=1, teeth=25),
        Gear(name="wheel", shaft="output", stage=1, teeth=62),
    ),
    frequency=25.0,
)


def recording(channels, rate=RATE, **more):
    """A recording of one sensor; channels (axis, time)."""
    channels = np.atleast_2d(channels)
    time = np.arange(channels.shape[1]) / rate
    return xarray.Dataset(
        {"acceleration": (("time", "sensor", "axis"), channels.T[:, None, :]), **more},
        coords={"time": time, "sensor": ["s"], "axis": list("xyz")[: len(channels)]},
    )


def with_pulses(angle, per_turn, *, phase=0.0, shaft="input", width=0.5, rate=RATE):
    """Square pulses, seen through the filter of a recorder, that begin where per_turn * angle / (2 pi) is whole."""
    place = (per_turn * angle / (2 * np.pi) + phase) % 1.0
    edge = per_turn * np.gradient(angle) / (2 * np.pi)  # a sample, in pulses
    ramp = np.clip(place / edge, 0.0, 1.0) - np.clip((place - width) / edge, 0.0, 1.0)
    attributes = {"pulses_per_turn": per_turn, "shaft": shaft}
    return recording(np.zeros((1, len(angle))), rate, tachometer=("time", ramp, attributes))


def drifting(seconds, speed=25.0, drift=0.003, phase=0.0, rate=RATE):
    """The angle of a shaft whose speed swings slowly."""
    time = np.arange(round(seconds * rate)) / rate
    w = 2 * np.pi * 0.15
    return 2 * np.pi * speed * (time + drift / w * (np.sin(w * time + phase) - np.sin(phase)))


def vibration(angle, generator, noise, channels=2):
    """Three mesh lines and their sidebands at random phases in every channel."""
    found = noise * generator.standard_normal((channels, len(angle)))
    for channel in found:
        for harmonic in (1, 2, 3):
            size = generator.uniform(0.3, 1.0)
            for order, share in ((0.0, 1.0), (1.0, 0.3), (-1.0, 0.3), (25 / 62, 0.3), (-25 / 62, 0.3)):
                channel += size * share * np.cos((25 * harmonic + order) * angle + generator.uniform(0, 2 * np.pi))
    return found


def relative_error(rotation, angle):
    return np.ptp(rotation.angle) / (angle[-1] - angle[0]) - 1.0


# ---- recorded angles


def test_a_recorded_angle_of_any_shaft_gives_that_of_the_first():
    angle = drifting(1.0)
    signal = recording(np.zeros((1, len(angle)))).assign(shaft_angle=(("time", "shaft"), angle[:, None] * 25 / 62))
    found = rotation_of(signal.assign_coords(shaft=["output"]), PAIR)
    np.testing.assert_allclose(found.angle, angle, rtol=1e-12)
    assert found.absolute
    with pytest.raises(RotationError, match="angles of fan, the machine the shafts input, output"):
        rotation_of(signal.assign_coords(shaft=["fan"]), PAIR)


def test_a_recorded_angle_wins_over_a_tachometer():
    angle = drifting(1.0)
    signal = with_pulses(angle, 1).assign(shaft_angle=(("time", "shaft"), 2 * angle[:, None]))
    found = rotation_of(signal.assign_coords(shaft=["input"]), PAIR)
    np.testing.assert_allclose(found.angle, 2 * angle, rtol=1e-12)


# ---- tachometers


@pytest.mark.parametrize("per_turn", [1, 7, 60])
def test_pulses_give_the_angle(per_turn):
    angle = drifting(4.0)
    found = rotation_of(with_pulses(angle, per_turn), PAIR)
    off = found.angle - angle
    assert np.ptp(off) < 2 * np.pi * 25.0 / RATE  # a sample
    assert abs(relative_error(found, angle)) < 3e-5
    assert found.absolute == (per_turn == 1)


def test_an_encoder_of_1024_lines_gives_the_angle_at_five_samples_a_pulse():
    rate = 128_000.0
    angle = drifting(1.0, rate=rate)
    found = rotation_of(with_pulses(angle, 1024, rate=rate), PAIR)
    assert np.ptp(found.angle - angle) < 1e-3
    assert abs(relative_error(found, angle)) < 2e-5


def test_a_level_tells_pulses_from_other_marks():
    """A second, lower mark half a turn on is passed over by a level above it."""
    angle = drifting(4.0)
    signal = with_pulses(angle, 1)
    signal.tachometer.values += 0.6 * with_pulses(angle + np.pi, 1, width=0.2).tachometer.values
    signal.tachometer.attrs["level"] = 0.8
    assert abs(relative_error(rotation_of(signal, PAIR), angle)) < 3e-5


def test_the_mark_of_a_single_pulse_is_angle_zero():
    angle = drifting(2.0) + 4.0
    found = rotation_of(with_pulses(angle, 1), PAIR)
    apart = (found.angle - angle)[500:-500]
    np.testing.assert_allclose(apart, 2 * np.pi * np.rint(apart / (2 * np.pi)), atol=0.02)


def test_a_tachometer_on_another_shaft_is_divided_by_its_ratio():
    angle = drifting(4.0)
    found = rotation_of(with_pulses(angle * 25 / 62, 1, shaft="output"), PAIR)
    assert abs(relative_error(found, angle)) < 5e-5


def test_missing_and_double_pulses_are_mended_and_named():
    angle = drifting(4.0)
    signal = with_pulses(angle, 1)
    pulses = signal.tachometer.values
    turn = np.floor(angle / (2 * np.pi))
    pulses[(turn == 20) | (turn == 50) | (turn == 51)] = 0.0
    bounce = np.flatnonzero((angle / (2 * np.pi)) % 1.0 > 0.1)
    pulses[bounce[np.searchsorted(turn[bounce], 70)] :][:3] = 0.0
    found = rotation_of(signal, PAIR)
    assert "3 missing and 1 double pulses corrected" in found.source
    assert abs(relative_error(found, angle)) < 3e-5


def at_pulses(times, seconds=4.0, rate=8000.0):
    """A recording with one pulse per turn at these times."""
    samples = np.arange(round(seconds * rate))
    corners = (np.asarray(times)[:, None] * rate + [-0.5, 0.5, 8.5, 9.5]).ravel()
    pulses = np.interp(samples, corners, np.tile([0.0, 1.0, 1.0, 0.0], len(times)))
    attributes = {"pulses_per_turn": 1, "shaft": "input"}
    return recording(np.zeros((1, len(samples))), rate, tachometer=("time", pulses, attributes))


EVEN = np.arange(1, 79) / 20.0


@pytest.mark.parametrize("place", [0.1, 0.4, 0.5, 0.7, 0.9])
def test_an_extra_pulse_is_found_wherever_it_lies_between_two_others(place):
    found = rotation_of(at_pulses(np.sort([*EVEN, EVEN[30] + place / 20.0])), PAIR)
    assert np.ptp(found.angle) / (2 * np.pi) == pytest.approx(80.0, rel=1e-4)
    assert "1 double pulses corrected" in found.source


@pytest.mark.parametrize(("kept", "words"), [
    (np.random.default_rng(1).uniform(size=len(EVEN)) > 0.3, "are missing"),
    ((EVEN < 2.0) | (EVEN > 2.6), "1 times between pulses are no whole multiple of the others, the first at"),
])  # fmt: skip
def test_a_tachometer_with_many_lost_pulses_is_refused(kept, words):
    """30 % at random places, and twelve in a row."""
    with pytest.raises(RotationError, match=words):
        rotation_of(at_pulses(EVEN[kept]), PAIR)


def test_pulses_follow_a_ramp_and_never_run_backwards_over_a_stop():
    time = np.arange(round(6 * RATE)) / RATE
    speed = np.interp(time, [0, 2, 2.5, 3.5, 4, 6], [25, 25, 0, 0, 25, 25])
    angle = 2 * np.pi * np.cumsum(speed) / RATE
    with np.errstate(divide="ignore", invalid="ignore"):
        signal = with_pulses(angle, 60)
    signal["tachometer"] = signal.tachometer.fillna(0.0)
    found = rotation_of(signal, PAIR)
    assert np.all(np.diff(found.angle) >= 0.0)


def test_the_uncertainty_of_a_jittering_tachometer_is_honest():
    """Times of pulses scatter by 0.3 ms: the error of the mean speed over its uncertainty is a standard normal."""
    ratios = []
    for seed in range(200):
        generator = np.random.default_rng(seed)
        angle = drifting(3.0, phase=generator.uniform(0, 6), rate=4000.0)
        turns = np.arange(1, int(angle[-1] / (2 * np.pi)))
        at = np.interp(2 * np.pi * turns, angle, np.arange(len(angle))) + 1.2 * generator.standard_normal(len(turns))
        corners = (at[:, None] + [-0.5, 0.5, 9.5, 10.5]).ravel()
        pulses = np.interp(np.arange(len(angle)), corners, np.tile([0.0, 1.0, 1.0, 0.0], len(at)))
        attributes = {"pulses_per_turn": 1, "shaft": "input"}
        signal = recording(np.zeros((1, len(angle))), 4000.0, tachometer=("time", pulses, attributes))
        found = rotation_of(signal, PAIR)
        ratios.append(relative_error(found, angle) / found.error)
    assert 0.7 < np.mean(np.square(ratios)) < 1.4


@pytest.mark.parametrize(
    ("signal", "words"),
    [
        (lambda t: np.zeros_like(t), "0 pulses at the trigger level 0, the values are from 0 to 0"),
        (lambda t: np.where(t > 0.1, np.nan, 0.0), "are not numbers"),
        (lambda t: (t > 0.5).astype(float), "1 pulses at the trigger level 0.5, the values are from 0 to 1"),
    ],
)
def test_a_tachometer_without_pulses_is_refused(signal, words):
    time = np.arange(10_000) / RATE
    attributes = {"pulses_per_turn": 1, "shaft": "input"}
    with pytest.raises(RotationError, match=words):
        rotation_of(recording(np.zeros((1, 10_000)), tachometer=("time", signal(time), attributes)), PAIR)


# ---- the vibration alone


def test_mesh_lines_give_the_angle_of_a_drifting_machine():
    angle = drifting(6.0, speed=24.6, drift=0.005, rate=5000.0)
    found = rotation_of(recording(vibration(angle, np.random.default_rng(1), 0.3), 5000.0), PAIR)
    assert abs(relative_error(found, angle)) < 1e-5
    assert np.ptp((found.angle - angle)[500:-500]) < 2e-3
    assert not found.absolute


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "drift"), [(0.3, 0.003), (2.0, 0.0), (2.0, 0.003)])
def test_the_uncertainty_of_the_tracked_speed_is_honest(noise, drift):
    """200 machines: the error over its uncertainty scatters by 1 or less, and none is far out.

    In strong lines the stated swing of a real shaft is larger than their noise.
    """
    ratios = []
    for seed in range(200):
        generator = np.random.default_rng(seed)
        speed, phase = 25.0 * (1 + generator.uniform(-0.02, 0.02)), generator.uniform(0, 6)
        angle = drifting(4.0, speed, drift, phase, rate=5000.0)
        found = rotation_of(recording(vibration(angle, generator, noise), 5000.0), PAIR)
        ratios.append(relative_error(found, angle) / found.error)
    assert 0.1 < np.mean(np.square(ratios)) < 1.3
    assert np.abs(ratios).max() < 5.0


def test_noise_alone_has_no_speed():
    noise = np.random.default_rng(3).standard_normal((3, 20_000))
    with pytest.raises(
        RotationError, match=r"mesh order of stage 1 has a steady phase, shaft 1 does not turn at 1500 rpm within 30 %"
    ):
        rotation_of(recording(noise, 5000.0), PAIR)


def test_a_speed_that_changes_too_fast_for_the_lines_is_refused():
    time = np.arange(20_000) / 5000.0
    angle = 2 * np.pi * (24.5 * time + 12.0 * np.sin(2 * np.pi * 2.0 * time) / (2 * np.pi) ** 2)
    with pytest.raises(RotationError, match=r"changes by more than 1\.02 Hz per second"):
        rotation_of(recording(vibration(angle, np.random.default_rng(4), 0.1), 5000.0), PAIR)


@pytest.mark.parametrize("lacks", ["gears", "frequency"])
def test_without_teeth_or_speed_a_tachometer_is_asked_for(lacks):
    kinematics = Kinematics(
        shafts=PAIR.shafts,
        gears=() if lacks == "gears" else PAIR.gears,
        frequency=None if lacks == "frequency" else 25.0,
    )
    with pytest.raises(RotationError, match="Record a tachometer"):
        rotation_of(recording(np.ones((1, 20_000))), kinematics)


def test_a_short_recording_is_told_what_is_needed():
    with pytest.raises(RotationError, match=r"lasts 0\.2 s; to find the speed from the mesh of stage 1 takes 0\.694 s"):
        rotation_of(recording(np.ones((1, 2_000))), PAIR)
