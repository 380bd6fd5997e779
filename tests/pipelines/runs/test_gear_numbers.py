"""`gearcase gears` in numbers: curves while a damaged tooth passes, beside those of sound teeth."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray

import gearcase
from pipelines.cli.main import main
from pipelines.engine.run_graph import Work
from pipelines.machine.checks.strength import contact_pressure
from pipelines.machine.layout import lay_out
from pipelines.report.figures.plots import transmission_error_figure
from pipelines.runs.gear_curves import (
    MeshState,
    gear_curves,
    gear_rows,
    machine_states,
    transmission_errors,
    write_curves,
)
from pipelines.scene.load_scene import load_scene
from pipelines.steps.pair_curves import engagement

CHIP = {"kind": "chipped-tooth", "stage": 1, "gear": "wheel", "tooth": 7, "depth_mm": 2.0, "extent_mm": 6.0}
WEAR = {"kind": "worn-tooth", "stage": 1, "gear": "wheel", "depth_um": 20.0, "place": "root", "width_mm": 4.0}
CRACK = {"kind": "cracked-tooth", "stage": 1, "gear": "pinion", "tooth": 3, "depth_mm": 2.0}


def scene(*faults):
    return gearcase.Scene.from_file("minimal").changed(faults=list(faults), deviations={"enabled": False})


def found(*faults, tilt=0.0):
    pairs = gearcase.laws(scene(*faults))
    curves = gear_curves(pairs, [MeshState(force=pair.force, tilt=tilt) for pair in pairs])
    return curves, gear_rows(pairs, curves), pairs


def test_a_damaged_tooth_is_softer_while_it_is_in_mesh_and_the_curves_agree_outside():
    curves, (healthy, faulty), (pair,) = found(CHIP)
    first, last = pair.pair.xi_start - pair.pair.overlap_ratio / 2, pair.pair.xi_end + pair.pair.overlap_ratio / 2
    outside = (curves.position < first - 0.1) | (curves.position > last + 0.1)
    sound, chipped = curves.secant
    assert np.allclose(sound[outside], chipped[outside], rtol=1e-9)
    assert (chipped <= sound * (1 + 1e-9)).all()
    assert faulty["least N/um"] < 0.98 * healthy["least N/um"]
    assert faulty["TE p-p um"] > healthy["TE p-p um"]
    assert faulty["share %"] < healthy["share %"]
    assert float(curves.cycle[1]) == 7.0


def test_a_crack_shows_on_the_flank_of_its_mouth_alone():
    _, (healthy, drive), _ = found(CRACK)
    assert drive["secant N/um"] < 0.99 * healthy["secant N/um"]
    _, (healthy, coast), _ = found(CRACK | {"flank": "coast"})
    assert coast["secant N/um"] == pytest.approx(healthy["secant N/um"], rel=1e-9)


@pytest.mark.parametrize("fault", [CRACK | {"depth_mm": 3.0}, {k: CRACK[k] for k in ("stage", "gear", "tooth")} | {
    "kind": "missing-tooth"}])  # fmt: skip
def test_the_pressure_beside_a_damaged_tooth_is_that_of_the_neighbour_that_carries_its_load(fault):
    _, (healthy, faulty), (pair,) = found(fault)
    patterns = [float(np.nanmax(pair.pattern(tooth=n, faulty=True).values, initial=0.0)) for n in (2, 3, 4)]
    assert patterns[1] < max(patterns)
    assert faulty["pressure MPa"] == pytest.approx(max(patterns) / 1e6, rel=1e-12)
    assert faulty["pressure MPa"] > healthy["pressure MPa"]


def test_wear_of_all_teeth_is_not_in_the_healthy_curve():
    worn, _, _ = found(WEAR)
    sound, _, _ = found()
    assert np.allclose(worn.secant.sel(case=0), sound.secant.sel(case=0), rtol=1e-12)
    assert float(worn.secant[1].mean()) < 0.95 * float(worn.secant[0].mean())


def test_every_damaged_tooth_passes_in_a_case_of_its_own():
    curves, rows, _ = found(CHIP, CRACK, {**WEAR, "tooth": 7})
    assert [row["state"] for row in rows] == [
        "healthy",
        "chipped tooth and worn tooth 7 of the wheel",
        "cracked tooth 3 of the pinion",
    ]
    assert curves.cycle.values.tolist() == [7.0, 7.0, 3.0]


def test_means_are_those_of_a_mesh_cycle_and_shares_sum_to_one():
    curves, (row,), (pair,) = found()
    assert row["secant N/um"] == pytest.approx(pair.stiffness().secant.mean() / 1e6, rel=1e-3)
    assert np.allclose(curves.share.sum("pair"), 1.0)
    first, last = engagement(pair.pair)
    assert last - first >= pair.pair.total_contact_ratio
    assert first <= pair.pair.xi_start
    assert last >= pair.pair.xi_end


def test_the_transmission_error_peak_to_peak_is_that_of_many_positions():
    """Of a relieved spur pair, whose curve has a narrow peak: 40 positions a mesh cycle give 8 % less."""
    wheels = {"pinion_teeth": 23, "wheel_teeth": 57, "module_mm": 3.0, "face_width_mm": 25.0}
    relief = {"tip_relief": {"amount_um": 11.0, "length_mm": 6.06}}
    given = gearcase.Scene.from_file("pair").changed({"stages.1": wheels | {"pinion": relief, "wheel": relief}})
    (pair,) = gearcase.laws(given)
    force = 200.0 / pair.pair.pinion.base_radius
    (_, row) = gear_rows([pair], gear_curves([pair], [MeshState(force=force, tilt=0.0)]))
    many = pair.stiffness(np.arange(2048) / 2048, force=force).transmission_error
    assert row["TE p-p um"] == pytest.approx(1e6 * np.ptp(many), rel=0.01)


def test_a_tilt_moves_the_pressure_and_the_force_stays():
    straight, _, (pair,) = found()
    tilted, _, _ = found(tilt=20e-6 / pair.pair.face_width)
    assert (tilted.pressure.max(["position", "pair"]) > 1.1 * straight.pressure.max(["position", "pair"])).all()
    assert (tilted.force == straight.force).all()


def test_the_machine_gives_its_own_force_and_tilt():
    given = scene().changed(shaft_model={"model": "timoshenko"})
    (state,) = machine_states(given.loaded, Work(quiet=True))
    (pair,) = gearcase.laws(given)
    assert state.force == pytest.approx(pair.force, rel=1e-6)
    assert state.tilt is not None
    assert 0 < abs(state.tilt) * pair.pair.face_width < 20e-6


def test_a_torque_that_no_steel_bears_is_refused_with_its_pressure(capsys):
    """The pressure at the pitch point rises with the root of the torque: that of 20 N m times 1000 for 2e7."""
    pressures = []
    for torque in ("20", "2e7"):
        assert main(["gears", "minimal", "--torque", torque]) == (0 if torque == "20" else 2)
        pressures += re.findall(
            r"stages.1: the line load .* gives a contact stress of (\S+) MPa, and", capsys.readouterr().err
        )
    pair = lay_out(load_scene("minimal").scene).pairs[0]
    assert [float(one) for one in pressures] == [pytest.approx(contact_pressure(pair, 20.0) / 1e6 * 1000, rel=1e-3)]


def test_a_tilt_beyond_linear_elasticity_is_refused(capsys):
    assert main(["gears", "minimal", "--tilt", "-5000"]) == 2
    assert "--tilt -5000 um: is more than 0.25 modules of stage 1 (500 um)" in capsys.readouterr().err


def test_files_hold_the_curves(tmp_path):
    curves, _, _ = found(CHIP)
    write_curves(curves, tmp_path / "curves.nc")
    with xarray.open_dataset(tmp_path / "curves.nc", engine="h5netcdf") as back:
        assert np.array_equal(back.secant.values, curves.secant.values)
        assert back.pressure.attrs["units"] == "Pa"
        assert back.state.values.tolist() == ["healthy", "chipped tooth 7 of the wheel"]
    write_curves(curves, tmp_path / "curves.csv")
    table = pd.read_csv(tmp_path / "curves.csv")
    assert len(table) == 2 * curves.sizes["position"]
    shares = table.filter(like="share of pair").sum(axis=1)
    assert np.allclose(shares, 1.0)
    assert np.allclose(table["mesh cycle"], table["position [mesh cycles]"] + 7)


def test_the_plot_of_transmission_error_shows_the_passage_of_a_damaged_tooth():
    (pair,) = gearcase.laws(scene(CHIP))
    error = transmission_errors(pair, MeshState(force=pair.force, tilt=0.0))
    assert list(error.passages) == ["healthy", "chipped tooth 7 of the wheel"]
    moved = error.passages["chipped tooth 7 of the wheel"] - error.passages["healthy"]
    assert abs(error.place[np.argmax(moved)]) < 1.0
    assert [len(axes.lines) for axes in transmission_error_figure("T", [error]).axes] == [1, 0, 2]


def test_bars_of_two_curves_stand_side_by_side_around_their_order():
    (pair,) = gearcase.laws(scene())
    error = transmission_errors(pair, MeshState(force=pair.force, tilt=0.0))
    bars = transmission_error_figure("T", [error, error]).axes[1].containers
    middles = [[bar.get_x() + bar.get_width() / 2 for bar in row] for row in bars]
    assert np.allclose(middles, np.arange(1, len(middles[0]) + 1) + np.array([[-0.2], [0.2]]))
