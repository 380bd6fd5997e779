"""
A missing tooth in the synchronous average
==========================================

The time-synchronous average over revolutions of one shaft keeps what repeats with that shaft. A missing tooth of the
pinion causes one impact in each revolution, for about a twentieth of it.
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
axes.set(xlabel="revolutions of the pinion", ylabel="m/s2")
axes.legend()

# %%
# The crest factor, peak over rms, separates one impact a revolution from a steady vibration:


def crest(average):
    """Peak over rms of a signal without its mean."""
    swing = average - average.mean()
    return float(abs(swing).max() / swing.std())


crests = {name: crest(average) for name, average in averages.items()}
print({name: round(value, 1) for name, value in crests.items()})
