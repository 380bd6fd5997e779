"""
Stiffness and mass of another program
=====================================

Any program that exports its stiffness and mass matrices can supply a body. Here a few lines stand for it: a cantilever
of beam elements, reduced to its free end and checked against the theory of beams.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import eigh

import gearcase

LENGTH, COUNT = 0.5, 20  # m, elements
MODULUS, DENSITY = 210e9, 7850.0
AREA, INERTIA = 0.02 * 0.03, 0.02 * 0.03**3 / 12  # of a section 20 mm wide and 30 mm high

# %%
# Two unknowns at a node, the deflection in z (axis 3) and the slope about y (axis 5), sharing four rows an element:

h = LENGTH / COUNT
turn = np.diag([1.0, -h, 1.0, -h])  # a positive rotation about y lowers what lies at larger x
bending = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
inertia = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
stiffness, mass = np.zeros((2, 2 * COUNT + 2, 2 * COUNT + 2))
for i in range(COUNT):
    rows = np.s_[2 * i : 2 * i + 4, 2 * i : 2 * i + 4]
    stiffness[rows] += MODULUS * INERTIA / h**3 * turn @ bending @ turn
    mass[rows] += DENSITY * AREA * h / 420 * turn @ inertia @ turn
nodes = np.column_stack([np.linspace(0, LENGTH, COUNT + 1), np.zeros((COUNT + 1, 2))])
equations = np.array([(node + 1, axis) for node in range(COUNT + 1) for axis in (3, 5)])

# %%
# Node 1 is held; the last one stays as a point, with the modes up to 3 kHz:

tip = gearcase.Point(nodes=(COUNT + 1,), axes=("uz", "ry"))
body = gearcase.reduce(stiffness, mass, {"tip": tip}, nodes=nodes, equations=equations, held=(1,), band=3000)
frequencies = np.sqrt(eigh(body.stiffness, body.mass, eigvals_only=True)) / (2 * np.pi)

# %%
# A cantilever of Euler and Bernoulli: cos(b) cosh(b) = -1, f = b^2 / (2 pi L^2) sqrt(E I / (rho A)):

roots = np.array([1.8751041, 4.6940911, 7.8547574])
exact = roots**2 / (2 * np.pi * LENGTH**2) * np.sqrt(MODULUS * INERTIA / (DENSITY * AREA))
figure, axes = plt.subplots(figsize=(6, 3.5), layout="constrained")
axes.semilogy(exact, abs(frequencies[:3] / exact - 1), "o")
axes.set(xlabel="Hz", ylabel="relative error of the frequency")

# %%

worst = float(max(abs(frequencies[:3] / exact - 1)))
print(f"{frequencies[0]:.2f} Hz of {exact[0]:.2f} Hz, {len(frequencies)} of {len(mass)} unknowns, error {worst:.1e}")
