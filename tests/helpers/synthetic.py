"""A response with known lines, for the tests of what reads responses."""

import json

import numpy as np
import xarray

RATE = 10_000.0
MESH = 300.0
WHEEL = 300.0 / 55


def response(
    state="missing-tooth",
    load="rope",
    seed=1,
    deviations="on",
    depth=0.4,
    runout=0.05,
    noise=0.01,
    duration=5.0,
    sensors=3,
    lowering=1.0,
):
    """A mesh tone and its second order, modulated by the wheel: `runout` in every run, `depth` by the fault alone."""
    time = np.arange(round(duration * RATE)) / RATE
    rng = np.random.default_rng(seed)
    phase = rng.uniform(0, 2 * np.pi, 5)
    wheel = 2 * np.pi * WHEEL * time
    speed = np.interp(time, [0, 0.2, 0.3, 2.6, 2.9, 5.0], np.array([0, 0, 900, 900, -900, -900]) * np.pi / 30)
    fault = depth * np.where(time > 2.75, lowering, 1.0) if state == "missing-tooth" else 0.0 * time
    modulation = 1 + runout * np.cos(wheel + phase[0])
    for k in range(1, 5):
        modulation = modulation + fault / k * np.cos(k * wheel + phase[k])
    strength = np.abs(speed) / (30 * np.pi)
    tone = strength * modulation * (np.cos(2 * np.pi * MESH * time) + 0.5 * np.cos(2 * np.pi * 2 * MESH * time))
    resonance = 0.05 * np.cos(2 * np.pi * 1234.5 * time)
    rope = 0.02 * np.cos(2 * np.pi * 7.9 * time) if load == "rope" else 0 * time
    direction = np.array([[0.3, 0.2, 0.9], [0.5, 0.1, 0.5], [0.4, -0.3, 0.8]])[:sensors]
    acceleration = (tone + resonance + rope)[:, None, None] * direction
    ratios = np.array([1, 20 / 55, 20 / 55 * 21 / 62, 20 / 55 * 21 / 62 * 22 / 65])
    angle = np.cumsum(speed) / RATE
    data = {
        "acceleration": (("time", "sensor", "axis"), acceleration, {"units": "m/s2"}),
        "motor_speed": (("time", "motor"), np.stack([speed, speed], 1), {"units": "rad/s"}),
        "shaft_speed": (("time", "shaft"), speed[:, None] * ratios, {"units": "rad/s"}),
        "shaft_angle": (("time", "shaft"), angle[:, None] * ratios, {"units": "rad"}),
        "mesh_approach": (("time", "stage"), 1e-6 * (1 + 0.1 * tone[:, None] * np.ones(3)), {"units": "m"}),
        "mesh_force": (("time", "stage"), 900 + 90 * tone[:, None] * np.ones(3), {"units": "N"}),
        "bearing_force": (("time", "bearing", "axis"), 400 + tone[:, None, None] * np.ones((8, 3)), {"units": "N"}),
    }
    if load == "rope":
        data["rope_force"] = (("time",), 9810 * (1 + rope), {"units": "N"})
    return xarray.Dataset(
        data,
        coords={
            "time": time,
            "sensor": [f"sensor_{i + 1}" for i in range(sensors)],
            "axis": ["x", "y", "z"],
            "motor": ["motor_1", "motor_2"],
            "shaft": [f"shaft_{i}" for i in range(1, 5)],
            "stage": [1, 2, 3],
            "bearing": [f"bearing_{i}" for i in range(1, 9)],
        },
        attrs={
            "scene": f"rig-{state}",
            "title": "Synthetic hoist",
            "state": state,
            "load": load,
            "seed": seed if deviations == "on" else "none",
            "iso_grade": 5 if deviations == "on" else "none",
            "sensor_noise_m_s2": noise,
            "fault": json.dumps({"stage": 1, "gear": "wheel", "tooth": 0}),
        },
    )


def gear_outline(teeth, module, angle=0.0):
    """A spur outline good enough to look at: flanks as straight lines in polar coordinates, counter-clockwise."""
    pitch = module * teeth / 2
    profile = [(-0.5, -1.25), (-0.42, -1.25), (-0.25, 0.0), (-0.11, 1.0), (0.11, 1.0), (0.25, 0.0), (0.42, -1.25)]
    corners = []
    for tooth in range(teeth):
        for place, height in profile:
            polar = angle + 2 * np.pi * (tooth + place) / teeth
            corners.append((pitch + height * module) * np.array([np.cos(polar), np.sin(polar)]))
    return np.array(corners)


def box(size=(0.6, 0.25, 0.3)):
    """Nodes and triangles of a closed box with its low corner at the origin."""
    nodes = np.array([[x, y, z] for x in (0, size[0]) for y in (0, size[1]) for z in (0, size[2])], dtype=float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]
    return nodes, np.array(triangles)


def key_points():
    """Six ground, eight bearing and nine sensor points on the box."""
    shafts = (0.1, 0.2, 0.34, 0.5)
    points = {}
    for i in range(6):
        points[f"ground_{i + 1}"] = np.array([0.05 + 0.25 * (i // 2), 0.25 * (i % 2), 0.0])
    for i in range(8):
        points[f"bearing_{i + 1}"] = np.array([shafts[i // 2], 0.25 * (i % 2), 0.15])
        points[f"sensor_{i + 1}"] = np.array([shafts[i // 2], 0.25 * (i % 2), 0.21])
    points["sensor_9"] = np.array([0.3, 0.125, 0.3])
    return points
