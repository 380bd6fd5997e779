"""
Contact pattern on the unrolled flank
=====================================

The pressure that a tooth feels on its way through the mesh, over face and diameter. Gears that lie askew carry at one
end of the face. ISO 6336-2 has a formula for the pressure on the pitch circle, for contact lines of mean length.
"""

import matplotlib.pyplot as plt
import numpy as np

import gearcase

scene = gearcase.Scene.from_file("minimal").changed({"stages.1.mesh": {"model": "plane"}})
found = gearcase.laws(scene)[0]
pair = found.pair
patterns = {askew: found.pattern(tilt=askew / pair.face_width) / 1e6 for askew in (0.0, 10e-6)}

# %%
# Straight, and with the approach at one end of the face 10 micrometres larger than at the other:

highest = float(patterns[10e-6].max())
figure, boxes = plt.subplots(1, 2, figsize=(8, 4), sharey=True, layout="constrained")
for axes, (askew, pattern) in zip(boxes, patterns.items(), strict=True):
    places = 1000 * pattern.face, 1000 * pattern.diameter
    drawn = axes.pcolormesh(*places, pattern, vmin=0, vmax=highest, shading="gouraud")
    axes.axhline(2000 * pair.working_radii[0], color="w", lw=1, ls=":")  # pitch circle
    axes.set(xlabel="mm along the face", title=f"{1e6 * askew:.0f} um askew")
boxes[0].set_ylabel("diameter on the pinion, mm")
figure.colorbar(drawn, ax=boxes, label="Hertz pressure, MPa")

# %%
# sigma_H0 = Z_H Z_E Z_eps Z_beta sqrt(F_t / (d_1 b) (u + 1) / u), F_t = F cos(alpha_t):

beta, alpha = pair.pinion.helix_angle, pair.working_pressure_angle
zone = np.sqrt(2 * np.cos(pair.base_helix_angle) / (np.cos(alpha) ** 2 * np.tan(alpha)))
elastic = np.sqrt(206e9 / (2 * np.pi * (1 - 0.3**2)))
across, along = pair.transverse_contact_ratio, pair.overlap_ratio
ratio = np.sqrt((4 - across) / 3 * (1 - along) + along / across)
diameter = 2 * pair.working_radii[0]
load = found.force * np.cos(alpha) / (diameter * pair.face_width) * (pair.ratio + 1) / pair.ratio
nominal = float(zone * elastic * ratio / np.sqrt(np.cos(beta)) * np.sqrt(load)) / 1e6
pitch = float(patterns[0.0].sel(diameter=diameter, method="nearest").mean())
print(f"{pitch:.0f} MPa on the pitch circle, {nominal:.0f} MPa by ISO 6336-2, askew up to {highest:.0f} MPa")
