"""Settings that make a shipped scene quick: coarse models and a short motion, for tests of the whole chain."""

from pipelines.scene.load_scene import load_scene


def diagnosable(name):
    """The same, long and fast enough for a diagnosis: eight revolutions of the stage 1 wheel in the window."""
    windows = {"lifting": [0.2, 0.6]}
    speeds = {"drive.speeds_rpm": [0.0, 3600.0, 3600.0], "drive.times_s": [0.0, 0.18, 0.6]}  # slow enough for the rope
    return coarse(name, end=0.6) | speeds | {"simulation.step_us": 50.0, "diagnosis.windows_s": windows}


def coarse(name, end=0.1):
    """Settings for `run` or `load_scene`."""
    scene = load_scene(name).scene
    settings = {
        "simulation.end_s": end,
        "simulation.step_us": 20.0,
        "drive.times_s": [0.0, min(0.05, end / 2), end],
        "drive.speeds_rpm": [0.0, 900.0, 900.0],
        "diagnosis.windows_s": {},
    }
    for number in range(1, len(scene.stages) + 1):
        settings[f"stages.{number}.mesh.model"] = "iso"
    if scene.casing.model == "craig-bampton":
        settings |= {"casing.element_size_mm": 40.0, "casing.band_Hz": 800.0}
    if name.startswith("rig"):
        # cubic elements with edge functions are those of bench and reducer; two halves are checked in
        # test_symmetric_halves.py, ten-node tetrahedra in test_bolted_joint_scenes.py
        settings |= {"casing.element": "tetrahedron-4", "casing.extrapolated": False}
    return settings


def as_options(settings):
    """The same for the command line."""
    from pipelines.io.toml_text import format_value

    return [word for path, value in settings.items() for word in ("--set", f"{path}={format_value(value)}")]
