"""The shipped bench with everything that is nonlinear at once against an adaptive integrator of the same equations.

Rolling elements with a spall, oil between the flanks, deviations, a light load under which the flanks let go. The
reference is SciPy's DOP853 at a relative tolerance of 1e-9; it shares the assembled matrices and the force laws.
"""

import numpy as np
import pytest

from benchmarks.reference_integrator import ReferenceSettings
from mbd.output.simulate import simulate
from pipelines.engine.run_graph import Work
from pipelines.machine.system_assembly import assemble_machine, assemble_system
from pipelines.runs.single_results import scene_graph
from pipelines.scene.load_scene import load_scene

pytestmark = pytest.mark.slow

BENCH = {
    "control": None, "diagnosis.windows_s": {}, "stages.1.mesh": {"model": "iso"}, "casing.model": "rigid",
    "casing.mount_stiffness_N_per_um": 200.0, "film": {"model": "squeeze"},
    "load.torque_N_m": 1.5, "deviations.iso_grade": 9,
    "bearings": {"model": "hertz", "designation": "6208", "radial_clearance_um": 0.0, "axial_preload_um": 8.0,
                 "damping_time_us": 20.0},
    "drive.times_s": [0.0, 1.0], "drive.speeds_rpm": [1500.0, 1500.0], "shaft_model.model": "torsion",
    "faults": [{"kind": "bearing-spall", "shaft": 2, "bearing": 1, "on": "outer-ring", "width_mm": 2.0,
                "depth_um": 40.0, "angle_deg": -90.0}],
}  # fmt: skip
WINDOW = 0.05  # s


@pytest.fixture(scope="module")
def system():
    loaded = load_scene("bench", BENCH)
    graph, model = scene_graph(loaded)
    outcome = Work().build(graph, [*model.law_names, "casing"])
    machine = assemble_machine(model.parts, [outcome.value(name) for name in model.law_names])
    return assemble_system(machine, outcome.value("casing"), model.recorded, 20e3)


def test_accelerations_agree_within_half_a_per_cent(system):
    found = {}
    for method, step in (("exponential", 5e-6), ("reference", 1e-5)):
        run = simulate(system, ReferenceSettings(end=WINDOW, output_rate=20e3, step=step, integrator=method))
        found[method] = run
    losses = found["exponential"].counter("mesh_1:contact_losses")
    assert losses > 0
    names = [name for name in found["exponential"].channel_names if name.split(":")[-1] in ("ax", "ay", "az")]
    for name in names:
        one, exact = (found[method].channel(name) for method in ("exponential", "reference"))
        assert np.sqrt(np.mean((one - exact) ** 2)) < 5e-3 * np.sqrt(np.mean(exact**2)), name
