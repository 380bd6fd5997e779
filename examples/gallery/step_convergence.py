"""
How far a step is from converged
================================

The same motion with three steps in time. Where the error falls with the step squared, the limit and the band in which
it lies follow from the three.
"""

import matplotlib.pyplot as plt

import gearcase

scene = gearcase.Scene.from_file("minimal").changed(
    {"simulation.end_s": 0.3, "diagnosis.windows_s": {"lifting": [0.1, 0.3]}}
)
study = gearcase.converge(scene, "step")

# %%
# Every quantity, as the distance from its limit:

figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
for name, found in study.quantities.items():
    if found.order is not None:
        axes.loglog(found.sizes, [100 * error for error in found.errors], marker="o", label=name)
axes.set(xlabel="step, relative to that in use", ylabel="error, %")
axes.legend(fontsize="small")

# %%
# The largest error band of the setting in use:

band = max(found.relative_bands[study.in_use] for found in study.quantities.values())
print(f"{100 * band:.2g} %")
