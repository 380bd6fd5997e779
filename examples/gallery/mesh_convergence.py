"""
Discretisation error of a mesh
==============================

A coarse finite-element mesh makes teeth too stiff. The results of three meshes with a constant refinement ratio give
the order of convergence, the stiffness extrapolated to zero element size (Richardson), and its uncertainty.
"""

import matplotlib.pyplot as plt
import numpy as np

import gearcase

scene = gearcase.Scene.from_file("minimal").changed({"stages.1.mesh": {"model": "plane"}})
study = gearcase.converge(scene, "gear-mesh")
stiffness = study.quantities["stage 1 stiffness"]

# %%
# Mean mesh stiffness over the element size divided by that of the scene. Error bars show the uncertainty, the curve is
# a fitted power law:

figure, axes = plt.subplots(figsize=(6, 3.5), layout="constrained")
axes.errorbar(stiffness.sizes, stiffness.values, stiffness.bands, fmt="o", capsize=3, label="computed")
slope, limit = np.polyfit(np.power(stiffness.sizes, stiffness.order), stiffness.values, 1)
fine = np.linspace(0, max(stiffness.sizes), 100)
axes.plot(fine, limit + slope * fine**stiffness.order, "C7", label=f"order {stiffness.order:.1f}")
axes.axhline(stiffness.limit, color="C3", lw=1, ls="--", label="extrapolated to zero element size")
axes.legend()
axes.set(xlabel="relative element size", ylabel=f"stage 1 stiffness, {study.units['stage 1 stiffness']}")

# %%
# Uncertainty of the stiffness with the mesh of the scene:

band = stiffness.relative_bands[study.in_use]
print(f"{100 * band:.2g} %")
