"""The gallery: every script runs as it stands, at most sixty lines, and ends in the number that it is about."""

import runpy

import pytest
from matplotlib import pyplot
from sources import ROOT

GALLERY = ROOT / "examples" / "gallery"
SCRIPTS = sorted(path.stem for path in GALLERY.glob("*.py"))
HOLDS = {  # what a script ends in
    "bearing_envelope": lambda found: abs(found["found"] / found["expected"] - 1) < 0.02,  # a line is 1.2 Hz wide
    "campaign": lambda found: 0.5 < found["exponent"] < 1.0,  # the excitation grows, the teeth flatten in mesh
    "contact_pattern": lambda found: abs(found["pitch"] / found["nominal"] - 1) < 0.1 and found["highest"] > 1000,
    "craig_bampton": lambda found: 0 <= found["largest"] < 1e-3 and found["kept"] < 0.01 * found["unknowns"],
    "load_share": lambda found: 0.2 < found["ratio"] < 0.6,
    "matrices_from_elsewhere": lambda found: found["worst"] < 1e-4 and len(found["frequencies"]) < 10,
    "mesh_convergence": lambda found: found["stiffness"].order > 1 and found["band"] < 0.02,
    "mesh_stiffness": lambda found: 0.1 < found["ratio"] < 0.5,
    "mode_shape": lambda found: found["frequency"] == pytest.approx(1175, rel=0.02),
    "natural_frequencies": lambda found: found["modes"][0].dominant[0] == "motor coupling" and found["first"] < 150,
    "own_mesh_model": lambda found: found["ratio"] == pytest.approx(1, abs=1e-3),
    "run_up": lambda found: found["order"] == pytest.approx(20, rel=0.02),
    "speed_and_accuracy": lambda found: (
        found["errors"]["solid, coarse"] < 0.01 < found["errors"]["plane"] < found["errors"]["iso"] < 0.3
    ),
    "synchronous_average": lambda found: found["crests"]["one tooth missing"] > 3 * found["crests"]["healthy"],
}
SLOW = ("bearing_envelope", "craig_bampton", "mode_shape", "speed_and_accuracy")


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in SCRIPTS]
)
def test_a_script_ends_in_its_number_and_a_figure(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    pyplot.switch_backend("agg")
    try:
        found = runpy.run_path(str(GALLERY / f"{name}.py"))
        assert HOLDS[name](found), capsys.readouterr().out
        assert pyplot.get_fignums()
    finally:
        pyplot.close("all")


def test_every_script_has_its_number():
    assert HOLDS.keys() == set(SCRIPTS)


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_is_one_idea(name):
    lines = (GALLERY / f"{name}.py").read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 60
