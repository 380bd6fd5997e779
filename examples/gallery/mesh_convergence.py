"""
How far a mesh is from converged
================================

Teeth that are too coarsely meshed are too stiff. From three meshes, each finer than the last, follow the order with
which the error falls, the limit, and the band in which it lies.
"""

import matplotlib.pyplot as plt

import gearcase

scene = gearcase.Scene.from_file("minimal").changed({"stages.1.mesh": {"model": "plane"}})
study = gearcase.converge(scene, "gear-mesh")
stiffness = study.quantities["stage 1 stiffness"]

# %%
# The mean stiffness over the size of the elements, with its band, and the limit:

figure, axes = plt.subplots(figsize=(6, 3.5), layout="constrained")
axes.errorbar(stiffness.sizes, stiffness.values, stiffness.bands, marker="o", capsize=3)
axes.axhline(stiffness.limit, color="0.6", lw=1, ls="--")
axes.set(xlabel="element size over that in use", ylabel=f"stage 1 stiffness, {study.units['stage 1 stiffness']}")

# %%
# What the setting in use is off, at most:

band = stiffness.relative_bands[study.in_use]
print(f"{100 * band:.2g} %")
