"""Phases of meshes that share a gear follow from where its mates stand; loops of gears must fit."""

import math

import numpy as np
import pytest

from fem.gears.profile import form_radius
from pipelines.io.errors import SceneError
from pipelines.machine.layout import lay_out
from pipelines.machine.machine_conversion import make_drivetrain
from pipelines.scene.load_scene import load_scene

GEAR = {
    "module_mm": 2.0,
    "face_width_mm": 12.0,
    "pinion_bore_mm": 25.0,
    "wheel_bore_mm": 25.0,
    "mesh": {"model": "iso"},
}
SHAFT = {"sections": [{"start_mm": -60.0, "end_mm": 60.0, "diameter_mm": 25.0}], "bearing_positions_mm": [-50.0, 50.0]}


def scene(*stages):
    """Spur stages (pinion shaft, wheel shaft, z1, z2, direction, further keys) all in one plane."""
    tables = [
        {
            **GEAR,
            "pinion_shaft": one,
            "wheel_shaft": other,
            "pinion_teeth": z1,
            "wheel_teeth": z2,
            "direction_deg": direction,
            "backlash_um": 0.0,
            **keys,
        }
        for one, other, z1, z2, direction, keys in stages
    ]
    count = max(max(stage[:2]) for stage in stages)
    settings = {"stages": tables, "shafts": [SHAFT] * count, "casing": {"model": "none"}, "sensors": []}
    return load_scene("minimal").scene.model_validate(
        {**load_scene("minimal").tree, **settings, "load": {**load_scene("minimal").tree["load"], "shaft": count}}
    )


def cycles(*stages):
    return lay_out(scene(*stages)).cycles_at_start


@pytest.mark.parametrize(("teeth", "wanted"), [(30, 0.5), (31, 0.0)])
def test_an_idler_in_line_is_in_phase_with_odd_teeth_and_out_of_phase_with_even_ones(teeth, wanted):
    """Parker & Lin (2004): opposite a tooth stands a tooth of an even gear, a gap of an odd one."""
    found = cycles((1, 2, 20, teeth, 0.0, {}), (2, 3, teeth, 40, 0.0, {}))
    assert found == pytest.approx((0.0, wanted), abs=1e-9)


@pytest.mark.parametrize("angle", [20.0, -75.0, 163.0])
def test_turning_a_whole_train_leaves_its_phases(angle):
    def train(turn):
        return cycles((1, 2, 20, 31, 10.0 + turn, {}), (2, 3, 31, 40, -17.0 + turn, {}))

    assert train(angle - 10.0) == pytest.approx(train(0.0), abs=1e-9)


@pytest.mark.parametrize("pitches", [3, 8])
def test_mates_whole_pitches_apart_mesh_in_phase(pitches):
    found = cycles((1, 2, 20, 40, 0.0, {}), (1, 3, 20, 40, 360.0 * pitches / 20, {}))
    assert found == pytest.approx((0.0, 0.0), abs=1e-9)


def test_a_mate_further_on_in_the_sense_of_rotation_meets_the_tooth_later():
    """Shaft 1 turns about +y, from z to x: a mate at -3 degrees is met 3 degrees after one at 0."""
    _, second = cycles((1, 2, 20, 40, 0.0, {}), (1, 3, 20, 40, -93.0, {}))
    assert second == pytest.approx(-93.0 / 360 * 20 % 1)


def test_flanks_of_an_idler_touch_both_mates_at_the_derived_phases():
    """Flanks as points of the involute of one idler: turned to where mesh 1 has its contact at the pitch point, and on
    by the derived part of a pitch, its other flank stands at the pitch point of mesh 2."""
    first, second = 25.0, 112.0
    layout = lay_out(scene((1, 2, 20, 33, first, {}), (2, 3, 33, 41, second, {})))
    idler, sense = layout.pairs[0].wheel, layout.senses[1]
    radius = layout.pairs[0].working_radii[1]
    assert form_radius(idler) < radius < idler.tip_radius

    def flank(turn, side, tooth):
        """Angle from x towards z of a flank at the pitch circle: +1 leads in the sense of rotation."""
        half = idler.tooth_thickness(radius) / radius / 2
        return -sense * (turn + 2 * math.pi * tooth / idler.teeth + side * half)

    towards_driver, towards_driven = math.radians(first + 180.0), math.radians(second)
    turn = -sense * towards_driver + idler.tooth_thickness(radius) / radius / 2  # trailing flank of tooth 0 there
    assert math.cos(flank(turn, -1, 0) - towards_driver) == pytest.approx(1.0)
    pitch = 2 * math.pi / idler.teeth
    later = turn - layout.cycles_at_start[1] * pitch  # mesh 2 is at a whole cycle
    misses = [1 - math.cos(flank(later, 1, tooth) - towards_driven) for tooth in range(idler.teeth)]
    assert min(misses) == pytest.approx(0.0, abs=1e-12)


def test_two_gears_on_one_shaft_have_phases_of_their_own():
    apart = {"position_mm": 40.0}
    assert cycles((1, 2, 20, 40, 0.0, {}), (1, 3, 20, 40, 50.0, apart)) == (0.0, 0.0)
    free = {**apart, "cycle_at_start": 0.3}
    assert cycles((1, 2, 20, 40, 0.0, {}), (1, 3, 20, 40, 50.0, free)) == (0.0, 0.3)


def test_a_given_phase_gives_that_of_the_other_stage_of_a_gear():
    even = cycles((1, 2, 20, 30, 0.0, {}), (2, 3, 30, 40, 0.0, {"cycle_at_start": 0.7}))
    assert even == pytest.approx((0.2, 0.7))


def test_the_derived_phase_reaches_the_machine():
    made = scene((1, 2, 20, 30, 0.0, {}), (2, 3, 30, 40, 0.0, {}))
    assert [mesh.cycle_at_start for mesh in make_drivetrain(made).parts.meshes] == pytest.approx([0.0, 0.5])


def test_phases_that_contradict_one_another_are_refused_with_the_value():
    with pytest.raises(SceneError, match=r"stages\.2\.cycle_at_start = 0\.25: must be 0\.5000"):
        cycles((1, 2, 20, 30, 0.0, {"cycle_at_start": 0.0}), (2, 3, 30, 40, 0.0, {"cycle_at_start": 0.25}))


def planets(sun, planet, driven, angles):
    """A gear, idlers around it, and a like gear beyond them: a ring of four gears has two idlers."""
    stages = []
    for number, angle in enumerate(angles):
        stages += [(1, number + 2, sun, planet, angle, {}), (number + 2, len(angles) + 2, planet, driven, -angle, {})]
    return stages


def test_two_idlers_between_two_gears_must_fit_like_planets():
    """By symmetry two equal idlers above and below the line of two gears close the loop where the sum of the turns
    around it is a whole number of teeth; the axes meet at any angle."""
    angle = next(a for a in np.linspace(40.0, 70.0, 30001) if fits(a))
    assert len(cycles(*planets(24, 30, 24, (angle, -angle)))) == 4
    with pytest.raises(SceneError, match="closes a loop of gears that cannot be assembled"):
        cycles(*planets(24, 30, 24, (angle + 1.5, -angle - 1.5)))


def fits(angle):
    """Assembly by counting pitches along the belt that runs around: 4 angle z_sun/360 + ... is whole, in degrees.

    Each gear is turned against its neighbour by the angle between its two mates: 2 angle at the gears of the line,
    180 - 2 angle at the idlers, which count in their own teeth.
    """
    turns = 2 * angle / 360 * 24 * 2 - (180 - 2 * angle) / 360 * 30 * 2
    return abs(turns - round(turns)) < 1e-4
