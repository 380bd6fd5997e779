"""
Contact pattern of a gear pair
==============================

The contact pattern is the largest pressure at each point of the flank during its passage through the mesh. Misaligned
gears carry the load at one end of the face. The pressure at the pitch circle is compared with the formula of ISO
6336-2.
"""

import matplotlib.pyplot as plt
import numpy as np

import gearcase

scene = gearcase.Scene.from_file("minimal").changed({"stages.1.mesh": {"model": "plane"}})
found = gearcase.laws(scene)[0]
pair = found.pair
patterns = {tilted: found.pattern(tilt=tilted / pair.face_width) / 1e6 for tilted in (0.0, 10e-6)}

# %%
# The pressure without misalignment, and with 10 micrometres over the face width. The dotted line is the pitch circle:

highest = float(patterns[10e-6].max())
figure, boxes = plt.subplots(1, 2, figsize=(8, 4), sharey=True, layout="constrained")
for axes, (tilted, pattern) in zip(boxes, patterns.items(), strict=True):
    places = 1000 * pattern.face, 1000 * pattern.diameter
    colours = axes.pcolormesh(*places, pattern, vmin=0, vmax=highest, shading="gouraud")
    axes.axhline(2000 * pair.working_radii[0], color="w", lw=1, ls=":")  # pitch circle
    axes.set(xlabel="position along the face, mm", title=f"misalignment {1e6 * tilted:.0f} um")
boxes[0].set_ylabel("diameter on the pinion, mm")
figure.colorbar(colours, ax=boxes, label="Hertz pressure, MPa")

# %%
# Formula of ISO 6336-2 for contact lines of mean length: sigma_H0 = Z_H Z_E Z_eps Z_beta sqrt(F_t / (d_1 b) (u + 1) /
# u), F_t = F cos(alpha_t):

beta, alpha = pair.pinion.helix_angle, pair.working_pressure_angle
zone = np.sqrt(2 * np.cos(pair.base_helix_angle) / (np.cos(alpha) ** 2 * np.tan(alpha)))
elastic = np.sqrt(206e9 / (2 * np.pi * (1 - 0.3**2)))
across, along = pair.transverse_contact_ratio, pair.overlap_ratio
ratio = np.sqrt((4 - across) / 3 * (1 - along) + along / across)
diameter = 2 * pair.working_radii[0]
load = found.force * np.cos(alpha) / (diameter * pair.face_width) * (pair.ratio + 1) / pair.ratio
nominal = float(zone * elastic * ratio / np.sqrt(np.cos(beta)) * np.sqrt(load)) / 1e6
pitch = float(patterns[0.0].sel(diameter=diameter, method="nearest").mean())
print(f"{pitch:.0f} MPa on the pitch circle, {nominal:.0f} MPa by ISO 6336-2, misaligned up to {highest:.0f} MPa")
