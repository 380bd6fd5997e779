"""
A reduced casing against its full model
=======================================

Craig-Bampton reduction keeps the coordinates of bearings and feet, and the fixed-interface modes up to a frequency
limit. Up to this limit the natural frequencies agree with those of the full finite-element model, which has more
than a hundred times as many unknowns.
"""

import matplotlib.pyplot as plt

import gearcase

scene = gearcase.Scene.from_file("minimal").changed(
    casing={"model": "craig-bampton", "band_Hz": 2000, "element_size_mm": 25}
)
casing = gearcase.casing(scene, error_check=True)

# %%
# Error of the frequency response from each bearing to the sensor, in third-octave bands:

figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
for number, bearing in enumerate(casing.error.bearings):
    axes.loglog(casing.error.third_octaves, 100 * casing.error.response_errors[:, number, 0], label=bearing)
axes.set(xlabel="frequency, Hz", ylabel="error of the response, %")
axes.legend()

# %%
# Numbers of unknowns before and after the reduction, and the largest error of a natural frequency:

unknowns, kept = casing.modes.unknowns, len(casing.body.mass)
largest = float(casing.error.frequency_errors.max())
print(f"{unknowns} unknowns, {kept} after the reduction, largest error {100 * largest:.2g} %")
