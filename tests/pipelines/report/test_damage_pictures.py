"""Damaged teeth as they are drawn: their shape and place, and the contact pattern on their flanks."""

import math

import numpy as np
import pytest
from rendering import enclosed_volume

from benchmarks.gear_pairs import gear_pair
from fem.contact.evaluation.contact_pattern import contact_pattern, damaged_part
from fem.contact.faults.chipped_tooth import ChippedTooth
from fem.contact.faults.cracked_tooth import CrackedTooth
from fem.contact.faults.missing_tooth import MissingTooth
from fem.contact.faults.pitted_tooth import PittedTooth
from fem.contact.faults.spalled_tooth import SpalledTooth
from fem.contact.faults.worn_tooth import WornTooth
from fem.contact.models.iso import Iso
from fem.contact.teeth import tooth_terms, with_variants
from pipelines.report.figures.damage import DRAWN, drawn_tooth
from pipelines.report.figures.gear_frame import placed, scene_frame
from pipelines.report.figures.tooth_surfaces import gear_surface, outline, twist, web

PAIR = gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5))
LAW = Iso(slices=15).law(PAIR, "drive")
WHEEL = PAIR.wheel


def drawn(*faults, gear="wheel"):
    return drawn_tooth(PAIR, LAW, gear, faults)


def volume(tooth):
    return enclosed_volume(tooth.points, tooth.quads)


def radius(points):
    return np.hypot(points[..., 0], points[..., 1])


def test_a_chip_takes_away_what_stands_above_its_edge():
    chip = drawn(ChippedTooth(depth=2e-3, extent=4e-3, end="+y"))
    gone = chip.points[:, 2] > 2e-3 + 1e-6
    left = WHEEL.tip_radius - 2e-3
    assert radius(chip.points[gone]).max() == pytest.approx(left, rel=1e-3)
    assert radius(chip.points[~gone]).max() == pytest.approx(WHEEL.tip_radius, rel=1e-6)
    # its volume: extent times the area of the section above the edge, about the mean thickness times the depth
    thickness = np.mean([2 * r * WHEEL.half_thickness_angle(r) for r in np.linspace(left, WHEEL.tip_radius, 50)])
    assert volume(drawn()) - volume(chip) == pytest.approx(4e-3 * 2e-3 * thickness, rel=0.03)
    assert chip.broken.any()
    assert chip.end == 1
    assert "piece broken off: 2 mm deep, 4 mm long" in chip.words


def test_a_broken_corner_falls_evenly_to_nothing():
    corner = drawn(ChippedTooth(depth=2e-3, extent=6e-3, end="-y", corner=True))
    tops = [radius(corner.points[np.isclose(corner.points[:, 2], z)]).max() for z in (-6e-3, -3e-3, 0.0)]
    fallen = (WHEEL.tip_radius - np.array(tops)) / 1e-3
    assert np.allclose(fallen, [2.0, 1.0, 0.0], atol=0.02)


def test_a_crack_runs_from_the_fillet_into_the_tooth_where_its_mouth_is():
    fault = CrackedTooth(depth=2e-3, angle=math.radians(70), extent=6e-3, end="-y")
    tooth = drawn(fault)
    (sheet,) = tooth.sheets
    along = np.linalg.norm(sheet[:, -1] - sheet[:, 0], axis=1)
    assert np.allclose(along, fault.depth)
    assert sheet[..., 2].min() == pytest.approx(-6e-3)
    assert sheet[..., 2].max() == pytest.approx(0.0, abs=1e-9)
    assert "crack 2 mm deep from the fillet, 6 mm long" in tooth.words
    assert (sheet[:, 0, 1] - sheet[:, -1, 1] > 0.5 * fault.depth).all()  # from the drive flank inwards
    assert len(tooth.lines) == 2  # along the fillet, and on the end face that it reaches
    coast = drawn(CrackedTooth(depth=2e-3, flank="coast"))
    assert (coast.sheets[0][:, 0, 1] < coast.sheets[0][:, -1, 1]).all()
    assert len(coast.lines) == 3
    assert "12 mm long" in coast.words  # over the whole face


def test_wear_has_its_depth_and_is_drawn_deeper_by_a_stated_factor():
    sound, worn = drawn(), drawn(WornTooth(depth=40e-6, place="pitch", width=4e-3))
    assert worn.depth.max() == pytest.approx(40e-6, rel=0.02)
    deepest = int(worn.depth.argmax())
    assert radius(worn.points[deepest]) == pytest.approx(PAIR.working_radii[1], rel=5e-3)
    moved = np.linalg.norm(worn.points - sound.points, axis=1)
    assert np.allclose(moved, worn.scale * worn.depth, atol=1e-9)
    assert worn.scale > 1
    assert f"enlarged {worn.scale:g} times" in worn.words


def test_faults_of_one_tooth_are_drawn_together_and_a_missing_tooth_is_said():
    both = drawn(ChippedTooth(depth=1e-3, extent=3e-3), CrackedTooth(depth=1e-3))
    assert both.broken.any()
    assert len(both.sheets) == 1
    assert "broken off" in both.words
    assert "crack" in both.words
    assert drawn(MissingTooth()).missing
    assert WornTooth not in DRAWN  # wear, and all that is not listed, by the gap it opens


@pytest.mark.parametrize("flank", ["drive", "coast"])
def test_a_spall_lies_on_its_flank_where_it_is_stated(flank):
    tooth = drawn(SpalledTooth(height=1e-3, length=4e-3, depth=50e-6, position=2e-3, flank=flank))
    inside = tooth.points[tooth.depth > 0.0]
    assert np.ptp(inside[:, 2]) == pytest.approx(4e-3, rel=0.1)
    assert inside[:, 2].mean() == pytest.approx(2e-3, abs=0.1e-3)
    side = np.arctan2(inside[:, 1], inside[:, 0]) - twist(WHEEL) * inside[:, 2]
    assert ((side > 0.0) == (flank == "drive")).all()
    assert radius(inside).mean() == pytest.approx(WHEEL.reference_radius, rel=5e-3)
    pitted = drawn(PittedTooth(height=2e-3, density=0.1, pit=0.4e-3, length=6e-3, flank=flank))
    assert pitted.depth.any()
    assert "pits" in pitted.words


@pytest.mark.parametrize("sense", [1, -1])
def test_gears_stand_on_their_shafts_and_y_runs_along_them(sense):
    frame = scene_frame((0.1, 0.2), (0.4, 0.6), 0.05, sense)
    assert np.linalg.det(frame[:3, :3]) == pytest.approx(1.0)  # no mirror: hands and flanks stay
    assert np.allclose(placed(np.zeros(3), frame), [0.1, 0.05, 0.2])
    assert np.allclose(placed(np.array([0.5, 0.0, 0.0]), frame), [0.4, 0.05, 0.6])
    assert np.allclose(placed(np.array([0.0, 0.0, 0.01]), frame), [0.1, 0.05 + 0.01 * sense, 0.2])


def test_an_offset_web_is_drawn_where_it_is():
    assert web(WHEEL) is None
    section = outline(WHEEL, 0.0)
    solid = enclosed_volume(*gear_surface(section, 17.5e-3, 0.0, 12e-3))
    points, quads = gear_surface(section, 17.5e-3, 0.0, 12e-3, web=(45e-3, -5e-3, -1e-3))
    ring = math.pi * (45e-3**2 - 17.5e-3**2)
    assert solid - enclosed_volume(points, quads) == pytest.approx(ring * 8e-3, rel=0.01)
    inner = points[np.isclose(np.hypot(*points[:, :2].T), 17.5e-3)]
    assert np.unique(inner[:, 2]).tolist() == [-5e-3, -1e-3]


def test_the_pattern_of_a_worn_tooth_is_clear_where_the_material_is_gone():
    fault = WornTooth(depth=60e-6, place="pitch", width=4e-3)
    law = with_variants(LAW, "wheel", 0.0, fault.gap(LAW, PAIR, "wheel"))
    terms = tooth_terms(20), tooth_terms(55, variant=np.where(np.arange(55) == 7, 1, 0))
    sound = contact_pattern("healthy", PAIR, LAW, "wheel", 7, 1000.0, (tooth_terms(20), tooth_terms(55)))
    worn = contact_pattern("worn", PAIR, law, "wheel", 7, 1000.0, terms)
    pitch = int(np.abs(sound.diameter - 2 * PAIR.working_radii[1]).argmin())
    assert np.isfinite(sound.pressure).all()
    assert np.isnan(worn.pressure[pitch]).all()
    assert damaged_part(PAIR, LAW, "wheel", [fault.gap(LAW, PAIR, "wheel")])[pitch].min() > 0.98
    assert sound.diameter[-1] == pytest.approx(2 * WHEEL.tip_radius, rel=1e-3)
    assert np.ptp(sound.face) == pytest.approx(PAIR.face_width)
