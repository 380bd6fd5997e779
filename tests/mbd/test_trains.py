"""Trains of any shape: branches, closed loops, couplings, motors on two shafts, cross terms; scenes."""

import dataclasses
import math

import numpy as np
import pytest
from mbd_rigs import no_casing, rigid_casing, train

from mbd.integrators.settings import MotionSettings
from mbd.output.simulate import simulate
from mbd.parts.bearings import BEARING_AXES, BearingSpec, rigid_bearing
from mbd.parts.couplings import ShaftCoupling
from mbd.parts.gear_mesh import mesh_rows
from mbd.parts.mesh_reference import nominal_forces
from mbd.parts.part_checks import MachineError
from mbd.parts.train import Link, power_flow, shaft_ratios
from mbd.system.linearised import linear_modes
from mbd.system.statics import equilibrium
from mbd.system.system import assemble, natural_frequencies
from pipelines.io.errors import SceneError
from pipelines.machine.checks.checked_machine import checked_machine
from pipelines.machine.layout import lay_out
from pipelines.scene.load_scene import load_scene


def needed(machine):
    load = machine.load
    return load.torque * len(load.drums) * machine.ratios()[load.shaft]


def test_ratios_are_found_along_links_in_both_directions():
    links = [Link("a", "s1", "s2", 0.5), Link("b", "s3", "s2", 0.25), Link("c", "s3", "s4", 1.0)]
    assert shaft_ratios(links, "s1") == {"s1": 1.0, "s2": 0.5, "s3": 2.0, "s4": 2.0}


def test_a_loop_closes_if_the_ratios_agree():
    links = [Link("a", "s1", "s2", 0.5), Link("b", "s2", "s3", 0.5), Link("c", "s1", "s3", 0.25)]
    assert shaft_ratios(links, "s1")["s3"] == 0.25


def test_power_flows_to_the_load_and_splits_alike_over_equal_paths():
    assert power_flow([(0, 1), (0, 2)], [0], np.array([0.0, 1.0, 0.0])).tolist() == [
        1.0,
        0.0,
        1.0,
    ]  # a branch that carries nothing
    split = power_flow([(0, 1), (0, 2), (1, 3), (2, 3)], [0], np.array([0.0, 0.0, 0.0, 1.0]))
    np.testing.assert_allclose(split, [0.5, 0.5, 0.5, 0.5, 1.0], atol=1e-12)
    np.testing.assert_allclose(power_flow([(0, 2), (1, 2)], [0, 1], np.array([0.0, 0.0, 1.0])), 0.5, atol=1e-12)


def mirrored():
    """Shaft 1 drives shaft 2 at +x and, by a twin pair, shaft 3 at -x; the load hangs on shaft 2."""
    machine = train(1)
    driven, mesh = machine.shafts[1], machine.meshes[0]
    twin = dataclasses.replace(driven, name="shaft_3", x=-driven.x)
    second = dataclasses.replace(mesh, name="stage_2", driven="shaft_3")
    bearings = [
        dataclasses.replace(b, name=f"extra_{b.name}", shaft="shaft_3")
        for b in machine.bearings
        if b.shaft == "shaft_2"
    ]
    return dataclasses.replace(
        machine,
        shafts=(*machine.shafts, twin),
        meshes=(mesh, second),
        bearings=(*machine.bearings, *bearings),
    )


def test_a_branch_without_load_leaves_the_torque_of_the_other_alone():
    machine = mirrored()
    system = assemble(machine, no_casing())
    state = equilibrium(system)
    assert state.motor_torque == pytest.approx(needed(machine), rel=1e-9)
    assert nominal_forces(machine)["stage_2"] == 0.0
    assert state.mesh_force[1] < 1e-6 * state.mesh_force[0]
    run = simulate(system, MotionSettings(end=0.02, output_rate=5e3, step=1e-5))
    assert np.isfinite(run.values).all()
    assert abs(run.energy("total", "residual")) < 2e-6 * run.energy("total", "scale")


def test_two_motors_on_two_shafts_share_one_wheel():
    """Two pinions, each with its motor, on one wheel: by symmetry both carry half of the load."""
    machine = train(1, model="torsion", gravity=0.0)
    pinion, mesh = machine.shafts[0], machine.meshes[0]
    twin = dataclasses.replace(pinion, name="shaft_3", x=2 * machine.shafts[1].x)
    bearings = [
        dataclasses.replace(b, name=f"extra_{b.name}", shaft="shaft_3")
        for b in machine.bearings
        if b.shaft == "shaft_1"
    ]
    motors = [dataclasses.replace(c, name=f"twin_{c.name}", shaft="shaft_3") for c in machine.couplings]
    machine = dataclasses.replace(
        machine,
        shafts=(*machine.shafts, twin),
        meshes=(mesh, dataclasses.replace(mesh, name="stage_2", driving="shaft_3")),
        bearings=(*machine.bearings, *bearings),
        couplings=(*machine.couplings, *motors),
    )
    state = equilibrium(assemble(machine, no_casing()))
    assert state.motor_torque == pytest.approx(needed(machine), rel=1e-9)
    np.testing.assert_allclose(state.mesh_force, state.mesh_force.mean(), rtol=1e-6)


def test_a_coupling_between_shafts_winds_up_by_its_torque():
    machine = train(1)
    drum_shaft = machine.shafts[1]
    end = dataclasses.replace(drum_shaft, name="shaft_3", disks=())
    bearings = [
        dataclasses.replace(b, name=f"extra_{b.name}", shaft="shaft_3")
        for b in machine.bearings
        if b.shaft == "shaft_2"
    ]
    stiffness = 5e3
    joint = ShaftCoupling(
        name="coupling_1",
        shafts=("shaft_2", "shaft_3"),
        y=(0.2, -0.2),
        torsional_stiffness=stiffness,
        damping_time=1e-5,
    )
    machine = dataclasses.replace(
        machine, shafts=(*machine.shafts, end), bearings=(*machine.bearings, *bearings), shaft_couplings=(joint,),
        load=dataclasses.replace(machine.load, shaft="shaft_3"),
    )  # fmt: skip
    system = assemble(machine, no_casing())
    state = equilibrium(system)
    lay = system.layout
    twist = (lay.angle_row("shaft_2", 0.2) - lay.angle_row("shaft_3", -0.2)) @ state.displacement
    assert state.motor_torque == pytest.approx(needed(machine), rel=1e-9)
    assert stiffness * twist == pytest.approx(2 * machine.load.torque, rel=1e-7)
    modes = linear_modes(system, up_to=2e3)
    assert modes.share("coupling_1").max() > 0.2


def nested(**stiffness):
    """A second pinion shaft on the axis of the first, with one bearing of its own and one on the first shaft."""
    machine = train(1)
    mesh, pinion = machine.meshes[0], machine.shafts[0]
    twin = dataclasses.replace(pinion, name="shaft_3")
    second = dataclasses.replace(mesh, name="stage_2", driving="shaft_3", y=mesh.y + 0.05)
    own = dataclasses.replace(machine.bearings[0], name="extra", shaft="shaft_3")
    joint = ShaftCoupling(
        name="coupling_1", shafts=("shaft_1", "shaft_3"), y=(0.2, 0.2), torsional_stiffness=0.0, **stiffness
    )
    return dataclasses.replace(
        machine, shafts=(*machine.shafts, twin), meshes=(mesh, second), bearings=(*machine.bearings, own),
        shaft_couplings=(joint,),
    )  # fmt: skip


def test_a_bearing_between_two_shafts_carries_what_the_other_bearing_leaves():
    """The shaft that turns idly hangs by its weight in both; the rotation of each is its own."""
    stiffness = 5e7
    machine = nested(radial_stiffness=stiffness)
    system = assemble(machine, no_casing())
    assert machine.shaft_couplings[0].links == ()
    state = equilibrium(system)
    lay, q = system.layout, state.displacement
    lift = lay.axis_row("shaft_1", 0.2, 2) - lay.axis_row("shaft_3", 0.2, 2)
    turn = lay.axis_row("shaft_3", -0.1, 2)
    bearing = next(b for b in machine.bearings if b.name == "extra")
    shaft = next(part for part in system.parts if part.name == "shaft_3")
    up = [place for place, i in enumerate(shaft.index) if lay.names[i].endswith(":uz")]
    weight = shaft.mass[np.ix_(up, up)].sum() * machine.gravity
    mesh = mesh_rows(machine.meshes[1], machine.shaft("shaft_3"), machine.shaft("shaft_2"))[0, 2]
    held = stiffness * lift @ q - bearing.stiffness[2] * turn @ q - state.mesh_force[1] * mesh
    assert stiffness * lift @ q > 0.1 * weight
    assert held == pytest.approx(weight, rel=1e-6)


def test_a_bearing_between_shafts_holds_something():
    with pytest.raises(MachineError, match="all stiffnesses of the coupling are 0"):
        nested()


def test_cross_terms_turn_the_axes_of_a_bearing():
    """A bearing that is stiff along 30 degrees, K = R diag(k) R^T: its energy is balanced."""
    angle, k = math.radians(30), (4e7, 1e7)
    c, s = math.cos(angle), math.sin(angle)
    xx, zz, xz = k[0] * c * c + k[1] * s * s, k[0] * s * s + k[1] * c * c, (k[0] - k[1]) * c * s
    bearing = BearingSpec(name="b", shaft="shaft_1", y=0.0, stiffness=(xx, 2e7, zz, 0.0, 0.0),
                          cross=(("ux", "uz", xz),), damping_time=0.0, support="ground")  # fmt: skip
    base = train(1)
    both = [
        dataclasses.replace(bearing, name=b.name, shaft=b.shaft, y=b.y, support="casing", damping_time=1e-5)
        for b in base.bearings
    ]
    run = dataclasses.replace(base, bearings=tuple(both))
    found = simulate(assemble(run, rigid_casing(run)), MotionSettings(end=0.02, output_rate=5e3, step=1e-5))
    for b in both:
        assert abs(found.energy(b.name, "residual")) <= 0.01 * found.energy(b.name, "scale")
    with pytest.raises(MachineError, match="not positive definite"):
        dataclasses.replace(bearing, cross=(("ux", "uz", 1e9),))
    skew = np.zeros((5, 5))
    skew[0, 2] = 1e3
    with pytest.raises(MachineError, match="not symmetric"):
        dataclasses.replace(bearing, damping=tuple(map(tuple, skew)))


def test_damping_of_its_own_axes_is_booked():
    matrix = np.diag([2e3, 1e3, 3e3, 0.0, 0.0])
    matrix[0, 2] = matrix[2, 0] = 1e3
    base = train(1)
    bearings = tuple(dataclasses.replace(b, damping=tuple(map(tuple, matrix))) for b in base.bearings)
    run = simulate(
        assemble(dataclasses.replace(base, bearings=bearings), no_casing()),
        MotionSettings(end=0.03, output_rate=5e3, step=1e-5),
    )
    for b in bearings:
        assert run.energy(b.name, "dissipated") > 0.0
        assert abs(run.energy(b.name, "residual")) <= 0.01 * run.energy(b.name, "scale")


def test_rigid_bearings_are_the_limit_of_stiff_ones():
    base = train(1, torque=300.0)

    def lowest(make):
        machine = dataclasses.replace(base, bearings=tuple(make(b) for b in base.bearings))
        return natural_frequencies(assemble(machine, no_casing()))[:6]

    def stiff(k):
        return lambda b: dataclasses.replace(b, stiffness=(k, k, k, 0.0, 0.0))

    rigid = lowest(lambda b: rigid_bearing(b.name, b.shaft, b.y))
    errors = [abs(lowest(stiff(k)) / rigid - 1).max() for k in (1e10, 1e11)]
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.3)  # 1/k: at 1e12 another tenth
    assert BEARING_AXES[:3] == ("ux", "uy", "uz")


JOINT = {
    "shafts": [1, 2], "positions_mm": [0.0, 0.0], "torsional_stiffness_N_m_per_rad": 0.0,
    "radial_stiffness_N_per_um": 10.0,
}  # fmt: skip
SPLIT = {
    "stages.2.pinion_shaft": 1, "stages.2.wheel_shaft": 3, "stages.2.pinion_teeth": 20, "stages.2.wheel_teeth": 55,
    "stages.2.module_mm": 2.0, "stages.2.face_width_mm": 12.0, "stages.2.pinion_bore_mm": 25.0,
    "stages.2.wheel_bore_mm": 35.0, "stages.2.position_mm": 60.0, "stages.2.direction_deg": 180.0,
    "stages.3.pinion_shaft": 2, "stages.3.wheel_shaft": 4,
}  # fmt: skip


def test_a_scene_with_a_branch_on_the_input_shaft():
    scene = load_scene("rig-healthy", SPLIT | {"casing.model": "none", "sensors": []}).scene
    layout = lay_out(scene)
    assert layout.pair_shafts == ((0, 1), (0, 2), (1, 3))
    assert layout.senses == (1, -1, -1, 1)
    assert layout.axes[2][0] == pytest.approx(-layout.axes[1][0])
    assert layout.shaft_ratios[2] == pytest.approx(20 / 55)
    assert layout.ratio == pytest.approx(55 / 20 * 65 / 22)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stages.2.pinion_shaft": 2, "stages.2.wheel_shaft": 1}, "closes a loop that locks"),
        ({"stages.3.wheel_shaft": 2, "stages.3.pinion_shaft": 3}, "connects shaft 4"),
        ({"stages.1.wheel_shaft": 9}, "there is no shaft 9"),
        ({"stages.1.wheel_shaft": 1}, "both ends are on shaft 1"),
        ({"shafts.1.bearing_positions_mm": [-135.0, 0.0, 135.0]}, "bearing_supports"),
        ({"load.shaft": 7}, "there is no shaft 7"),
        ({"couplings": [JOINT]}, r"couplings\.1\.shafts: the distance between the axes of shafts 1 and 2 is .* mm"),
        ({"couplings": [JOINT | {"radial_stiffness_N_per_um": 0.0}]}, "all stiffnesses of the coupling are 0"),
    ],
)
def test_contradictory_trains_are_refused(changes, message):
    with pytest.raises(SceneError, match=message):
        checked_machine(load_scene("rig-healthy", changes).scene, "scene")
