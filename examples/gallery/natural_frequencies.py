"""
Natural frequencies over speed
==============================

A Campbell diagram shows natural frequencies and excitation orders over speed. Resonances are expected where an order
line crosses a natural frequency. Gyroscopic moments shift the modes of the shafts with the speed.
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
# Natural frequencies as points; orders of the pinion shaft as lines: its rotation, and its mesh with 20 teeth.

figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
for speed, found in zip(speeds, modes, strict=True):
    axes.plot(np.full(len(found.frequencies), speed), found.frequencies, "k.", ms=5)
for order in (1, 20, 40):
    axes.plot(speeds, order * speeds / 60, label=f"order {order}")
axes.set(xlabel="speed, rpm", ylabel="Hz", ylim=(0, 1000))
axes.legend()

# %%
# The mesh frequency meets the first mode, torsion of the shafts against the motor coupling, at

first = modes[0].frequencies[0]
resonance = 60 * first / 20
print(f"{resonance:.0f} rpm ({first:.0f} Hz, {modes[0].dominant[0]})")
