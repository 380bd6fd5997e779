"""
Mesh stiffness with a missing tooth
===================================

The stiffness of a gear pair varies with the number of tooth pairs in contact. If a tooth is missing, its neighbours
carry the whole load in its place, and the mesh stiffness is lower.
"""

import matplotlib.pyplot as plt

import gearcase

scene = gearcase.Scene.from_file("minimal").changed(
    faults=[{"kind": "missing-tooth", "stage": 1, "gear": "pinion", "tooth": 0}],
)
curve = gearcase.laws(scene)[0].curve()
healthy, faulty = (curve.secant.sel(state=state) / 1e6 for state in ("healthy", "faulty"))

# %%
# At mesh cycle 0 the missing tooth would be in contact at the pitch point:

figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
axes.plot(curve.cycle, healthy, label="healthy")
axes.plot(curve.cycle, faulty, label="one tooth missing")
axes.set(xlabel="mesh cycles", ylabel="secant stiffness, N/um", ylim=(0, None))
axes.legend()

# %%
# Least stiffness of the faulty pair, divided by that of the healthy pair:

ratio = float(faulty.min() / healthy.min())
print(f"{ratio:.2f}")
