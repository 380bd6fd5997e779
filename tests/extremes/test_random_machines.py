"""Valid machines drawn at random within what engineers build: each moves finitely, with closed energy balance."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from scenes import simulated, unexplained

from pipelines.io.errors import InputError
from pipelines.scene.load_scene import load_scene

ROUNDS = {"fast": 12, "slow": 150}


def damping(largest):
    """None, or so much that a balance can be held against what it takes."""
    return st.one_of(st.just(0.0), st.floats(0.1, largest))


gears = st.fixed_dictionaries(
    {
        "stages.1.pinion_teeth": st.integers(14, 30),
        "stages.1.wheel_teeth": st.integers(30, 70),
        "stages.1.helix_angle_deg": st.floats(0, 30),
        "stages.1.face_width_mm": st.floats(4, 24),
        "stages.1.pinion_hand": st.sampled_from(["right", "left"]),
        "stages.1.backlash_um": st.floats(0, 500),
        "stages.1.direction_deg": st.floats(-60, 60),
        "stages.1.cycle_at_start": st.floats(0, 0.999),
        "stages.1.mesh_damping_time_us": damping(5),
    }
)
machine = st.fixed_dictionaries(
    {
        "shaft_model.model": st.sampled_from(["torsion", "timoshenko"]),
        "bearings.model": st.just("linear"),
        "bearings.radial_stiffness_N_per_um": st.floats(10, 1000),
        "bearings.damping_time_us": damping(20),
        "deviations.enabled": st.booleans(),
        "deviations.iso_grade": st.integers(1, 8),
        "deviations.seed": st.integers(0, 1000),
        "casing.model": st.sampled_from(["none", "rigid"]),
        "load.container_kg": st.floats(5, 400),
        "drive.speeds_rpm": st.lists(st.floats(-1500, 1500), min_size=2, max_size=2).map(lambda s: [0.0, *s]),
        "drive.motors": st.sampled_from([1, 2]),
        "simulation.integrator": st.sampled_from(["exponential", "trapezoidal"]),
    }
)
faults = st.lists(st.integers(0, 29), max_size=2, unique=True)


def moved(gear, rest, teeth, cache) -> bool:
    """Whether the scene is one; then it must move as it should."""
    change = {
        **gear, **rest, "drive.times_s": [0.0, 0.005, 0.03], "simulation.end_s": 0.03, "simulation.step_us": 5.0,
        "simulation.band_Hz": 1e7,  # all modes: a mode that is left out is missing from the balance of its part
        "diagnosis.windows_s": {},
        "faults": [{"kind": "missing-tooth", "stage": 1, "gear": "wheel", "tooth": tooth} for tooth in teeth],
    }  # fmt: skip
    if rest["casing.model"] == "none":
        change["sensors"] = []
    try:
        loaded = load_scene("minimal", change)
        trajectory = simulated(loaded, cache)
    except InputError:
        return False
    if unexplained(trajectory):  # the step explains it if a quarter of it leaves less than a quarter
        finer = simulated(load_scene("minimal", change | {"simulation.step_us": 1.25}), cache)
        assert np.isfinite(finer.values).all()
        for part in trajectory.open_parts():
            left = [abs(run.energy(part, "residual")) for run in (trajectory, finer)]
            assert part not in finer.open_parts() or left[1] < left[0] / 4, part
    return True


def check(rounds, folder):
    counts = {True: 0, False: 0}

    # an example as found says enough; to make it smaller takes minutes
    @settings(
        max_examples=rounds, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck),
        phases=(Phase.explicit, Phase.generate),
    )  # fmt: skip
    @given(gear=gears, rest=machine, teeth=faults)
    def run(gear, rest, teeth):
        counts[moved(gear, rest, teeth, folder)] += 1

    run()
    print(f"{counts[True]} machines moved, {counts[False]} were refused")
    assert counts[True] >= rounds // 4


@pytest.mark.slow
def test_a_dozen_machines(tmp_path):
    check(ROUNDS["fast"], tmp_path)


@pytest.mark.slow
def test_many_machines(tmp_path):
    check(ROUNDS["slow"], tmp_path)
