"""
Envelope spectrum of a bearing with a spall
===========================================

Each ball that rolls over a spall in the outer ring causes an impact, which excites natural modes of the machine. The
envelope of the response therefore has lines at the ball pass frequency of the outer ring and its multiples.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.signal import butter, hilbert, sosfiltfilt

import gearcase

spall = {"kind": "bearing-spall", "shaft": 1, "bearing": 1, "on": "outer-ring", "width_mm": 1.5, "depth_um": 200.0}
scene = gearcase.Scene.from_file("minimal").changed(
    {"deviations.enabled": False},
    bearings={"model": "hertz", "designation": "6205"},
    shaft_model={"model": "timoshenko"},
    faults=[spall | {"angle_deg": -90.0}],
)
signal = gearcase.simulate(scene).acceleration.sel(sensor="sensor_3", axis="z", time=slice(0.15, None))

# %%
# Band-pass filter around natural frequencies, then the spectrum of the envelope:

rate = 1 / float(signal.time[1] - signal.time[0])
band = sosfiltfilt(butter(4, (1000, 4000), "bandpass", fs=rate, output="sos"), signal.values)
envelope = signal.copy(data=np.abs(hilbert(band)))
lines = gearcase.spectrum(envelope - envelope.mean())

# %%
# The bearing has nine balls of 7.94 mm diameter on a pitch diameter of 38.5 mm, and the shaft turns at 15 Hz. These
# numbers give the ball pass frequency. Grey lines show it and its multiples:

expected = 9 / 2 * 15 * (1 - 7.94 / 38.5)
figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
axes.plot(lines.frequency, lines)
for harmonic in range(1, 5):
    axes.axvline(harmonic * expected, color="0.7", lw=0.8, zorder=0)
highest = float(lines.sel(frequency=slice(5, 280)).max())  # the mesh line at 300 Hz is thirty times higher
axes.set(xlabel="frequency, Hz", ylabel="envelope of the acceleration, m/s2", xlim=(5, 280), ylim=(0, 1.1 * highest))

# %%
# The highest line between 30 and 80 Hz:

low = lines.sel(frequency=slice(30, 80))
found = float(low.frequency[int(np.argmax(low.values))])
print(f"{found:.1f} Hz, expected {expected:.1f} Hz")
