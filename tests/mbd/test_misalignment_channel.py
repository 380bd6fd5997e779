"""Misalignment angle of bearings: a simply supported shaft under a central force, and the channel in a result."""

import math
from dataclasses import replace

import numpy as np
import pytest
from rotors import DIAMETER, LENGTH, MASS, MODULUS, jeffcott

import gearcase
from fem.casing.reduced.casing_modes import grounded_body
from mbd.parts.channels import further_channels
from mbd.system.statics import equilibrium
from mbd.system.system import assemble

GRAVITY = 9.80665
INERTIA = math.pi * DIAMETER**4 / 64


def tilts(support, disk_mass):
    """Angles (rad) in the bearings of the rotor at rest under its weight, by channel."""
    machine = jeffcott(gravity=GRAVITY, disk_mass=disk_mass)
    bearings = tuple(replace(bearing, support=support) for bearing in machine.bearings)
    further = further_channels(["bearing-misalignment"], bearings=bearings)
    machine = replace(machine, bearings=bearings, probes=further)
    system = assemble(machine, grounded_body({bearing.name: (0.0, bearing.y, 0.0) for bearing in bearings}))
    values = system.channels.displacement @ equilibrium(system).displacement
    return {name: value for name, value in zip(system.channels.names, values, strict=True) if "misalignment" in name}


@pytest.mark.parametrize("support", ["ground", "casing"])
def test_a_central_force_turns_the_ends_by_the_slope_of_the_beam(support):
    """theta = F l^2/(16 E I), also of a Timoshenko beam: M alone turns its sections, E I psi' = M, psi = 0 amid it."""
    heavy, light = tilts(support, MASS), tilts(support, MASS / 2)
    more = {name: heavy[name] - light[name] for name in heavy}
    slope = MASS / 2 * GRAVITY * LENGTH**2 / (16 * MODULUS * INERTIA)
    assert more["bearing_1:misalignment_x"] == pytest.approx(-slope, rel=1e-6)  # the middle sinks along -z
    assert more["bearing_2:misalignment_x"] == pytest.approx(slope, rel=1e-6)
    assert abs(more["bearing_1:misalignment_z"]) < 1e-6 * slope  # no force along x; as exact as the others


@pytest.mark.slow
def test_the_channel_is_recorded_if_a_scene_asks_for_it():
    scene = gearcase.Scene.from_file("minimal").changed(
        {"simulation.end_s": 0.1, "drive.times_s": [0.0, 0.05, 0.1], "diagnosis.windows_s": {}}
    )
    assert "bearing_misalignment" not in gearcase.simulate(scene)
    found = gearcase.simulate(scene.changed({"simulation.channels": ["bearing-misalignment"]})).bearing_misalignment
    assert found.dims == ("time", "bearing", "tilt_axis")
    assert found.attrs["units"] == "rad"
    assert list(found.tilt_axis.values) == ["x", "z"]
    assert np.isfinite(found).all()
