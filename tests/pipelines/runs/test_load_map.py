"""A pair over its load: equilibrium, symmetry, limits, and the numbers of `gears` and `design`."""

import json

import numpy as np
import pytest
import xarray

import gearcase
from fem.contact.models.solid import Solid
from fem.contact.models.solid_stress import root_stress
from pipelines.cli.main import main
from pipelines.runs.gear_curves import MeshState, gear_curves
from pipelines.runs.load_map import load_map, root_rows

TORQUES = (20.0, 40.0, 80.0)
SETTINGS = {"stages.1.mesh.model": "plane", "stages.1.mesh.slices": 15, "stages.1.face_width_mm": 12.0}


@pytest.fixture(scope="module", params=[0.0, 34.0], ids=["spur", "helical"])
def solved(request):
    """Laws of a pair with crowned flanks, and the stresses of its roots by unit forces.

    At 34 degrees the wheel is in contact down to less than 0.3 m_n above the middle of its fillet.
    """
    scene = gearcase.Scene.from_file("pair").changed(
        SETTINGS | {"stages.1.helix_angle_deg": request.param, "stages.1.pinion.lead_crowning_um": 4.0}
    )
    found = gearcase.laws(scene)[0]
    return found, root_stress(found.pair, Solid(refinement=0.6))


def of(solved, **options):
    found, roots = solved
    return load_map(found.pair, {"unmodified": found.unmodified, "modified": found.healthy}, TORQUES, roots, **options)


def test_the_line_loads_carry_the_torque_and_the_load_factor_is_their_largest_over_their_mean(solved):
    found = of(solved)
    pair = solved[0].pair
    width = pair.face_width / found.sizes["face"]
    force = (found.line_load.sum("face") * width).values
    assert np.allclose(force, (found.torque / pair.pinion.base_radius).values, rtol=1e-9)
    factor = (found.line_load.max("face") / found.line_load.mean("face")).values
    assert np.allclose(factor, found.face_load_factor.values, rtol=1e-12)
    assert (np.diff(factor[1]) < 0.0).all()  # a larger load flattens a crowning


def test_a_spur_pair_with_equal_leads_has_a_load_factor_of_one_and_roots_that_are_symmetric(solved):
    if solved[0].pair.base_helix_angle:
        pytest.skip("a helical pair has contact lines that end at the faces")
    found = of(solved).sel(state="unmodified")
    assert np.allclose(found.face_load_factor, 1.0, rtol=1e-9)
    assert np.allclose(found.root_stress, found.root_stress[..., ::-1], rtol=1e-6)


def test_an_opposite_tilt_of_a_spur_pair_mirrors_loads_pressures_and_root_stresses(solved):
    if solved[0].pair.base_helix_angle:
        pytest.skip("the helix distinguishes both ends of the face")
    one, other = of(solved, tilt=3e-4), of(solved, tilt=-3e-4)
    for name in ("line_load", "pressure", "root_stress"):
        assert np.allclose(one[name], other[name][..., ::-1], rtol=1e-6, atol=1e-6 * float(one[name].max())), name
    load, stress = (one[name][0, -1, ..., -1] / one[name][0, -1, ..., 0] for name in ("line_load", "root_stress"))
    assert float(load) > 1.2  # closer at the +y end
    assert (stress > 1.0).all()
    assert (stress < load).all()  # bending of the tooth spreads the load along the root


def test_without_modifications_the_root_stress_grows_almost_as_the_load(solved):
    """Load sharing of an unmodified pair hardly depends on the load; the Hertz pressure grows with its square root."""
    found = of(solved).sel(state="unmodified")
    stress = found.root_stress.max("root_face").sel(torque=[40.0, 80.0]).values
    assert stress[1] / stress[0] == pytest.approx(2.0, rel=0.1)
    pressure = found.pressure.max("face").sel(torque=[40.0, 80.0]).values
    assert pressure[1] / pressure[0] == pytest.approx(2.0**0.5, rel=0.1)


def test_transmission_error_and_pressure_are_those_of_gears(solved):
    laws, _ = solved
    found = of(solved).sel(state="modified", torque=list(TORQUES))
    states = [MeshState(force=torque / laws.pair.pinion.base_radius, tilt=0.0) for torque in TORQUES]
    curves = gear_curves([laws] * len(states), states)
    curves = curves.isel(case=curves.state.values == "healthy")
    assert np.allclose(found.peak_to_peak, curves.peak_to_peak, rtol=0.02)
    assert np.allclose(found.pressure.max("face"), curves.greatest_pressure, rtol=0.02)
    assert np.allclose(found.pattern.max(("diameter", "pattern_face")), curves.greatest_pressure, rtol=1e-9)
    assert float(found.order_amplitude.isel(torque=-1, order=0)) < float(found.peak_to_peak[-1])


def test_a_map_of_two_torques_has_two_patterns_and_its_largest_root_stresses_are_a_table(solved):
    found, roots = solved
    made = load_map(found.pair, {"unmodified": found.unmodified}, (40.0, 20.0, 40.0), roots)
    assert made.pattern_torque.values.tolist() == [20.0, 40.0]
    rows = root_rows(1, made, (40.0, 20.0, 40.0))
    assert [row["torque N m"] for row in rows] == [20.0, 40.0]
    largest = made.root_stress.sel(torque=40.0, gear="wheel").max()
    assert rows[1]["wheel MPa"] == pytest.approx(float(largest) / 1e6)


@pytest.mark.slow
def test_gears_writes_the_figure_and_the_data_of_its_map(tmp_path, capsys):
    files = [tmp_path / "map.png", tmp_path / "map.nc"]
    settings = [word for key, value in SETTINGS.items() for word in ("--set", f"{key}={value}")]
    command = ["gears", "pair", *settings, "--torque", "20", "40", "--json", "--quiet", "--map", *map(str, files)]
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out)["maps"] == [str(file) for file in files]
    assert files[0].read_bytes().startswith(b"\x89PNG")
    with xarray.open_dataset(files[1], engine="h5netcdf") as found:
        assert found.pattern_torque.values.tolist() == [20.0, 40.0]
        assert found.root_stress.dims == ("state", "torque", "gear", "root_face")
        assert {one.attrs["units"] for one in found.data_vars.values()} == {"m", "1", "N/m", "Pa"}


def test_a_tilt_that_depends_on_the_torque_is_refused_for_a_map(tmp_path, capsys):
    assert main(["gears", "pair", "--tilt", "balanced", "--map", str(tmp_path / "map.png")]) == 2
    assert "--tilt balanced depends on the torque" in capsys.readouterr().err
