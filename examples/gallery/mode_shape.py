"""
A mode of the casing
====================

The first natural mode of an elastic casing on its feet, drawn on the surface of its finite elements.
"""

import matplotlib.pyplot as plt
import numpy as np
import pyvista
from scipy.linalg import eigh

import gearcase

scene = gearcase.Scene.from_file("minimal").changed(
    casing={"model": "craig-bampton", "band_Hz": 2000, "element_size_mm": 25}
)
casing = gearcase.casing(scene)
modes = casing.modes
squares, shapes = eigh(modes.stiffness, modes.mass)
motion = np.real(modes.basis @ shapes[:, 0])  # (node, axis)
frequency = float(casing.frequencies[0])

# %%
# The surface, moved by the mode and coloured by how far:

corners = modes.facets[:, :3]
faces = np.column_stack([np.full(len(corners), 3), corners]).ravel()
size = np.linalg.norm(motion, axis=1)
surface = pyvista.PolyData(modes.nodes + 0.03 * motion / size.max(), faces)
plotter = pyvista.Plotter(off_screen=True, window_size=(900, 600))
plotter.add_mesh(surface, scalars=size / size.max(), cmap="viridis", show_edges=True, show_scalar_bar=False)
picture = plotter.screenshot(return_img=True)
plotter.close()

figure, axes = plt.subplots(figsize=(7, 4.6), layout="constrained")
axes.imshow(picture)
axes.set_axis_off()
axes.set_title(f"{frequency:.0f} Hz")

# %%

print(f"{frequency:.0f} Hz, {len(corners)} facets")
