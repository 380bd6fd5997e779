"""
Waterfall of a run-up
=====================

A waterfall diagram shows spectra over speed. The mesh frequency is proportional to the speed, so mesh lines appear as
rays. Natural frequencies of the structure are constant and appear as vertical lines.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.signal import ShortTimeFFT

import gearcase

scene = gearcase.Scene.from_file("minimal").changed(
    {"drive": {"times_s": [0.0, 1.0], "speeds_rpm": [300.0, 1500.0]}, "diagnosis.windows_s": {}}
)
signal = gearcase.simulate(scene).acceleration.sel(sensor="sensor_3", axis="z")
rate = 1 / float(signal.time[1] - signal.time[0])
short = ShortTimeFFT(np.hanning(2048), hop=256, fs=rate, scale_to="magnitude")
lines = np.abs(short.stft(signal.values - signal.values.mean()))
time = short.t(len(signal))
inside = (time > 0.12) & (time < 0.88)  # whole windows
speed, lines = 300.0 + 1200.0 * time[inside], lines[:, inside]

# %%
# Brightness is the amplitude in dB. The ray is the mesh frequency, order 20 of the pinion shaft:

figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
axes.pcolormesh(short.f, speed, 20 * np.log10(lines.T + 1e-6), vmin=-60, vmax=0)
axes.set(xlabel="frequency, Hz", ylabel="speed, rpm", xlim=(0, 1500))

# %%
# The order of the ray is the median over the speeds. At each speed, the highest line between 0.5 and 1.5 times the
# mesh frequency gives it:

orders = []
for at, column in zip(speed, lines.T, strict=True):
    near = (short.f > 10 * at / 60) & (short.f < 30 * at / 60)
    orders.append(short.f[near][np.argmax(column[near])] / (at / 60))
order = float(np.median(orders))
print(f"order {order:.1f}")
