"""
Load share and misalignment
===========================

Bending of shafts and deflection of bearings misalign the flanks of a pair by some micrometres over the face. The load
then moves to one end of the face. The contact lines shorten, so the mesh stiffness falls.
"""

import matplotlib.pyplot as plt
import numpy as np

import gearcase

scene = gearcase.Scene.from_file("minimal")
width = scene.to_dict()["stages"][0]["face_width_mm"] / 1000  # m
pair = gearcase.laws(scene)[0]
cycles = np.linspace(-1.5, 1.5, 121)

# %%
# Load share of one tooth pair during its passage through the mesh, without misalignment and with 20 micrometres over
# the face width:

figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
stiffness = {}
for tilted in (0.0, 20e-6):
    curve = pair.stiffness(cycles, tilt=tilted / width)
    stiffness[tilted] = curve.secant.mean()
    axes.plot(cycles, curve.share[:, curve.pair == 0], label=f"{1e6 * tilted:.0f} um")
axes.set(xlabel="position in mesh, mesh cycles", ylabel="load share of the tooth pair")
axes.legend(title="misalignment over the face")

# %%
# Mean mesh stiffness of the misaligned pair in per cent of that of the aligned pair:

ratio = float(stiffness[20e-6] / stiffness[0.0])
print(f"{100 * ratio:.0f} %")
