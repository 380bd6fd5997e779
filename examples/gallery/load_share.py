"""
Load share and misalignment
===========================

Shafts bend and bearings give way, so that the teeth of a pair lie askew by some micrometres over the face. The load
moves to one end, fewer contact lines carry it, and the pair is softer.
"""

import matplotlib.pyplot as plt
import numpy as np

import gearcase

scene = gearcase.Scene.from_file("minimal")
width = scene.to_dict()["stages"][0]["face_width_mm"] / 1000  # m
pair = gearcase.laws(scene)[0]
cycles = np.linspace(-1.5, 1.5, 121)

# %%
# The share of the force that one tooth pair carries on its way through the mesh, straight and with the approach at one
# end of the face 20 micrometres larger than at the other:

figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
stiffness = {}
for askew in (0.0, 20e-6):
    curve = pair.stiffness(cycles, tilt=askew / width)
    stiffness[askew] = curve.secant.mean()
    axes.plot(cycles, curve.share[:, curve.pair == 0], label=f"{1e6 * askew:.0f} um")
axes.set(xlabel="mesh cycles", ylabel="share of the tooth pair")
axes.legend(title="misalignment over the face")

# %%
# What is left of the mean stiffness:

left = float(stiffness[20e-6] / stiffness[0.0])
print(f"{100 * left:.0f} %")
