"""
A reduced casing against its full model
=======================================

Craig-Bampton reduction keeps the bearing seats, the feet and the fixed-interface modes up to a band limit. Up to that
limit the natural frequencies agree with those of the full finite-element model, with a hundredth of its unknowns.
"""

import matplotlib.pyplot as plt

import gearcase

scene = gearcase.Scene.from_file("minimal").changed(
    casing={"model": "craig-bampton", "band_Hz": 2000, "element_size_mm": 25}
)
casing = gearcase.casing(scene, error_check=True)

# %%
# Error of the frequency responses from each bearing to the sensor, in third octaves:

figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
for number, bearing in enumerate(casing.error.bearings):
    axes.loglog(casing.error.third_octaves, 100 * casing.error.response_errors[:, number, 0], label=bearing)
axes.set(xlabel="Hz", ylabel="error of the response, %")
axes.legend()

# %%
# Unknowns, and the largest error of a natural frequency, which a reduction can only raise:

unknowns, kept = casing.modes.unknowns, len(casing.body.mass)
largest = float(casing.error.frequency_errors.max())
print(f"{unknowns} unknowns, {kept} kept, largest error {100 * largest:.2g} %")
