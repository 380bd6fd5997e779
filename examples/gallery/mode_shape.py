"""
A natural mode of the casing
============================

The command ``gearcase inspect`` writes pictures of gears and of casings. This example shows the first natural mode of
an elastic casing on its feet.
"""

import subprocess
import sys
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import gearcase

folder = Path(mkdtemp())
file = folder / "elastic.toml"
file.write_text(
    """
extends = "minimal"
title = "One stage, elastic casing"
casing = { model = "craig-bampton", band_Hz = 2000.0, element_size_mm = 25.0 }
""",
    encoding="utf-8",
)
command = ["inspect", str(file), "--casing-mode", "1", "--out", str(folder), "--quiet"]
subprocess.run([sys.executable, "-m", "gearcase", *command], check=True, capture_output=True)

# %%
# The command writes a picture, an animated GIF and an HTML page with a slider for the phase. This is the picture:

figure, axes = plt.subplots(figsize=(8, 6), layout="constrained")
axes.imshow(plt.imread(folder / "casing-elastic-mode_1.png"))
axes.set_axis_off()

# %%
# Natural frequencies of the casing, computed in Python:

frequencies = gearcase.casing(gearcase.Scene.from_file(file)).frequencies
frequency = float(frequencies[0])
print(frequencies[:4].round(), "Hz")
