"""Equilibrium at the start: torque balance, zero load, refusals."""

import dataclasses

import numpy as np
import pytest
from mbd_rigs import no_casing, rigid_casing, train

from mbd.parts.checks import EquilibriumError
from mbd.parts.load import StaticTorque
from mbd.system.statics import equilibrium
from mbd.system.system import assemble


def needed_torque(machine):
    load, ratio = machine.load, machine.ratios()[machine.load.shaft]
    if isinstance(load, StaticTorque):
        return load.torque * len(load.drums) * ratio
    return load.torque_on_shaft(machine.gravity) * ratio


@pytest.mark.parametrize("load", ["torque", "rope"])
@pytest.mark.parametrize("model", ["timoshenko", "torsion"])
@pytest.mark.parametrize("stages", [1, 3])
def test_motor_torque_is_weight_times_drum_radius_over_the_ratios(load, model, stages):
    machine = train(stages, load=load, model=model)
    system = assemble(machine, rigid_casing(machine))
    state = equilibrium(system)
    assert state.motor_torque == pytest.approx(needed_torque(machine), rel=1e-9)
    first = machine.meshes[0]
    assert state.mesh_force[0] == pytest.approx(needed_torque(machine) / first.base_radius_driving, rel=1e-9)


def test_the_band_of_kept_modes_does_not_move_the_equilibrium():
    machine = train(1)
    narrow, wide = (equilibrium(assemble(machine, no_casing(), band=band)) for band in (2e3, np.inf))
    scale = abs(wide.displacement).max()
    np.testing.assert_allclose(narrow.displacement, wide.displacement, atol=1e-8 * scale)


def test_the_bearings_carry_the_weight():
    machine = train(1)
    system = assemble(machine, rigid_casing(machine))
    q = equilibrium(system).displacement
    rows = system.channels
    vertical = [i for i, n in enumerate(rows.names) if n.endswith(":fz")]
    weight = sum(
        part.mass[np.ix_(up, up)].sum()
        for part in system.parts
        if part.words.kind == "shaft"
        for up in [[j for j, i in enumerate(part.index) if system.layout.names[i].endswith(":uz")]]
    )
    assert (rows.displacement[vertical] @ q).sum() == pytest.approx(-weight * machine.gravity, rel=1e-6)


def test_without_load_the_drive_flank_just_touches():
    machine = train(2, torque=0.0)
    system = assemble(machine, no_casing())
    state = equilibrium(system)
    assert state.motor_torque == pytest.approx(0.0, abs=1e-6)
    u = system.rows @ state.displacement
    reach = [abs(m.drive.face_coordinate).max() for m in machine.meshes]
    for i in range(2):  # the slice that is nearest to contact has approach 0
        assert u[4 * i] + abs(u[4 * i + 1]) * reach[i] == pytest.approx(0.0, abs=2e-10)
    assert (state.mesh_force == 0.0).all()


def test_a_missing_tooth_at_the_start_is_bridged_by_its_neighbours():
    machine = train(1)
    healthy = equilibrium(assemble(machine, no_casing()))
    state = equilibrium(assemble(with_missing(machine, [0]), no_casing()))
    assert state.motor_torque == pytest.approx(healthy.motor_torque, rel=1e-9)
    assert state.mesh_force[0] == pytest.approx(healthy.mesh_force[0], rel=1e-9)


def test_no_teeth_left_is_refused_with_the_reason():
    machine = train(1)
    with pytest.raises(EquilibriumError, match="Too many teeth are missing"):
        equilibrium(assemble(with_missing(machine, range(55)), no_casing()))


def with_missing(machine, teeth):
    wheel = np.zeros(55)
    wheel[list(teeth)] = np.inf
    mesh = dataclasses.replace(machine.meshes[0], drive_clearance_wheel=wheel, coast_clearance_wheel=wheel)
    return dataclasses.replace(machine, meshes=(mesh,))


@pytest.mark.parametrize("stages", [1, 2, 3])
@pytest.mark.parametrize("model", ["timoshenko", "torsion"])
@pytest.mark.parametrize("clearance", [10e-6, 60e-6])
def test_flanks_set_back_beyond_the_reference_approach_still_find_each_other(stages, model, clearance):
    """The linear reference alone leaves these flanks open, and an open train has no stiffness against turning."""
    machine = train(stages, model=model)
    meshes = tuple(
        dataclasses.replace(m, drive_clearance_pinion=np.full(m.drive.pinion_teeth, clearance)) for m in machine.meshes
    )
    state = equilibrium(assemble(dataclasses.replace(machine, meshes=meshes), rigid_casing(machine)))
    assert state.motor_torque == pytest.approx(needed_torque(machine), rel=1e-9)
