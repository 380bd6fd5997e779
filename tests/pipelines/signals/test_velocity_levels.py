"""Velocity levels of a run: tones in and out of the band, and the words on lost contact."""

import json

import numpy as np
import pytest
import xarray

from pipelines.signals.levels import band_velocity, contact_sentence, level_grid, levels

RATE = 8000.0
TIME = np.arange(int(2 * RATE)) / RATE


@pytest.mark.parametrize(
    ("frequency", "inside"), [(25.0, True), (400.0, True), (990.0, True), (3.0, False), (1500.0, False)]
)
def test_a_tone_has_the_velocity_of_its_amplitude_over_omega_in_the_band_alone(frequency, inside):
    found = band_velocity(3.0 * np.cos(2 * np.pi * frequency * TIME + 0.4)[:, None], RATE)[0]
    exact = 3.0 / np.sqrt(2) / (2 * np.pi * frequency)
    assert found == pytest.approx(exact, rel=2e-3) if inside else found < 1e-3 * exact


def run(**attributes):
    tone = 2.0 * np.cos(2 * np.pi * 100.0 * TIME)
    values = np.stack([tone, 0.5 * tone, 0 * tone], axis=1)[:, None, :]
    dims = ("time", "sensor", "axis")
    coordinates = {"time": TIME, "sensor": ["cover"], "axis": ["x", "y", "z"]}
    return xarray.Dataset({"acceleration": (dims, values)}, coords=coordinates, attrs=attributes)


def test_every_channel_has_its_velocity_and_an_axis_without_signal_has_none():
    tones = run()
    tones["acceleration"] = tones.acceleration.where(tones.axis != "z")  # a sensor that has no z axis
    x, y = levels(tones, {"steady": (0.5, 1.5)})
    assert (x.sensor, x.axis, x.window, y.axis) == ("cover", "x", "steady", "y")
    assert x.acceleration == pytest.approx(2 / np.sqrt(2), rel=1e-3)
    assert x.velocity == pytest.approx(2 / np.sqrt(2) / (200 * np.pi), rel=5e-3)
    assert y.velocity == pytest.approx(0.5 * x.velocity)
    table = level_grid((x, y))
    assert table.headers[2:] == ("acceleration x m/s²", "velocity x mm/s", "acceleration y m/s²", "velocity y mm/s")
    (row,) = table.rows
    assert float(row[3]) == pytest.approx(1000 * x.velocity, rel=5e-3)


def test_lost_contact_is_told_with_its_share_of_the_time():
    counters = {"mesh_1:contact_losses": 12, "mesh_1:microseconds_open": 40_000, "mesh_2:contact_losses": 0}
    assert contact_sentence(run(counters=json.dumps(counters))) == (
        "Drive flanks lost contact: mesh 1 12 times (2 % of the time)."
    )
    assert contact_sentence(run()) == ""
