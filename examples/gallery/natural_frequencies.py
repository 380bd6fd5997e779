"""
Natural frequencies over speed
==============================

A Campbell diagram shows natural frequencies and excitation orders over speed. Where the line of an order crosses a
natural frequency, a resonance is expected. Gyroscopic moments change the natural frequencies of the shafts with the
speed.
"""

import matplotlib.pyplot as plt
import numpy as np

import gearcase

scene = gearcase.Scene.from_file("minimal").changed(
    {"shaft_model": {"model": "timoshenko", "gyroscopic": True}, "casing": {"model": "none"}, "sensors": []}
)
speeds = np.linspace(0.0, 3000.0, 13)  # rpm
modes = [gearcase.modes(scene, up_to=1000, speed=speed) for speed in speeds]

# %%
# Points are natural frequencies. Lines are orders of the pinion shaft: 1 is its rotation, 20 the mesh of its 20
# teeth, 40 twice the mesh frequency.

figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
for speed, found in zip(speeds, modes, strict=True):
    axes.plot(np.full(len(found.frequencies), speed), found.frequencies, "k.", ms=5)
for order in (1, 20, 40):
    axes.plot(speeds, order * speeds / 60, label=f"order {order}")
axes.set(xlabel="speed of the pinion, rpm", ylabel="frequency, Hz", ylim=(0, 1000))
axes.legend()

# %%
# Speed at which the mesh frequency equals the first natural frequency, with the part that dominates this mode:

first = modes[0].frequencies[0]
resonance = 60 * first / 20
print(f"{resonance:.0f} rpm ({first:.0f} Hz, {modes[0].dominant[0]})")
