"""The casing's own weight: what the feet carry, and how far the seats sink."""

import re

import numpy as np
import pytest
import skfem
from factored_casing import factored
from housings import angle_casing, small_housing

from fem.casing.mesh.finished_mesh import RawMesh, finished_mesh
from fem.casing.reduced.casing_modes import casing_modes, reduced_body
from fem.casing.reduced.grounded import assembled_casing
from fem.casing.reduced.reduction import reduce_body
from fem.casing.reduced.rigid_on_mounts import housing_mass, rigid_body
from fem.elements.materials import CAST_IRON, Material
from mbd.system.statics import equilibrium, foot_forces
from pipelines.cli.main import main
from pipelines.engine.run_graph import Work
from pipelines.runs.single_results import scene_graph
from pipelines.scene.load_scene import load_scene

GRAVITY = 9.80665
BLOCK = Material(name="soft", elastic_modulus=2e9, poisson_ratio=0.0, density=3000.0)
SIDES = np.array([0.2, 0.1, 0.3])


def shaft_mass(shaft):
    """Sections and disks, by hand."""
    hollow = sum((s.outer_diameter**2 - s.inner_diameter**2) * (s.y_end - s.y_start) for s in shaft.sections)
    return shaft.density * np.pi / 4 * hollow + sum(disk.mass for disk in shaft.disks)


def rest(body):
    """Displacements of a casing that carries nothing but itself."""
    return np.linalg.solve(body.stiffness, body.own_weight(GRAVITY))


def block_mesh():
    """A block on the quarters of its underside, `ground_1` to `ground_4`, with its top as a bearing."""
    mesh = skfem.MeshHex.init_tensor(*(side * np.array([0.0, 0.5, 1.0]) for side in SIDES))
    feet = {f"ground_{2 * i + j + 1}": SIDES * [(2 * i + 1) / 4, (2 * j + 1) / 4, 0.0] for i, j in np.ndindex(2, 2)}

    def patches(surface):
        middle = surface.corners.mean(axis=1)
        height, quarter = surface.corners[..., 2], 2 * (middle[:, 0] > SIDES[0] / 2) + (middle[:, 1] > SIDES[1] / 2)
        found = {n: np.flatnonzero((height == 0).all(axis=1) & (quarter == k)) for k, n in enumerate(feet)}
        found["bearing_1"] = np.flatnonzero((height == SIDES[2]).all(axis=1))
        return found, feet | {"bearing_1": SIDES * [0.5, 0.5, 1.0]}

    turned = [0.0, 0.0, SIDES[2]] + mesh.p.T * [1, 1, -1]  # the library makes them left-handed
    return finished_mesh(
        RawMesh(nodes=turned, elements=mesh.t.T), patches, name="block", element="hexahedron-27",
        element_size=0.1, remedy="",
    )  # fmt: skip


def block(ground, count=0, **options):
    casing = factored(assembled_casing(block_mesh(), BLOCK, ground=ground))
    reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, count=count, enrich=bool(count))
    return reduced_body(casing_modes(casing, reduction, model="static", band_limit=0.0), **options)


def test_a_block_on_the_ground_sinks_by_half_its_weight_over_its_stiffness():
    """Its top by rho g h^2/(2 E); all of its weight is at the feet, also that of clamped nodes, whatever the modes."""
    for count in (0, 3):
        body = block("fixed", count)
        q = rest(body)
        assert body.row("bearing_1:uz") @ q == pytest.approx(-3000.0 * GRAVITY * 0.3**2 / (2 * 2e9), rel=1e-9)
        each = 3000.0 * GRAVITY * SIDES.prod() / 4
        np.testing.assert_allclose(body.foot_forces(q, GRAVITY), [[0.0, 0.0, each]] * 4, rtol=1e-9, atol=1e-9 * each)


def test_a_block_on_springs_sinks_by_its_weight_over_the_springs_besides():
    """Its underside by W/(4 k), its top by half its weight over its own stiffness more; halved, that counts twice."""
    for factor in (1.0, 0.5):
        body = block("springs", mounts=((1e7, 1e7, 4e6),), stiffness_factor=factor)
        q, weight = rest(body), 3000.0 * GRAVITY * SIDES.prod()
        for foot in body.feet:
            assert body.row(f"{foot}:uz") @ q == pytest.approx(-weight / 16e6, rel=1e-9)
        shrunk = (body.row("bearing_1:uz") - body.row("ground_1:uz")) @ q
        assert shrunk == pytest.approx(-3000.0 * GRAVITY * 0.3**2 / (2 * factor * 2e9), rel=1e-6)
        np.testing.assert_allclose(body.foot_forces(q, GRAVITY)[:, 2], weight / 4, rtol=1e-9)


def test_rigid_feet_share_the_weight_by_the_law_of_the_lever():
    """Six equal springs in rows x_i carry W/6 + W e x_i/sum x_i^2, e how far the centre is off their middle."""
    housing = small_housing()
    body = rigid_body(housing, density=7200.0, mount_stiffness=1e8)
    mass, centre, _ = housing_mass(housing, 7200.0)
    feet = np.array(list(housing.ground_points().values())) - np.mean(list(housing.ground_points().values()), axis=0)
    off = centre - np.mean(list(housing.ground_points().values()), axis=0)
    share = 1 / 6 + feet[:, :2] @ (off[:2] / (feet[:, :2] ** 2).sum(axis=0))
    np.testing.assert_allclose(body.foot_forces(rest(body), GRAVITY)[:, 2], mass * GRAVITY * share, rtol=1e-9)


@pytest.mark.parametrize("ground", ["fixed", "springs"])
@pytest.mark.parametrize("attachment", ["mean", "rigid"])
def test_the_feet_of_a_casing_carry_its_weight_and_what_stands_in_its_seats(ground, attachment):
    """Forces along x, y, z at the bearings come out of the feet; few modes, or stiffer elements, change nothing."""
    casing = factored(assembled_casing(angle_casing("tetrahedron-10"), CAST_IRON, ground=ground, attachment=attachment))
    reduction = reduce_body(casing.interface, casing.K_free, casing.M_free, count=2)
    modes = casing_modes(casing, reduction, model="craig-bampton", band_limit=0.0)
    push = {"bearing_1:ux": 300.0, "bearing_2:uy": -500.0, "bearing_2:uz": -700.0, "bearing_1:rx": 20.0}
    for factor in (1.0, 0.9):
        body = reduced_body(
            modes, mounts=((2e7, 3e7, 5e7),) if ground == "springs" else None, stiffness_factor=factor, limit=0.0
        )
        force = body.own_weight(GRAVITY) + sum(value * body.row(name) for name, value in push.items())
        total = body.foot_forces(np.linalg.solve(body.stiffness, force), GRAVITY).sum(axis=0)
        np.testing.assert_allclose(total, [-300.0, 500.0, 700.0 + modes.total_mass * GRAVITY], rtol=1e-8)


def test_the_feet_of_a_machine_carry_everything_in_it():
    """Shafts, gear bodies, drums and casing of a scene; its torques come and go beside the weight."""
    from pipelines.machine.system_assembly import assemble_machine, assemble_system

    elastic = {"casing.model": "static", "casing.element_size_mm": 60.0}
    work = Work(processes=1, quiet=True)
    for settings in ({}, elastic, elastic | {"casing.ground": "springs"}):
        loaded = load_scene("minimal", settings)
        graph, model = scene_graph(loaded)
        outcome = work.build(
            graph, [*model.law_names, *(step.name for step in graph if step.name.startswith("casing"))]
        )
        machine = assemble_machine(model.parts, [outcome.value(name) for name in model.law_names])
        body = outcome.value("casing")
        system = assemble_system(machine, body, model.recorded)
        turning = sum(shaft_mass(shaft) for shaft in machine.shafts)
        modes = outcome.value("casing modes")[0] if settings else None
        standing = body.mass[0, 0] if modes is None else modes.total_mass
        forces = foot_forces(system, equilibrium(system))
        total = forces.sum(axis=0)
        np.testing.assert_allclose(total, [0.0, 0.0, GRAVITY * (turning + standing)], rtol=1e-8, atol=1e-5)


def test_the_command_tells_what_each_foot_carries_and_how_far_the_seats_sink(capsys):
    assert main(["casing", "minimal", "--quiet"]) == 0
    line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("own weight"))
    weight, *feet = [float(found) for found in re.findall(r"(?:weight|ground_\d) ([\d.]+)", line)]
    assert weight == pytest.approx(15.44 * GRAVITY, rel=1e-3)
    assert sum(feet) == pytest.approx(weight, rel=1e-3)
    sunk = re.search(r"seats sink by ([\d.]+) to ([\d.]+) um", line)
    assert float(sunk[1]) == pytest.approx(weight / 1.2e9 * 1e6, rel=0.02)  # six mounts of 200 N/um
