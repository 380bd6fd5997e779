"""27-node hexahedra of plain housings: the section with all outlines, extruded where there is body."""

import math
from dataclasses import replace

import numpy as np
import pytest
from factored_casing import factored
from housings import housing_for_shafts, short_housing, small_housing

from fem.casing.geometry.housing_features import Ribs
from fem.casing.mesh.choose_mesher import mesh_geometry
from fem.casing.mesh.extruded import inside
from fem.casing.mesh.housing_section import divided
from fem.casing.mesh.mesh import MeshError
from fem.casing.mesh.sizes import Sizes
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.lanczos import block_lanczos
from fem.casing.reduced.rigid_on_mounts import housing_mass
from fem.elements.facets import surface_weights
from fem.elements.materials import CAST_IRON
from fem.elements.solids import mass_properties
from pipelines.io.errors import SceneError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.machine_conversion import make_machine
from pipelines.scene.load_scene import load_scene
from pipelines.scene.presets import preset_settings

HOUSINGS = {
    "small": small_housing(),
    "rig": housing_for_shafts(),
    "shafts at two heights": housing_for_shafts(
        (0.0, 0.11, 0.2), shaft_z=(0.0, 0.03, -0.01), bore_diameters=(0.047,) * 3, boss_diameters=(0.065,) * 3
    ),
    "shafts above one another": housing_for_shafts(
        (0.0, 0.05), shaft_z=(-0.06, 0.06), bore_diameters=(0.047, 0.062), boss_diameters=(0.065, 0.080)
    ),
    "thick walls": small_housing(wall_thickness=0.013),
    "feet that end at thin walls": short_housing(length=0.1, left=-0.05, wall_thickness=0.006),
}


def hexahedra(housing, size=0.035, element="hexahedron-27"):
    return mesh_geometry(housing, Sizes(element=size), element)


def frequencies(mesh, count=4):
    casing = factored(assembled_casing(mesh, CAST_IRON))
    theta, _ = block_lanczos(casing.interface.factor.solve, casing.M_free, count=count)
    return 1.0 / (2.0 * math.pi * np.sqrt(theta)), casing.K_free.shape[0]


@pytest.mark.parametrize("name", HOUSINGS)
def test_mass_centre_inertia_and_faces_are_those_of_the_boxes_and_cylinders(name):
    """Quadratic arcs of 45 degrees miss the area of a circle by 1e-4."""
    housing = HOUSINGS[name]
    mesh = hexahedra(housing)
    meshed, exact = mass_properties(mesh.nodes, mesh.elements, 7200.0), housing_mass(housing, 7200.0)
    assert meshed[0] == pytest.approx(exact[0], rel=1e-5)
    assert meshed[1] == pytest.approx(exact[1], abs=1e-6)
    assert meshed[2] == pytest.approx(exact[2], rel=1e-4, abs=1e-4)
    for bore in housing.bores:
        area = surface_weights(mesh.nodes, mesh.patch(bore.name))[2].sum()
        assert area == pytest.approx(math.pi * bore.diameter * bore.boss_length, rel=3e-4)
    for foot in mesh.patches("ground_"):
        assert surface_weights(mesh.nodes, mesh.patch(foot))[2].sum() == pytest.approx(housing.feet.length**2, rel=1e-9)


def test_softer_and_so_closer_than_tetrahedra_with_more_unknowns():
    """Elements of displacement bound every frequency from above: the lower one is closer."""
    housing = short_housing()
    hexahedral, few = frequencies(hexahedra(housing, 0.06))
    tetrahedral, many = frequencies(mesh_geometry(housing, Sizes(element=0.03)))
    assert few < many
    assert (hexahedral < tetrahedral).all()


def test_lines_pass_through_all_places_and_keep_their_distance():
    lines = divided([0.1, 0.0, 0.11, 0.11 + 1e-12], 0.03)
    assert lines == pytest.approx([0.0, 0.025, 0.05, 0.075, 0.1, 0.11])


def test_a_point_in_a_bore_is_outside_and_one_in_its_boss_inside():
    rig = HOUSINGS["rig"]
    bore = next(one for one in rig.bores if one.name == "bearing_3")
    at = rig.bore_centre(bore)
    ring = (bore.diameter + bore.boss_diameter) / 4
    points = np.array([at, at + [ring, 0.0, 0.0], at + [0.0, -bore.side * 0.05, 0.0], rig.ground_points()["ground_1"]])
    points[3, 2] += 1e-6
    assert inside(rig, points).tolist() == [False, True, False, True]


@pytest.mark.parametrize(
    ("housing", "message"),
    [
        (replace(HOUSINGS["rig"], ribs=Ribs(thickness=0.008, height=0.01, cover=2)), "flange, ribs, fillets or bolt"),
        (
            housing_for_shafts(
                (0.0, 0.06), shaft_z=(-0.03, 0.03), bore_diameters=(0.047,) * 2, boss_diameters=(0.065,) * 2
            ),
            "two bosses overlap by 5 mm seen along x and along z",
        ),
        (replace(HOUSINGS["rig"], bores=HOUSINGS["rig"].bores[:-1]), "has no bore across from it"),
    ],
)
def test_other_housings_are_refused_with_the_way_out(housing, message):
    with pytest.raises(MeshError, match=f"{message}.*set element = 'tetrahedron-10'"):
        hexahedra(housing)


def test_a_scene_takes_hexahedra_and_says_what_it_refuses():
    elements = {"casing.element": "hexahedron-27", "casing.extrapolated": False}
    taken = make_machine(load_scene("rig-healthy", elements).scene)
    assert taken.casing.element == "hexahedron-27"
    for settings, message in (
        ({"casing.housing.inner_fillet_mm": 3.0}, "flange, ribs, fillets or bolt pads"),
        ({"casing.bore_element_size_mm": 10.0}, "whose elements have one size"),
        ({"casing.element_size_mm": 1.5}, "million nodes or more, more than 2.0 million"),
    ):
        with pytest.raises(SceneError, match=message):
            checked_machine(load_scene("rig-healthy", {**elements, **settings}).scene, "scene")
    with pytest.raises(SceneError, match="a STEP file is meshed with tetrahedra"):
        load_scene("rig-step", {"casing.element": "hexahedron-27"})


@pytest.mark.parametrize(
    ("change", "element"),
    [
        ({}, "hexahedron-32"),
        ({"casing.element": "hexahedron-27"}, "hexahedron-32"),
        ({"casing.extrapolated": True}, "hexahedron-32"),
        ({"stages.1.direction_deg": 90.0}, "hexahedron-32"),
        ({"stages.1.direction_deg": 40.0}, "tetrahedron-20"),  # bosses overlap seen along x and along z
        ({"casing.housing.inner_fillet_mm": 5.0}, "tetrahedron-20"),
        ({"casing.element": "tetrahedron-10"}, "tetrahedron-20"),
    ],
)
def test_presets_take_hexahedra_where_they_fit(change, element):
    found = preset_settings(load_scene("bench", change).scene, "standard")
    assert found["casing.element"] == element
    assert found["casing.extrapolated"]
    draft = preset_settings(load_scene("bench", change).scene, "draft")
    assert draft["casing.extrapolated"] == (element != "hexahedron-32")  # within 1 % as they are
