"""
From a plan to a data set
=========================

A campaign simulates the machines that a plan describes. The result is a data set, which opens as one xarray object
with labels and variables. This plan varies the load of a hoist in six steps. The figure shows vibration over load.
"""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

import gearcase

folder = Path(mkdtemp())
plan = folder / "loads.toml"
plan.write_text(
    """
scene = "minimal"
design = "grid"

[variables]
mass_kg = [60.0, 90.0, 120.0, 150.0, 180.0, 210.0]

[settings]
simulation.end_s = 0.2
deviations.enabled = false
load.container_kg = "$mass_kg"
""",
    encoding="utf-8",
)
done = gearcase.campaign(plan, out=folder / "loads", executor=ThreadPoolExecutor(1))
data = gearcase.open_dataset(done.folder)

# %%
# Signals are read from the disk when they are used, here for the rms of the acceleration at one sensor:

levels = data.acceleration.sel(sensor="sensor_3", axis="z", time=slice(0.1, None)).std("time")
masses = data.mass_kg.values
exponent, logarithm = np.polyfit(np.log(masses), np.log(levels.values), 1)

figure, axes = plt.subplots(figsize=(6, 3.5), layout="constrained")
axes.plot(masses, levels, "o", label="simulated")
fine = np.linspace(0, 220, 100)
axes.plot(fine, np.exp(logarithm) * fine**exponent, "C7--", label=f"power law, exponent {exponent:.2f}")
axes.legend()
axes.set(xlabel="mass of the container, kg", ylabel="acceleration, m/s2 rms", xlim=(0, None), ylim=(0, None))

# %%
# The exponent is below 1: the rms grows less than in proportion to the load.

print(f"{exponent:.2f}")
