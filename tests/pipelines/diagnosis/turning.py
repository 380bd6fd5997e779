"""Recordings of a machine of three shafts that is known exactly: meshing, pitch deviations, noise, and one fault."""

import numpy as np
import xarray

from pipelines.signals.orders.kinematics import Bearing, Gear, Kinematics, Shaft

RATE, SECONDS = 8000.0, 6.0
SPEED = 20.0  # Hz, first shaft
PAIRS = ((17, 40), (19, 45))
MACHINE = Kinematics(
    shafts=(
        Shaft(name="shaft_1", ratio=1.0),
        Shaft(name="shaft_2", ratio=17 / 40),
        Shaft(name="shaft_3", ratio=17 / 40 * 19 / 45),
    ),
    gears=(
        Gear(name="stage 1 pinion", shaft="shaft_1", stage=1, teeth=17),
        Gear(name="stage 1 wheel", shaft="shaft_2", stage=1, teeth=40),
        Gear(name="stage 2 pinion", shaft="shaft_2", stage=2, teeth=19),
        Gear(name="stage 2 wheel", shaft="shaft_3", stage=2, teeth=45),
    ),
    bearings=(Bearing(name="bearing_1", shaft="shaft_1", orders={"BPFO": 3.58, "BPFI": 5.42}),),
    frequency=SPEED,
)


def recording(seed, fault="", tooth=5, depth=1.0, drift=0.0, noise=0.02):
    """A machine of its own (`seed`: pitch deviations and noise), with a fault of a component or none.

    A damaged tooth excites a resonance while it is in mesh; a spall does at every passage; unbalance turns.
    """
    random = np.random.default_rng(seed)
    time = np.arange(round(RATE * SECONDS)) / RATE
    angle = 2 * np.pi * (SPEED * time + 0.5 * drift * SPEED * time**2 / SECONDS)
    signal = np.zeros((len(time), 2))
    pulses = np.zeros_like(time)
    for gear in MACHINE.gears:
        place = angle * MACHINE.shaft(gear.shaft).ratio * gear.teeth / (2 * np.pi)  # teeth passed
        deviation = 1.0 + 0.05 * random.standard_normal(gear.teeth)
        now = deviation[(place % gear.teeth).astype(int)]
        for harmonic, size in ((1, 1.0), (2, 0.4), (3, 0.2)):
            signal += np.outer(0.5 * size * now * np.cos(2 * np.pi * harmonic * place), [1.0, 0.6])
        if fault == gear.name:
            pulses += np.diff((place - tooth) // gear.teeth, prepend=(place[0] - tooth) // gear.teeth)
    if fault == "bearing_1":
        passed = angle * 3.58 / (2 * np.pi)
        pulses += np.diff(np.floor(passed), prepend=0.0)
    if fault == "shaft_2":
        signal += depth * np.outer(np.cos(angle * MACHINE.shaft("shaft_2").ratio), [1.0, 0.6])
    ring = np.exp(-time[:200] / 0.002) * np.sin(2 * np.pi * 2300.0 * time[:200])
    signal += depth * np.outer(np.convolve(pulses, ring)[: len(time)], [3.0, 1.5])
    signal += noise * random.standard_normal(signal.shape)
    angles = np.stack([angle * shaft.ratio for shaft in MACHINE.shafts], axis=1)
    return xarray.Dataset(
        {"acceleration": (("time", "sensor", "axis"), signal[:, None, :]), "shaft_angle": (("time", "shaft"), angles)},
        coords={"time": time, "sensor": ["near"], "axis": ["x", "z"], "shaft": [one.name for one in MACHINE.shafts]},
    )
