"""
A missing tooth in the synchronous average
==========================================

The time-synchronous average is the mean signal over the revolutions of a shaft. It keeps the part of the signal that
repeats with this shaft. A missing tooth of the pinion causes one impact in each revolution.
"""

import matplotlib.pyplot as plt
import numpy as np

import gearcase

TURN = 60 / 900  # s, of the pinion
POINTS = 600  # of a revolution

scene = gearcase.Scene.from_file("minimal").changed({"deviations.enabled": False})
fault = {"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 0}
averages = {}
for name, one in (("healthy", scene), ("one tooth missing", scene.changed(faults=[fault]))):
    signal = gearcase.simulate(one).acceleration.sel(sensor="sensor_3", axis="z")
    at = 0.2 + TURN * np.arange(11 * POINTS) / POINTS  # eleven revolutions at constant speed
    averages[name] = np.interp(at, signal.time, signal).reshape(11, POINTS).mean(axis=0)

# %%

figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
for name, average in reversed(averages.items()):
    axes.plot(np.arange(POINTS) / POINTS, average, label=name)
axes.set(xlabel="revolutions of the pinion", ylabel="acceleration, m/s2")
axes.legend()

# %%
# An impact per revolution increases the crest factor, which is the peak divided by the rms:


def crest(average):
    """Peak divided by rms of a signal without its mean."""
    swing = average - average.mean()
    return float(abs(swing).max() / swing.std())


crests = {name: crest(average) for name, average in averages.items()}
print({name: round(value, 1) for name, value in crests.items()})
