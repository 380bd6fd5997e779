"""A speed from vibration is right, conditional or refused: stages must agree, and shafts show their own spacing."""

from dataclasses import replace

import numpy as np
import pytest
import xarray

from pipelines.signals.features.definitions import BY_NAME
from pipelines.signals.features.feature_table import _without, confirmed, with_common_components
from pipelines.signals.features.recording_features import FeatureError, recording_features
from pipelines.signals.orders.kinematics import Bearing, Gear, Kinematics, Shaft
from pipelines.signals.orders.rotation import RotationError
from pipelines.signals.orders.rotation_of import rotation_of
from pipelines.signals.orders.speed_evidence import NO_SIDEBANDS, OrderLevels, unconfirmed

RATE, SPEED = 4000.0, 24.0


def train(*teeth, frequency=SPEED):
    """Pairs in series."""
    ratios = np.cumprod([1.0, *(driving / driven for driving, driven in teeth)])
    return Kinematics(
        shafts=tuple(Shaft(name=f"shaft_{number}", ratio=ratio) for number, ratio in enumerate(ratios, 1)),
        gears=tuple(
            Gear(name=f"stage {stage} {name}", shaft=f"shaft_{stage + place}", stage=stage, teeth=pair[place])
            for stage, pair in enumerate(teeth, 1)
            for place, name in enumerate(("pinion", "wheel"))
        ),
        frequency=frequency,
    )


def vibration(machine, without=(), seconds=6.0, seed=1):
    """Mesh lines, amplitude-modulated by every shaft as pitch deviations of its gears do, and noise; true angle."""
    random = np.random.default_rng(seed)
    time = np.arange(round(seconds * RATE)) / RATE
    angle = 2 * np.pi * SPEED * (time + 0.002 / 3.0 * np.sin(3.0 * time))
    signal = 0.1 * random.standard_normal(len(time))
    for stage, order in machine.mesh_orders().items():
        modulation = np.ones(len(time))
        for gear in machine.gears:
            if gear.stage == stage and gear.shaft not in without:
                place = machine.shaft(gear.shaft).ratio * angle
                for k in range(1, 11):
                    modulation += 0.06 * np.cos(k * place + random.uniform(0, 2 * np.pi))
        for harmonic in (1, 2, 3):
            signal += modulation * np.cos(harmonic * order * angle + random.uniform(0, 2 * np.pi)) / harmonic
    data = {"acceleration": (("time", "sensor", "axis"), signal[:, None, None])}
    return xarray.Dataset(data, coords={"time": time, "sensor": ["s"], "axis": ["z"]}), angle


def error(found, angle):
    """Of the mean speed, by the slope of the found angle over the true one."""
    place = np.arange(len(angle)) - (len(angle) - 1) / 2
    return (place @ found.angle) / (place @ angle) - 1.0


PAIR, TWO = ((25, 62),), ((21, 55), (23, 61))


@pytest.mark.parametrize("teeth", [PAIR, TWO])
@pytest.mark.parametrize("off", [-0.22, 0.04, 0.25])
def test_a_speed_is_found_to_one_in_ten_thousand_within_thirty_percent(teeth, off):
    recording, angle = vibration(train(*teeth))
    found = rotation_of(recording, train(*teeth, frequency=SPEED * (1 + off)))
    assert abs(error(found, angle)) < 1e-4
    assert "shaft_1" not in found.conditional


@pytest.mark.parametrize("off", [-0.45, 0.5])
def test_a_speed_beyond_the_search_is_not_known(off):
    recording, _ = vibration(train(*PAIR))
    try:
        found = rotation_of(recording, train(*PAIR, frequency=SPEED / (1 + off)))
    except RotationError:
        return
    assert set(found.conditional) == {"shaft_1", "shaft_2"}
    with pytest.raises(FeatureError, match="no shaft has a confirmed speed"):
        recording_features(recording, train(*PAIR), found)


@pytest.mark.parametrize("amplitude", [0.0, 0.01, 0.1])
def test_half_the_speed_is_not_confirmed_by_two_lines_of_another_cause(amplitude):
    recording, angle = vibration(train(*PAIR))
    lines = sum(np.cos(order * angle) for order in (11.5, 13.5))  # next to the mesh order at half the speed, 12.5
    levels = OrderLevels([recording.acceleration.values[:, 0, 0] + amplitude * lines], 0.5 * angle)
    assert "a multiple or a fraction" in unconfirmed(levels, train(*PAIR))["shaft_1"]


@pytest.mark.parametrize("teeth", [((25, 61),), ((25, 63),)])
def test_a_wrong_wheel_leaves_the_first_shaft_known_and_the_wheel_conditional(teeth):
    recording, angle = vibration(train(*PAIR))
    found = rotation_of(recording, train(*teeth))
    assert abs(error(found, angle)) < 1e-4
    assert list(found.conditional) == ["shaft_2"]
    assert "another number of teeth" in found.conditional["shaft_2"]


@pytest.mark.parametrize("teeth", [((24, 62),), ((26, 62),)])
def test_a_wrong_pinion_is_never_a_known_speed(teeth):
    recording, _ = vibration(train(*PAIR))
    try:
        found = rotation_of(recording, train(*teeth))
    except RotationError:
        return
    assert "shaft_1" in found.conditional


def test_a_shaft_without_sidebands_is_conditional_and_not_diagnosed():
    machine = train(*PAIR)
    recording, angle = vibration(machine, without=("shaft_1",))
    found = rotation_of(recording, machine)
    assert abs(error(found, angle)) < 1e-4
    assert found.conditional == {"shaft_1": NO_SIDEBANDS}
    (table,) = confirmed([recording_features(recording, machine, found)])
    assert "stage 1 pinion" not in table.component
    assert "stage 1 wheel" in table.component
    assert "stage 1 pinion" in table.left_out[0]
    assert "no sidebands" in table.left_out[0]


def test_a_recording_that_shows_both_shafts_confirms_the_teeth_for_those_that_show_one():
    machine = train(*PAIR)
    recording, _ = vibration(machine)
    found = rotation_of(recording, machine)

    def table(**conditional):
        return recording_features(recording, machine, replace(found, conditional=conditional))

    both, first, second = table(), table(shaft_2=NO_SIDEBANDS), table(shaft_1=NO_SIDEBANDS)
    other = table(shaft_2="its sidebands have the spacing of a gear with another number of teeth")
    assert [one.lines for one in confirmed([both, first, second])] == [both.lines] * 3
    assert not any(one.left_out for one in with_common_components([both, first, second]))
    one, the_other = confirmed([first, second])  # no recording shows both, so that the teeth can be wrong
    assert set(one.component) == {"whole machine", "shaft_1", "stage 1 pinion"}
    assert set(the_other.component) == {"whole machine", "shaft_2", "stage 1 wheel"}
    assert one.left_out == (f"shaft_2 (stage 1 wheel): {NO_SIDEBANDS}",)
    apart, whole = with_common_components([other, both])
    assert apart.lines == whole.lines == one.lines
    assert apart.left_out[-1].endswith("another number of teeth")
    assert "stage 1 wheel" in whole.left_out[-1]


def test_recordings_are_compared_by_the_features_that_all_of_them_have():
    """Mesh orders can be beyond the spectrum at one speed, and lines of a bearing at multiples of the shafts."""
    machine = train(*PAIR)
    recording, _ = vibration(machine)
    whole = recording_features(recording, machine, rotation_of(recording, machine))
    missing = {("stage 1 pinion", "sideband_ratio")}
    found = with_common_components([whole, _without(whole, missing, ())])
    assert found[0].lines == found[1].lines
    assert set(whole.lines) - set(found[0].lines) == missing
    words = f"stage 1 pinion: not all recordings have its {BY_NAME['sideband_ratio'].words}"
    assert [one.left_out for one in found] == [(words,)] * 2


# ---- a known speed


def known(speed, uncertainty, seconds=6.0):
    """Knocks of an outer ring with 0.5 % of slip, in a recording with a known speed."""
    time = np.arange(round(seconds * RATE)) / RATE
    turns = SPEED * time
    knocks = np.exp(-200.0 * ((3.58 * 0.995 * turns) % 1.0) / (3.58 * SPEED)) * np.sin(2 * np.pi * 1200.0 * time)
    signal = knocks + 0.1 * np.random.default_rng(1).standard_normal(len(time))
    attributes = {"shaft": "shaft_1", "uncertainty": uncertainty}
    data = {
        "acceleration": (("time", "sensor", "axis"), signal[:, None, None]),
        "known_speed": ("time", np.full(len(time), speed), attributes),
    }
    return xarray.Dataset(data, coords={"time": time, "sensor": ["s"], "axis": ["z"]})


PLAIN = Kinematics(
    shafts=(Shaft(name="shaft_1", ratio=1.0),),
    bearings=(Bearing(name="DE", shaft="shaft_1", orders={"BPFO": 3.58, "BPFI": 5.1}),),
)


def test_a_constant_speed_gives_bearings_and_no_averages_over_turns():
    recording = known(1.004 * SPEED, 0.005)
    found = rotation_of(recording, PLAIN)
    assert np.ptp(found.angle) / (2 * np.pi) == pytest.approx(1.004 * SPEED * 6.0, rel=1e-3)
    assert found.error == 0.005
    table = recording_features(recording, PLAIN, found)
    assert set(table.component) == {"whole machine", "DE BPFO", "DE BPFI"}
    assert "known to 0.72 turns" in table.left_out[0]
    levels = dict(zip(table.component, table.value[0], strict=True))
    assert levels["DE BPFO"] > 4 * levels["DE BPFI"]


def test_a_speed_known_well_gives_the_shaft_too():
    table = recording_features(known(SPEED, 0.0005), PLAIN, rotation_of(known(SPEED, 0.0005), PLAIN))
    assert ("shaft_1", "order_1") in table.lines


def test_a_speed_below_zero_is_refused():
    with pytest.raises(RotationError, match=r"must be 0 or more.*Correct speed.channel"):
        rotation_of(known(-SPEED, 0.005), PLAIN)
