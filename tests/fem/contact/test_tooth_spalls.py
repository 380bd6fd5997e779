"""Spalls, pits and wear on part of the face: bridged over the rim, continuous in size, mirrored; refusals.

The slow test holds the law against contact solved on the dense compliance with the gaps of narrow slices.
"""

import math

import numpy as np
import pytest
from mesh_laws import potential_errors

from benchmarks.gear_pairs import gear_pair
from benchmarks.solid_contact import solve
from fem.contact.evaluation.evaluator import LawEvaluator
from fem.contact.evaluation.stiffness_curve import stiffness_curve
from fem.contact.faults.changed_law import damaged_law
from fem.contact.faults.pitted_tooth import PittedTooth
from fem.contact.faults.spalled_tooth import SpalledTooth, edge_compliance
from fem.contact.faults.worn_tooth import WornTooth
from fem.contact.models.plane import Plane
from fem.contact.models.solid import Solid
from fem.contact.teeth import tooth_terms
from fem.gears.gear_checks import GeometryError
from pipelines.io.errors import SceneError
from pipelines.machine.checks.design_warnings import design_warnings
from pipelines.machine.machine_conversion import make_drivetrain, make_machine
from pipelines.scene.load_scene import control_of, load_scene

HELICAL = gear_pair((20, 55), 2, 12, 12, bores_mm=(12.5, 17.5))
SPUR = gear_pair((20, 55), 2, 0, 12, bores_mm=(12.5, 17.5))
PAIRS = {"spur": SPUR, "helical": HELICAL}
LOAD = 1500.0
CYCLES = np.linspace(-1.5, 1.5, 13)


@pytest.fixture(scope="module")
def laws():
    return {name: Plane(refinement=0.5).laws(pair) for name, pair in PAIRS.items()}


def damaged_pinion(teeth=20):
    return tooth_terms(teeth, variant=np.arange(teeth) == 0)


def added(law, pair, fault, load=LOAD):
    """Mean deflection (m) that a fault of pinion tooth 0 adds at a load."""
    with_fault = LawEvaluator(damaged_law(law, pair, "pinion", [fault]))
    sound = with_fault.approach_at(load, CYCLES)
    return float((with_fault.approach_at(load, CYCLES, pinion=damaged_pinion()) - sound).mean())


def relative_radius(pair, xi):
    first, second = pair.roll_lengths(xi)
    return first * second / (first + second)


@pytest.mark.parametrize("gear", ["pinion", "wheel"])
def test_a_deep_spall_is_bridged_over_its_rim(laws, gear):
    """The mate sinks by a^2 / (2 rho) in the middle of a spall of half height a, whatever the depth."""
    law, half = laws["spur"][0], 0.4e-3
    middle = 2 * SPUR.working_radii[gear == "wheel"]
    spalls = [
        SpalledTooth(height=2 * half, length=6e-3, depth=depth, diameter=middle, shape="rectangle")
        for depth in (0.2e-3, 0.8e-3)
    ]
    gaps = [spall.gap(law, SPUR, gear)[7] for spall in spalls]
    assert gaps[0] == pytest.approx(gaps[1], rel=1e-12)
    assert gaps[0].max() == pytest.approx(half**2 / (2 * relative_radius(SPUR, 0.0)), rel=0.05)


def test_a_shallow_spall_is_as_deep_as_it_is(laws):
    law = laws["spur"][0]
    spall = SpalledTooth(height=1.5e-3, length=6e-3, depth=4e-6, shape="rectangle")
    gap = spall.gap(law, SPUR, "pinion")
    assert gap.max() == pytest.approx(4e-6, rel=1e-9)
    assert (spall.gap(laws["spur"][1], SPUR, "pinion") == 0.0).all()  # the other flank is whole


@pytest.mark.parametrize("inside", [-1.0, -0.5, 0.0, 1.0, 4.0])
def test_a_rim_is_as_soft_as_the_edge_of_an_elastic_half_plane(inside):
    """Contact of a parabola beside a sharp edge, solved with constant pressures on strips; E*, rho, b are 1."""
    ends = np.append(0.0, np.geomspace(1e-6, 2.2, 500))
    place, width, load, datum = (ends[1:] + ends[:-1]) / 2, np.diff(ends), np.pi / 4, 100.0
    apart = place[:, None] - ends
    whole = apart * (np.log(np.abs(apart) / datum) - 1)
    sinks = 2 / np.pi * np.diff(whole, axis=1)  # integral of -ln over each strip, from place - end
    on = np.full(place.size, True)
    while True:
        n = np.count_nonzero(on)
        matrix = np.block([[sinks[np.ix_(on, on)], -np.ones((n, 1))], [width[on][None], np.zeros((1, 1))]])
        *pressure, approach = np.linalg.solve(matrix, np.append(-((place[on] + inside) ** 2) / 2, load))
        if min(pressure) > 0:
            break
        on[np.flatnonzero(on)[np.array(pressure) <= 0]] = False
    hertz = load / np.pi * (2 * np.log(2 * datum) + 1)
    rim = approach - max(inside, 0.0) ** 2 / 2 - hertz
    assert rim == pytest.approx(load / np.pi * edge_compliance(np.array(inside), 0.5, 0.0), abs=0.005 * load)


def test_a_rim_softens_only_where_the_mate_rests_on_it(laws):
    """Nothing where the contact is more than b beside the spall, or in it where the rim is out of reach."""
    law, spall = laws["spur"][0], SpalledTooth(height=1.2e-3, length=6e-3, depth=30e-6, position=3e-3)
    added = spall.compliance(law, SPUR, "pinion")
    assert (added[law.face_coordinate < -0.5e-3] == 0.0).all()
    xi = law.position_start + law.position_step * np.arange(law.gap.size)
    assert (added[:, np.abs(xi) > 0.5] == 0.0).all()
    slender = SpalledTooth(height=2e-3, length=6e-3, depth=5e-6, position=3e-3, shape="rectangle")
    assert (slender.compliance(law, SPUR, "pinion")[:, np.abs(xi) < 0.1] == 0.0).all()
    assert (spall.compliance(laws["spur"][1], SPUR, "pinion") == 0.0).all()
    assert added.max() > law.contact_slope


def test_a_rim_that_the_mate_does_not_reach_bridges_nothing(laws):
    """At the root end of the active profile the lower rim is the nearer one, but only the upper one meets the mate."""
    law, half, above = laws["spur"][0], 0.4e-3, 0.15e-3
    roll, base = SPUR.roll_lengths(SPUR.xi_start)[0], SPUR.pinion.base_radius
    middle = math.sqrt(base**2 + roll**2 + 2 * base * above)
    spall = SpalledTooth(height=2 * half, length=12e-3, depth=0.9e-3, diameter=2 * middle, shape="rectangle")
    xi = law.position_start + law.position_step * np.arange(law.gap.size)
    gap = np.interp(SPUR.xi_start + 1e-3, xi, spall.gap(law, SPUR, "pinion")[5])
    radius = relative_radius(SPUR, SPUR.xi_start)
    assert 2.5 * (half - above) ** 2 < 2 * radius * gap < (half + above) ** 2  # rho grows fast from the root


@pytest.mark.parametrize(
    ("name", "key", "shape"),
    [("spur", "length", "ellipse"), ("helical", "length", "rectangle"), ("helical", "height", "ellipse")],
)
def test_spalls_grow_continuously_from_the_sound_tooth(laws, name, key, shape):
    """In steps of 0.05 m_n: rising from nothing, and no step leaves the even course by more than 4 % of the whole."""
    law, pair, step = laws[name][0], PAIRS[name], 0.05 * SPUR.pinion.normal_module
    whole = {"height": 1.6e-3, "length": 5e-3, "depth": 300e-6, "position": 3e-3, "shape": shape}
    sizes = np.arange(1e-6, whole[key], step if key == "length" else 0.4 * step)
    found = np.array([added(law, pair, SpalledTooth(**(whole | {key: float(size)}))) for size in sizes])
    assert found[0] < 1e-3 * found[-1]
    assert (np.diff(found) > -1e-4 * found[-1]).all()
    assert np.abs(np.diff(found, n=2)).max() < 0.04 * found[-1]


def test_a_mirrored_spall_mirrors_the_law(laws):
    law, pair = laws["spur"][0], SPUR
    here, there = (
        damaged_law(law, pair, "pinion", [SpalledTooth(height=2e-3, length=3e-3, depth=1e-4, position=side * 3.3e-3)])
        for side in (1, -1)
    )
    teeth = damaged_pinion()
    one = LawEvaluator(here).evaluate(CYCLES, 6e-6, 2e-4, teeth)
    other = LawEvaluator(there).evaluate(CYCLES, 6e-6, -2e-4, teeth)
    assert one.force == pytest.approx(other.force, rel=1e-12)
    assert one.moment == pytest.approx(-other.moment, rel=1e-9, abs=1e-9)


def test_a_spalled_law_has_one_potential(laws):
    law = damaged_law(laws["helical"][0], HELICAL, "pinion", [SpalledTooth(height=2e-3, length=5e-3, depth=2e-4)])
    draw = np.random.default_rng(4)
    states = draw.uniform(-1.2, 1.2, 60), draw.uniform(6e-6, 30e-6, 60), draw.uniform(-2e-4, 2e-4, 60)
    assert np.median(potential_errors(law, states, damaged_pinion()), axis=1).max() < 1e-6


def test_pits_cover_the_stated_area_without_overlap_and_soften(laws):
    fault = PittedTooth(height=2e-3, density=0.15, pit=0.4e-3, seed=3)
    pits = fault.patches(SPUR.pinion)
    areas = [math.pi / 4 * pit.height**2 for pit in pits]
    assert sum(areas) == pytest.approx(0.15 * 2e-3 * 12e-3, rel=1e-6)
    assert fault.patches(SPUR.pinion) == pits
    assert PittedTooth(height=2e-3, density=0.15, pit=0.4e-3, seed=4).patches(SPUR.pinion) != pits
    sizes = np.array([pit.height for pit in pits[:-1]])
    assert np.median(sizes) == pytest.approx(0.4e-3, rel=0.15)
    assert np.exp(np.log(sizes).std()) == pytest.approx(1.4, rel=0.15)
    softer = [added(laws["spur"][0], SPUR, PittedTooth(height=2e-3, density=d, pit=0.4e-3)) for d in (0.05, 0.15, 0.3)]
    assert 0.0 < softer[0] < softer[1] < softer[2]


def test_worn_profiles_are_what_the_table_says(laws):
    law, pair = laws["spur"][0], SPUR
    radii = pair.working_radii[0]
    profile = {"place": "profile", "diameters": (2 * radii - 2e-3, 2 * radii, 2 * radii + 2e-3)}
    table = WornTooth(depth=10e-6, parts=(0.0, 1.0, 0.2), **profile)
    xi = law.position_start + law.position_step * np.arange(law.gap.size)
    assert np.interp(0.0, xi, table.gap(law, pair, "pinion")) == pytest.approx(10e-6, rel=0.01)
    part = WornTooth(depth=10e-6, parts=(0.0, 1.0, 0.2), extent=5e-3, end="-y", **profile).gap(law, pair, "pinion")
    assert part[0] == pytest.approx(table.gap(law, pair, "pinion"), abs=1e-15)
    assert (part[law.face_coordinate > -0.5e-3] == 0.0).all()
    fading = WornTooth(depth=10e-6, extent=12e-3, fading=True).gap(law, pair, "pinion")
    middle = law.gap.size // 2
    assert fading[:, middle] == pytest.approx(10e-6 * (law.face_coordinate / 12e-3 + 0.5), rel=1e-6)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (SpalledTooth(height=1e-3, length=3e-3, depth=2e-3), "0.5 modules"),
        (SpalledTooth(height=9e-3, length=3e-3, depth=1e-4), "the height of the flank"),
        (SpalledTooth(height=1e-3, length=13e-3, depth=1e-4), "the face width"),
        (SpalledTooth(height=1e-3, length=3e-3, depth=1e-4, position=7e-3), "Set position_mm between"),
        (SpalledTooth(height=1e-3, length=3e-3, depth=1e-4, diameter=60e-3), "is not on the flank"),
        (PittedTooth(height=1e-3, density=0.2, pit=0.8e-3), "half the pitted area"),
        (PittedTooth(height=1e-3, density=0.3, pit=5e-6), "pits, more than"),
        (WornTooth(depth=1e-5, place="profile", diameters=(0.04, 0.039), parts=(0.0, 1.0)), "must increase"),
        (WornTooth(depth=1e-5, place="profile", diameters=(0.04,), parts=(0.0,)), "two or more"),
        (WornTooth(depth=1e-5, extent=13e-3), "extent"),
        (WornTooth(depth=1e-5, fading=True), "needs extent_mm"),
    ],
)
def test_impossible_flank_damage_is_refused(fault, message):
    with pytest.raises(GeometryError, match=message):
        fault.check(SPUR.pinion)


def test_values_outside_the_range_of_an_option_are_refused():
    with pytest.raises(GeometryError, match="flank = 'left': must be one of 'drive', 'coast'"):
        SpalledTooth(height=1e-3, length=3e-3, depth=1e-4, flank="left")
    with pytest.raises(GeometryError, match=r"density = 0.6: must be above 0 and at most 0.3"):
        PittedTooth(height=1e-3, density=0.6, pit=1e-4)


SCENE_SPALL = {
    "kind": "spalled-tooth",
    "gear": "wheel",
    "tooth": 3,
    "height_mm": 1.0,
    "length_mm": 4.0,
    "depth_um": 150,
    "position_mm": 2.0,
}


def test_a_spall_of_a_scene_lies_at_its_place_in_both_senses_and_leaves_the_control():
    """The face coordinate of a law follows the rotation of its pinion: +y on stage 1 of the rig, -y on stage 2."""
    scene = load_scene("rig-missing-tooth", {"faults": [SCENE_SPALL | {"stage": stage} for stage in (1, 2)]})
    machine = make_machine(scene.scene)
    places = [flanks.wheel_damage[0][0].position for flanks in machine.flanks[:2]]
    assert places == [2e-3, -2e-3]
    assert machine.flanks[0].wheel_damage[0][0].depth == pytest.approx(150e-6)
    assert [fault.name for fault in machine.faults] == ["spalled-tooth 3", "spalled-tooth 3"]
    control = control_of(load_scene("bench-spall"))
    assert control is not None
    assert not control.scene.faults
    assert control.scene.stages[0].wheel.deviations.waves


@pytest.mark.parametrize(
    ("length", "slices"),
    [(1.5, "80"), (1.55, "78"), (1.0, "101, the most that a mesh has")],
    ids=["whole", "rounded up", "beyond the most"],
)
def test_a_spall_narrower_than_two_slices_needs_ten_over_its_length(length, slices):
    scene = load_scene("minimal", {"faults": [SCENE_SPALL | {"stage": 1, "length_mm": length}]}).scene
    found = [text for text in design_warnings(scene, make_drivetrain(scene)) if "is resolved coarsely" in text]
    assert scene.stages[0].face_width_mm == 12
    assert len(found) == 1
    assert found[0].endswith(f"Raise stages.1.mesh.slices to {slices}")


def test_wear_on_a_part_of_the_face_is_that_of_one_tooth():
    wear = {"kind": "worn-tooth", "stage": 1, "gear": "wheel", "depth_um": 5, "extent_mm": 3}
    with pytest.raises(SceneError, match="only a single tooth can be worn on a part of the face"):
        load_scene("minimal", {"faults": [wear]})


@pytest.mark.slow
@pytest.mark.parametrize("name", PAIRS)
def test_a_spall_at_the_end_of_the_face_as_contact_solved_in_space_finds_it(name):
    """Reference: contact on the dense compliance of 45 slices, gaps by the parabola of the nearer rim."""
    pair, positions = PAIRS[name], 16
    spall = SpalledTooth(
        height=2e-3,
        length=4e-3,
        depth=300e-6,
        position=-4.3e-3,
        shape="rectangle",
        diameter=2 * pair.working_radii[0],
    )
    record = Solid(slices=45, refinement=0.7, positions=positions).compliance(pair)
    base = pair.pinion.base_radius
    middle = pair.roll_lengths(0.0)[0] ** 2 / (2 * base)

    def rim_gap(xi):
        """The nearer rim, in the transverse section."""
        place = min(max(xi, pair.xi_start), pair.xi_end)
        to_rim = spall.height / 2 - abs(pair.roll_lengths(place)[0] ** 2 / (2 * base) - middle)
        return min(spall.depth, max(to_rim, 0.0) ** 2 / (2 * relative_radius(pair, place)))

    y = record.hand * record.face
    covered = np.abs(y - spall.position) < spall.length / 2
    cycles = np.arange(-positions, positions + 1)
    law = Solid(slices=15, refinement=0.7).law(pair, "drive")
    law = damaged_law(law, pair, "pinion", [spall])
    for load in (600.0, 2400.0):
        approach = [
            solve(
                record,
                np.array([i]),
                force=load,
                clearance={0: covered * np.array([rim_gap(i / positions + shift) for shift in record.cycle_shift])},
            ).approach[0]
            for i in cycles
        ]
        found = stiffness_curve(law, load, cycles / positions, clearance_pinion=damaged_pinion()).transmission_error
        assert (load / found).mean() == pytest.approx(np.mean(load / np.array(approach)), rel=0.01)
