"""
Envelope spectrum of a pitted bearing
=====================================

Every ball that rolls over a pit in the outer ring strikes once. The strikes ring in modes of the machine; the envelope
of that ringing repeats with the pass frequency of the balls.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.signal import butter, hilbert, sosfiltfilt

import gearcase

pit = {"kind": "bearing-spall", "shaft": 1, "bearing": 1, "on": "outer-ring", "width_mm": 1.5, "depth_um": 200.0}
scene = gearcase.Scene.from_file("minimal").changed(
    {"deviations.enabled": False},
    bearings={"model": "hertz", "designation": "6205"},
    shaft_model={"model": "timoshenko"},
    faults=[pit | {"angle_deg": -90.0}],
)
signal = gearcase.simulate(scene).acceleration.sel(sensor="sensor_3", axis="z", time=slice(0.15, None))

# %%
# Filter a band in which structures ring, take the envelope and its spectrum:

rate = 1 / float(signal.time[1] - signal.time[0])
band = sosfiltfilt(butter(4, (1000, 4000), "bandpass", fs=rate, output="sos"), signal.values)
envelope = signal.copy(data=np.abs(hilbert(band)))
lines = gearcase.spectrum(envelope - envelope.mean())

# %%
# Nine balls of 7.94 mm on a circle of 38.5 mm, the shaft at 15 Hz:

expected = 9 / 2 * 15 * (1 - 7.94 / 38.5)
figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
axes.plot(lines.frequency, lines)
for harmonic in range(1, 5):
    axes.axvline(harmonic * expected, color="0.7", lw=0.8, zorder=0)
axes.set(xlabel="Hz", ylabel="m/s2", xlim=(5, 300))

# %%

low = lines.sel(frequency=slice(30, 80))
found = float(low.frequency[int(np.argmax(low.values))])
print(f"{found:.1f} Hz, expected {expected:.1f} Hz")
